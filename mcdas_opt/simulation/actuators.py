"""The limits of every plant's actuators."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.simulation.idm import STEP_S

_AT_REST_MPS = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class Applied:
    """What the actuators did over one step: jerk, steering rate, and the lateral acceleration of the path at the beginning of the step
    (v^2 kappa without slip, else the one the tyres' forces give the centre of gravity)."""

    jerk_mps3: float
    steering_rate_radps: float
    lateral_acceleration_mps2: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Actuators:
    """Limits of the vehicle and of the road under it; the acceleration ends at mu g as well."""

    vehicle: Vehicle
    friction: float
    grip_mps2: float = field(init=False)
    acceleration_range: tuple[float, float] = field(init=False)

    def __post_init__(self) -> None:
        require_types(self)
        grip = self.friction * GRAVITY_MPS2
        object.__setattr__(self, "grip_mps2", grip)
        low, high = max(self.vehicle.acceleration_min_mps2, -grip), min(self.vehicle.acceleration_max_mps2, grip)
        object.__setattr__(self, "acceleration_range", (low, high))

    def hold(self, v: float, a: float, delta: float) -> tuple[float, float]:
        """The nearest acceleration and steering angle there can be at speed v."""
        low, high = self.acceleration_range
        return clip(a, 0.0 if v <= 0.0 else low, high), clip(delta, -self.vehicle.steering_max_rad, self.vehicle.steering_max_rad)

    def follow(self, jerk: float, rate: float, v: float, a: float, delta: float) -> tuple[float, float]:
        """Jerk and steering rate as far as they can be followed over one step: within their own limits, and ending where the
        acceleration (not past 0 at either end of the speed) or the steering angle meets its limit."""
        car = self.vehicle
        low, high = self.acceleration_range
        low, high = (0.0 if v <= 0.0 else low), (0.0 if v >= car.speed_max_mps else high)
        jerk = _towards(clip(jerk, car.jerk_min_mps3, car.jerk_max_mps3), a, low, high)
        rate = clip(rate, -car.steering_rate_max_radps, car.steering_rate_max_radps)
        return jerk, _towards(rate, delta, -car.steering_max_rad, car.steering_max_rad)

    def steering_held(self, v: float, a: float, delta: float) -> float:
        """The steering angle as far as the friction circle allows its curvature beside the acceleration."""
        left, wheelbase = math.sqrt(max(self.grip_mps2**2 - a**2, 0.0)), self.vehicle.wheelbase_m
        if abs(v**2 * math.tan(delta)) <= left * wheelbase:
            return delta
        return math.copysign(math.atan(wheelbase * left / v**2), delta)


def clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def _towards(rate: float, value: float, low: float, high: float) -> float:
    """`rate`, slowed so that `value` stays within its limits over one step."""
    return clip(rate, min((low - value) / STEP_S, 0.0), max((high - value) / STEP_S, 0.0))


def standstill_after(v: float, a: float, jerk: float) -> float:
    """Time [s] until v + a t + jerk t^2 / 2 falls below 0, at least STEP_S when it does not within a step."""
    if v + a * STEP_S + 0.5 * jerk * STEP_S**2 >= 0.0:
        return STEP_S
    if v <= _AT_REST_MPS:
        return 0.0
    root = math.sqrt(max(a * a - 2.0 * jerk * v, 0.0))
    return (a + root) / -jerk if a > 0.0 else 2.0 * v / (root - a)
