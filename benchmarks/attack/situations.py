"""Absurd traffic: a judged plan or a least severe one, finite, of a planner that has just planned something else."""

from __future__ import annotations

from benchmarks.attack.campaign import examples
from benchmarks.attack.strategies import situations
from benchmarks.attack.tally import Tally
from mcdas_opt import Planner, Situation

_RESET_EVERY = 3
_EACH = 8  # situations of a draw


def attack(tally: Tally, count: int, seed: int) -> None:
    planner = Planner()

    def ask(asked: tuple[Situation, ...]) -> None:
        for situation in asked:
            if tally.tried % _RESET_EVERY == 0:
                planner.reset()
            plan = tally.ask(lambda situation=situation: planner.plan(situation), situation.to_json, may_refuse=False)
            if plan is not None:
                tally.check_plan(plan, situation)

    examples(situations(), ask, max(count // _EACH, 1), seed)
