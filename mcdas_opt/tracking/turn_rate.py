"""How fast a target turns: a Kalman filter of its heading in the plane, with a turn rate that changes at random."""

from __future__ import annotations

import math
from dataclasses import dataclass

HEADING_SD_RAD = 0.01  # of a sensor that tells headings
YAW_ACCELERATION_RADPS2 = 0.3  # density of the white one, per root Hz: what follows a car into a turn within some 0.3 s
FIRST_SD_RADPS = 0.5
_FORGETTING = 0.1  # share of the newest innovation in the mean of their squares


@dataclass(slots=True)
class TurnRateFilter:
    """State (heading, turn rate) at `time_s`: constant turn rate, driven by white yaw acceleration (Bar-Shalom, Li, Kirubarajan,
    Estimation, 2001, sections 6.2.2 and 11.7; the speed is left to the constant-velocity filter).

    Where headings are noisier than told, innovations are larger than expected: the standard deviation grows with the root of their mean
    normalised square (section 5.4), so that noise is not taken for turning.
    """

    time_s: float = 0.0
    heading_rad: float = 0.0
    rate_radps: float = 0.0
    variance_heading: float = 0.0
    covariance: float = 0.0
    variance_rate: float = math.inf
    innovation_square: float = 1.0

    def take(self, time_s: float, heading_rad: float) -> None:
        """The heading in the plane [rad] at that time; what comes from before the filter's own time counts as of now."""
        if math.isinf(self.variance_rate):
            self.time_s, self.heading_rad, self.rate_radps = time_s, heading_rad, 0.0
            self.variance_heading, self.covariance, self.variance_rate = HEADING_SD_RAD**2, 0.0, FIRST_SD_RADPS**2
            return
        dt = max(time_s - self.time_s, 0.0)
        q = YAW_ACCELERATION_RADPS2**2
        phh = self.variance_heading + 2.0 * dt * self.covariance + dt**2 * self.variance_rate + q * dt**3 / 3.0
        phr = self.covariance + dt * self.variance_rate + q * dt**2 / 2.0
        prr = self.variance_rate + q * dt
        innovation = math.remainder(heading_rad - (self.heading_rad + dt * self.rate_radps), 2.0 * math.pi)
        spread = phh + HEADING_SD_RAD**2
        gain_h, gain_r = phh / spread, phr / spread
        self.time_s = max(time_s, self.time_s)
        self.heading_rad += dt * self.rate_radps + gain_h * innovation
        self.rate_radps += gain_r * innovation
        self.variance_heading = (1.0 - gain_h) * phh
        self.covariance = (1.0 - gain_h) * phr
        self.variance_rate = max(prr - gain_r * phr, 0.0)
        self.innovation_square += _FORGETTING * (innovation * innovation / spread - self.innovation_square)

    def at(self, time_s: float) -> tuple[float, float | None]:
        """(turn rate, its standard deviation) believed at `time_s`; 0 and None where nothing is known."""
        if math.isinf(self.variance_rate):
            return 0.0, None
        variance = self.variance_rate + YAW_ACCELERATION_RADPS2**2 * abs(time_s - self.time_s)
        return self.rate_radps, math.sqrt(variance * max(self.innovation_square, 1.0))
