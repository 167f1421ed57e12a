"""Whether a radar's range rates are believed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from mcdas_opt.domain.measurement import RadarDetection

_UNKNOWN_MPS = 30.0  # sd of a range rate that is not believed
_DISBELIEVED_S = 60.0  # then they are tried again: tracks go on meanwhile


@dataclass(slots=True)
class RangeRates:
    """Those of one radar. Where they are not believed, who is there is tracked by places alone, if these are right."""

    _disbelieved_s: float = field(default=-math.inf, init=False)

    def disbelieve(self, t_s: float) -> None:
        """For a while from `t_s` on."""
        self._disbelieved_s = t_s

    def are_believed(self, t_s: float) -> bool:
        return not 0.0 <= t_s - self._disbelieved_s <= _DISBELIEVED_S

    def as_believed(self, points: Sequence[RadarDetection], t_s: float) -> Sequence[RadarDetection]:
        """The returns of that time, each with the uncertainty of its rate."""
        return points if self.are_believed(t_s) else [replace(point, range_rate_sd_mps=_UNKNOWN_MPS) for point in points]
