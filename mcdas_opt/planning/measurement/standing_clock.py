"""A clock that does not go on from cycle to cycle."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

CYCLES = 10  # the scans of one cycle may come in several calls, but not in so many
_LEAST_S = 1e-3  # that a clock which goes on shows between the first and the last of them


@dataclass(slots=True)
class StandingClock:
    """Remembers what the clock showed in the last cycles."""

    _shown: deque[float] = field(default_factory=lambda: deque(maxlen=CYCLES))

    def stands(self, now: float) -> bool:
        """Whether the clock, which shows `now`, has hardly moved in the last ten cycles, this one among them."""
        self._shown.append(now)
        return len(self._shown) == CYCLES and max(self._shown) - min(self._shown) < _LEAST_S
