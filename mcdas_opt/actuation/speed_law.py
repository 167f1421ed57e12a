"""Eq 11 corrected: towards the wanted speed as fast as limits on acceleration and jerk allow, without overshoot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array, positive
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedLimits:
    """Bounds of the speed law; the minima are negative."""

    acceleration_min_mps2: float
    acceleration_max_mps2: float
    jerk_min_mps3: float
    jerk_max_mps3: float

    def __post_init__(self) -> None:
        for name, unit in (("acceleration_max_mps2", "m/s^2"), ("jerk_max_mps3", "m/s^3")):
            positive(name, getattr(self, name), unit)
        for name, unit in (("acceleration_min_mps2", "m/s^2"), ("jerk_min_mps3", "m/s^3")):
            if not -np.inf < getattr(self, name) < 0.0:
                raise ParameterError(name, getattr(self, name), "must be finite and less than 0", unit)

    @classmethod
    def of(cls, vehicle: Vehicle, jerk_share: float = 1.0) -> SpeedLimits:
        """The vehicle's own limits, of its jerk only a share (the rest is left to a loop that follows the law)."""
        return cls(
            acceleration_min_mps2=vehicle.acceleration_min_mps2,
            acceleration_max_mps2=vehicle.acceleration_max_mps2,
            jerk_min_mps3=vehicle.jerk_min_mps3 * jerk_share,
            jerk_max_mps3=vehicle.jerk_max_mps3 * jerk_share,
        )


def next_acceleration(acceleration: Any, speed_error: Any, step_s: float, limits: SpeedLimits) -> Array:
    """Acceleration [m/s^2] at the end of the step, the jerk being constant within it; `speed_error` = wanted - present speed [m/s].

    The largest a that can still be taken back to zero in time: with c the jerk that takes it back, h the step and e the error left
    after the step's first half, a^2 / (2 c) + a h = e (the h pays for whole samples). Near the goal it is linear in the error. An
    acceleration outside its own bounds comes back as fast as the jerk allows.
    """
    h = step_s
    left = np.asarray(speed_error, dtype=np.float64) - 0.5 * h * np.asarray(acceleration, dtype=np.float64)
    taking_back = np.where(left >= 0.0, -limits.jerk_min_mps3, limits.jerk_max_mps3)
    size = taking_back * (np.sqrt(h**2 + 2.0 * np.abs(left) / taking_back) - h)
    wanted = np.clip(np.sign(left) * size, limits.acceleration_min_mps2, limits.acceleration_max_mps2)
    return np.asarray(np.clip(wanted, acceleration + h * limits.jerk_min_mps3, acceleration + h * limits.jerk_max_mps3))
