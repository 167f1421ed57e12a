"""Hundreds of bodies, in one place or along the road, who stay or are others in the next cycle, while sectors go blind."""

from __future__ import annotations

from benchmarks.attack.campaign import cycles
from benchmarks.attack.strategies import crowds
from benchmarks.attack.tally import Tally

_CYCLES = 3  # of a crowd


def attack(tally: Tally, count: int, seed: int) -> None:
    cycles(crowds(_CYCLES), tally, max(count // _CYCLES, 1), seed)
