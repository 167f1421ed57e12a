"""Hypothesis as a source of cases: as many as are asked for, the same for the same seed, none of them kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded
from hypothesis.strategies import SearchStrategy

from benchmarks.attack.tally import Tally
from mcdas_opt import Planner, Situation

T = TypeVar("T")


def examples(strategy: SearchStrategy[T], ask: Callable[[T], None], count: int, seed: int) -> None:
    """Calls `ask` with about `count` examples. What it finds it counts, so that a fault does not end the campaign."""

    @seeded(seed)
    @settings(max_examples=count, deadline=None, database=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
    @given(strategy)
    def each(example: T) -> None:
        ask(example)

    each()


def cycles(strategy: SearchStrategy[tuple[Situation, ...]], tally: Tally, count: int, seed: int) -> None:
    """Has one planner, which begins anew with each of about `count` examples, plan for the situations of each in turn."""
    planner = Planner()

    def ask(asked: tuple[Situation, ...]) -> None:
        planner.reset()
        for situation in asked:
            plan = tally.ask(lambda situation=situation: planner.plan(situation), situation.to_json, may_refuse=False)
            if plan is not None:
                tally.check_plan(plan, situation)

    examples(strategy, ask, count, seed)
