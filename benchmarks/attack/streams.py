"""Scans under every clock, of radars that say anything, beside a host's state that glitches: a plan every cycle."""

from __future__ import annotations

from functools import partial

from benchmarks.attack.campaign import examples
from benchmarks.attack.strategies import Heard, streams
from benchmarks.attack.tally import Tally
from mcdas_opt import Planner, Road

_CYCLES = 15  # of a stream on its roads, about


def attack(tally: Tally, count: int, seed: int) -> None:
    """So many cycles, about."""
    planner = Planner()

    def ask(asked: tuple[tuple[Road, ...], list[Heard]]) -> None:
        roads, heard = asked
        for road in roads:
            planner.reset()
            for k, now in enumerate(heard):
                said = heard[: k + 1]
                step = partial(planner.step, now.scans, now.host, now.now_s, road=road)
                plan = tally.ask(step, lambda said=said, road=road: repr((road, said)), may_refuse=False)
                if plan is not None and planner.situation is not None:
                    tally.check_plan(plan, planner.situation)

    examples(streams(), ask, max(count // _CYCLES, 1), seed)
