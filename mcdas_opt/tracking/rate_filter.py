"""How fast something that is measured changes: a Kalman filter of it and its rate."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(slots=True, kw_only=True)
class RateFilter:
    """State (value, rate) at `time_s`: constant rate, driven by white noise (Bar-Shalom, Li, Kirubarajan, Estimation, 2001, section
    6.2.2) of that `density` per root Hz. Scalars: five numbers are no matrix.

    Of the rate nothing is known at first but its standard deviation `first_sd`. Values that differ by a `period` are the same.
    """

    density: float
    first_sd: float
    period: float = math.inf
    time_s: float = 0.0
    value: float = 0.0
    rate: float = 0.0
    variance_value: float = 0.0
    covariance: float = 0.0
    variance_rate: float = math.inf

    @property
    def has_begun(self) -> bool:
        """Whether anything has been measured."""
        return not math.isinf(self.variance_rate)

    def take(self, time_s: float, value: float, variance: float) -> float | None:
        """The value at that time, with its variance; what comes from before the filter's own time counts as of now. The square of its
        innovation over what that was expected to be; None where there is none yet."""
        if not self.has_begun:
            self.time_s, self.value, self.rate = time_s, value, 0.0
            self.variance_value, self.covariance, self.variance_rate = variance, 0.0, self.first_sd**2
            return None
        dt, q = max(time_s - self.time_s, 0.0), self.density**2
        p_value = self.variance_value + 2.0 * dt * self.covariance + dt**2 * self.variance_rate + q * dt**3 / 3.0
        p_both = self.covariance + dt * self.variance_rate + q * dt**2 / 2.0
        p_rate = self.variance_rate + q * dt
        innovation = math.remainder(value - (self.value + dt * self.rate), self.period)
        spread = p_value + variance
        if spread <= 0.0:
            return None
        gain_value, gain_rate = p_value / spread, p_both / spread
        self.time_s = max(time_s, self.time_s)
        self.value += dt * self.rate + gain_value * innovation
        self.rate += gain_rate * innovation
        self.variance_value = (1.0 - gain_value) * p_value
        self.covariance = (1.0 - gain_value) * p_both
        self.variance_rate = max(p_rate - gain_rate * p_both, 0.0)
        return innovation * innovation / spread

    def variance_at(self, time_s: float) -> float:
        """Of the rate, at that time."""
        return self.variance_rate + self.density**2 * abs(time_s - self.time_s)
