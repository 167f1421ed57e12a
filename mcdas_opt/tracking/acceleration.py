"""How a target's speed along the road changes: a constant-acceleration Kalman filter above the constant-velocity one."""

from __future__ import annotations

import math
from dataclasses import dataclass

JERK_MPS3 = 2.0  # density of the white jerk, per root Hz: what tells 5 m/s^2 from none in some 0.3 s, and noise from 2 m/s^2
CORRELATION = 1.5  # the tracked speed's errors are not independent from scan to scan: its variance counts so many times
FIRST_SD_MPS2 = 4.0


@dataclass(slots=True)
class AccelerationFilter:
    """State (speed, acceleration) at `time_s`, measured by the speed that the constant-velocity filter has after each hit.

    The transition is that of constant acceleration, driven by white jerk (Bar-Shalom, Li, Kirubarajan, Estimation, 2001, section 6.2.3,
    one derivative up). Scalars: five numbers are no matrix.
    """

    time_s: float = 0.0
    speed_mps: float = 0.0
    acceleration_mps2: float = 0.0
    variance_speed: float = 0.0
    covariance: float = 0.0
    variance_acceleration: float = math.inf

    def begin(self, time_s: float, speed_mps: float, variance: float) -> None:
        """Nothing is known yet of the acceleration but what cars can do."""
        self.time_s, self.speed_mps, self.acceleration_mps2 = time_s, speed_mps, 0.0
        self.variance_speed, self.covariance, self.variance_acceleration = CORRELATION * variance, 0.0, FIRST_SD_MPS2**2

    def take(self, time_s: float, speed_mps: float, variance: float) -> None:
        """The tracked speed at that time, with its variance; what comes from before the filter's own time counts as of now."""
        if math.isinf(self.variance_acceleration):
            self.begin(time_s, speed_mps, variance)
            return
        dt = max(time_s - self.time_s, 0.0)
        q = JERK_MPS3**2
        pvv = self.variance_speed + 2.0 * dt * self.covariance + dt**2 * self.variance_acceleration + q * dt**3 / 3.0
        pva = self.covariance + dt * self.variance_acceleration + q * dt**2 / 2.0
        paa = self.variance_acceleration + q * dt
        innovation = speed_mps - (self.speed_mps + dt * self.acceleration_mps2)
        spread = pvv + CORRELATION * variance
        if spread <= 0.0:
            return
        gain_v, gain_a = pvv / spread, pva / spread
        self.time_s = max(time_s, self.time_s)
        self.speed_mps += dt * self.acceleration_mps2 + gain_v * innovation
        self.acceleration_mps2 += gain_a * innovation
        self.variance_speed = (1.0 - gain_v) * pvv
        self.covariance = (1.0 - gain_v) * pva
        self.variance_acceleration = max(paa - gain_a * pva, 0.0)

    def at(self, time_s: float) -> tuple[float, float | None]:
        """(acceleration, its standard deviation) believed at `time_s`; 0 and None where nothing is known."""
        if math.isinf(self.variance_acceleration):
            return 0.0, None
        return self.acceleration_mps2, math.sqrt(self.variance_acceleration + JERK_MPS3**2 * abs(time_s - self.time_s))
