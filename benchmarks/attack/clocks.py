"""A drive by two clocks at once, one that began at 0 and one of Unix time: a plan every cycle, and the same decisions."""

from __future__ import annotations

from functools import partial

from benchmarks.attack.tally import Tally
from benchmarks.endurance import resident_kib
from benchmarks.long_drive import decided, driven, places_apart_m


def attack(tally: Tally, count: int, seed: int) -> None:
    """So many cycles; `different` are those whose decisions are not the same."""
    before_kib, farthest_m = resident_kib(), 0.0
    drive = driven(count, seed)
    for k in range(count):
        plans = tally.ask(partial(next, drive), lambda k=k: f"cycle {k}", may_refuse=False)
        if plans is None:  # it raised: the drive is over
            return
        first, other, _ = plans
        farthest_m = max(farthest_m, places_apart_m(first, other))
        if decided(first) != decided(other):
            tally.different += 1
            tally.note("decisions that differ", f"cycle {k}: {decided(first)}, {decided(other)}")
    tally.add("micrometres apart, the farthest of each drive", round(1e6 * farthest_m))
    tally.add("KiB that memory grew", round(resident_kib() - before_kib))
