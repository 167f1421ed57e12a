"""Answers that are due, of planners beside processes that never wait: judged, and how many were there in time."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.attack.tally import HANG_S, Tally
from benchmarks.deadlines import FAMILIES, Timed, busy

_DEADLINES_MS = (5, 10, 20, 50)
_LOAD = 2


def attack(tally: Tally, count: int, seed: int) -> None:
    """So many cycles, about, over all deadlines. Time is counted by the processor's own clock, and by the wall's."""
    with busy(_LOAD):
        for deadline_ms in _DEADLINES_MS:
            timed, worst_s = Timed(1e-3 * deadline_ms), tally.worst_s
            tally.ask(
                lambda timed=timed: timed.drive(FAMILIES, max(count // len(_DEADLINES_MS), len(FAMILIES)), seed),
                lambda: f"seed {seed}",
                may_refuse=False,
                most_s=math.inf,
            )
            own, wall = np.array(timed.own_s), np.array(timed.wall_s)
            tally.tried, tally.answered = tally.tried - 1 + own.size, tally.answered - 1 + own.size
            tally.hangs += int((own > HANG_S).sum())
            tally.unverified += timed.unverified
            tally.worst_s = max(worst_s, float(own.max()))  # of an answer, where `ask` has timed them all together
            for clock, took in (("own", own), ("wall", wall)):
                tally.add(f"{deadline_ms} ms in time by the {clock} clock", int((took <= 1e-3 * deadline_ms).sum()))
            tally.add(f"{deadline_ms} ms", own.size)
