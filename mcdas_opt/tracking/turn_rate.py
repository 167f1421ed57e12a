"""How fast a target turns, by its heading in the plane."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mcdas_opt.tracking.rate_filter import RateFilter

HEADING_SD_RAD = 0.01  # of a sensor that tells headings
YAW_ACCELERATION_RADPS2 = 0.3  # density of the white one, per root Hz: what follows a car into a turn within some 0.3 s
FIRST_SD_RADPS = 0.5
_FORGETTING = 0.1  # share of the newest innovation in the mean of their squares


def _heading() -> RateFilter:
    return RateFilter(density=YAW_ACCELERATION_RADPS2, first_sd=FIRST_SD_RADPS, period=2.0 * math.pi)


@dataclass(slots=True)
class TurnRateFilter:
    """Constant turn rate; the speed is left to the constant-velocity filter (Bar-Shalom, Li, Kirubarajan, Estimation, 2001, section 11.7).

    Where headings are noisier than told, innovations are larger than expected: the standard deviation grows with the root of their mean
    normalised square (section 5.4), so that noise is not taken for turning.
    """

    heading: RateFilter = field(default_factory=_heading)
    innovation_square: float = 1.0

    def take(self, time_s: float, heading_rad: float) -> None:
        """The heading in the plane [rad] at that time; what comes from before the filter's own time counts as of now."""
        square = self.heading.take(time_s, heading_rad, HEADING_SD_RAD**2)
        if square is not None:
            self.innovation_square += _FORGETTING * (square - self.innovation_square)

    def at(self, time_s: float) -> tuple[float, float | None]:
        """(turn rate, its standard deviation) believed at `time_s`; 0 and None where nothing is known."""
        if not self.heading.has_begun:
            return 0.0, None
        return self.heading.rate, math.sqrt(self.heading.variance_at(time_s) * max(self.innovation_square, 1.0))
