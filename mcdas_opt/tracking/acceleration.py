"""How a target's speed along the road, or across it, changes: a constant-acceleration filter above the constant-velocity one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mcdas_opt.tracking.rate_filter import RateFilter

JERK_MPS3 = 2.0  # density of the white jerk, per root Hz: what tells 5 m/s^2 from none in some 0.3 s, and noise from 2 m/s^2
CORRELATION = 1.5  # the tracked speed's errors are not independent from scan to scan: its variance counts so many times
FIRST_SD_MPS2 = 4.0  # what cars can do


@dataclass(slots=True)
class AccelerationFilter:
    """Measured by the speed that the constant-velocity filter has after each hit."""

    speed: RateFilter = field(default_factory=lambda: RateFilter(density=JERK_MPS3, first_sd=FIRST_SD_MPS2))

    def take(self, time_s: float, speed_mps: float, variance: float) -> None:
        """The tracked speed at that time, with its variance; what comes from before the filter's own time counts as of now."""
        self.speed.take(time_s, speed_mps, CORRELATION * variance)

    def at(self, time_s: float) -> tuple[float, float | None]:
        """(acceleration, its standard deviation) believed at `time_s`; 0 and None where nothing is known."""
        if not self.speed.has_begun:
            return 0.0, None
        return self.speed.rate, math.sqrt(self.speed.variance_at(time_s))
