"""A clock that does not go on from cycle to cycle."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise

from mcdas_opt.tracking.screening import clock_fault

CYCLES = 10  # the scans of one cycle may come in several calls, but not in so many
_LEAST_S = 1e-3  # that a clock which goes on shows between the first and the last of them
_LEAST_SHARE = 0.3  # of the way that it makes to and fro; a jittering one that goes on shows more


@dataclass(slots=True)
class StandingClock:
    """Remembers what the clock showed in the last cycles."""

    _shown: deque[float] = field(default_factory=lambda: deque(maxlen=CYCLES))

    def stands(self, now: float) -> bool:
        """Whether the clock, which shows `now`, has hardly gone on in the last ten cycles, this one among them, or has run back a
        little in each. One that is set back (`clock_fault`) may go on from there."""
        if self._shown and clock_fault(now, self._shown[-1]) is not None:
            self._shown.clear()
        self._shown.append(now)
        if len(self._shown) < CYCLES:
            return False
        to_and_fro_s = sum(abs(after - before) for before, after in pairwise(self._shown))
        return self._shown[-1] - self._shown[0] < max(_LEAST_S, _LEAST_SHARE * to_and_fro_s)
