"""Live on radars that flood, stall, restart and talk nonsense, on a clock of its own: a line every cycle, every plan judged."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from benchmarks.attack.tally import Tally
from benchmarks.endurance import resident_kib
from benchmarks.live_hours import HostileBus, live
from mcdas_opt import Status
from mcdas_opt.interop.live.record import Line


def attack(tally: Tally, count: int, seed: int) -> None:
    """So many cycles at 20 Hz."""
    before_kib, bus, lines = resident_kib(), HostileBus(seed), 0

    def heard(line: Line) -> None:
        nonlocal lines
        lines += 1
        if line.passed is False and line.status != Status.UNAVOIDABLE.value:
            tally.unverified += 1
            tally.note(f"unverified, called {line.status}", line.reason)
        if line.status == "fault":
            tally.foreign += 1
            tally.note(f"the planner failed: {line.reason[:80]}", line.reason)

    sessions: Iterator[object] = live(count, bus, heard)
    tally.ask(partial(list, sessions), lambda: f"seed {seed}", may_refuse=False, most_s=math.inf)
    tally.tried, tally.answered, tally.lost = count, lines, max(count - lines, 0)
    for fault, begun in bus.begun.items():
        tally.add(f"{fault} begun", begun)
    tally.add("KiB that memory grew", round(resident_kib() - before_kib))
