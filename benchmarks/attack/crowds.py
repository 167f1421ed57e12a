"""Hundreds of bodies, in one place or along the road, who stay or are others in the next cycle, while sectors go blind."""

from __future__ import annotations

from benchmarks.attack.campaign import examples
from benchmarks.attack.strategies import crowds
from benchmarks.attack.tally import Tally
from mcdas_opt import Planner, Situation

_CYCLES = 3  # of a crowd


def attack(tally: Tally, count: int, seed: int) -> None:
    planner = Planner()

    def ask(asked: tuple[Situation, ...]) -> None:
        planner.reset()
        for situation in asked:
            plan = tally.ask(lambda situation=situation: planner.plan(situation), situation.to_json, may_refuse=False)
            if plan is not None:
                tally.check_plan(plan, situation)

    examples(crowds(_CYCLES), ask, max(count // _CYCLES, 1), seed)
