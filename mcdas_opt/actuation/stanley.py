"""The steering law of the car Stanley, with the understeer of tyres as feed-forward, and yaw damping.

Source: Hoffmann, Tomlin, Montemerlo and Thrun, Autonomous automobile trajectory tracking for off-road driving, American Control Conference
2007, eq 5 and section III: heading error, atan of the cross-track error of the *front axle* over the speed, and yaw damping.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mcdas_opt.actuation.plan_tracking import PathError
from mcdas_opt.domain.vehicle import Vehicle


@dataclass(frozen=True, slots=True, kw_only=True)
class Stanley:
    """A `SteeringLaw`. The cross-track error decays with `gain_hz` where wheels follow; `softening_mps` bounds its effect at low speed."""

    vehicle: Vehicle
    gain_hz: float = 2.5
    softening_mps: float = 1.0
    damping_s: float = 0.1
    lead_s: float = 0.12

    def wheels_rad(self, error: PathError) -> float:
        car = self.vehicle
        to_front = 0.5 * (car.wheelbase_m + car.rear_overhang_m - car.front_overhang_m)  # from the body centre
        off = error.lateral_m + to_front * math.sin(error.heading_rad)
        steered_back = math.atan(self.gain_hz * off / (self.softening_mps + error.speed_mps))
        return error.feed_forward_rad - error.heading_rad - steered_back - self.damping_s * error.yaw_rate_radps
