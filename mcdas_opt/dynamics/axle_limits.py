"""What the axles of a car leave of its friction circle: their loads shift with its acceleration, the brakes may have a fixed split, and the
engine may turn one of them alone.

Source: Gillespie, Fundamentals of Vehicle Dynamics, SAE 1992, ch. 1 (dynamic axle loads) and 3 (brake proportioning). Loads and pulls are
those of `single_track`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.rules import non_negative, positive, require, within
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, DrivenAxle, Vehicle


@dataclass(frozen=True, slots=True, kw_only=True)
class AxleLimits:
    """Of the axle that gives way first: braking the rear one, or the front one where the brakes' split says so; driving the driven one.
    Shares are of the load that it carries at rest.

    With these numbers a car as a whole has the friction circle of `ocp.terms.FrictionCircle`.
    """

    braking_unloads: float = 0.0  # [s^2/m] of the braked axle's load; less than 0 of the front one, which braking loads
    brakes_by_load: float = 1.0  # 1: braking is shared by load; 0: by `braking_pull`
    braking_pull: float = 0.0  # braking force of the axle over its share of the mass, per deceleration of the car
    driving_unloads: float = 0.0  # [s^2/m] of the driven axle's load
    driving_pull: float = 1.0  # force of the driven axle over its share of the mass, per acceleration of the car

    def __post_init__(self) -> None:
        within("braking_unloads", self.braking_unloads, -0.5, 0.5, "s^2/m")
        within("brakes_by_load", self.brakes_by_load, 0.0, 1.0)
        require(self, non_negative, "braking_pull", "driving_unloads")
        require(self, positive, "driving_pull")

    @classmethod
    def of(cls, chassis: Chassis, friction: float) -> AxleLimits:
        """On a road of that friction. A car that drives all wheels shares the pull by load: driving costs it nothing at the rear. What
        driving presses on a driven rear axle is left out: the front one loses it."""
        c = chassis
        braking = {"braking_unloads": c.cog_height_m / (GRAVITY_MPS2 * c.cog_to_front_axle_m)} | _split(c, friction)
        if c.driven_axle is DrivenAxle.BOTH:
            return cls(**braking)
        if c.driven_axle is DrivenAxle.REAR:
            return cls(**braking, driving_pull=c.wheelbase_m / c.cog_to_front_axle_m)
        to_front = c.cog_height_m / (GRAVITY_MPS2 * c.cog_to_rear_axle_m)
        return cls(**braking, driving_unloads=to_front, driving_pull=c.wheelbase_m / c.cog_to_rear_axle_m)


def available_mps2(vehicle: Vehicle, friction: float) -> tuple[float, float]:
    """The most that it brakes, and that it accelerates, straight on, on a road of that friction: both greater than 0."""
    grip = friction * GRAVITY_MPS2
    return min(-vehicle.acceleration_min_mps2, grip), min(driving_mps2(vehicle, friction), grip)


def driving_mps2(vehicle: Vehicle, friction: float) -> float:
    """The most that its engine accelerates it, straight on: no more than the axle that it turns can hold, where it turns but one."""
    if vehicle.driven_axle is DrivenAxle.BOTH:
        return vehicle.acceleration_max_mps2
    return _driving_one_axle_mps2(vehicle, friction)


@lru_cache(maxsize=64)
def _driving_one_axle_mps2(vehicle: Vehicle, friction: float) -> float:
    limits, grip = AxleLimits.of(Chassis.of(vehicle), friction), friction * GRAVITY_MPS2
    return min(vehicle.acceleration_max_mps2, grip / (limits.driving_pull + grip * limits.driving_unloads))


def _split(c: Chassis, friction: float) -> dict[str, float]:
    """Of the axle that a fixed split of the brakes brings to its friction first, straight ahead; nothing where they share by load."""
    if c.brake_share_front is None:
        return {}
    by_load = (c.cog_to_rear_axle_m + friction * c.cog_height_m) / c.wheelbase_m  # of the front axle, braked as hard as the road allows
    if c.brake_share_front <= by_load:
        return {"brakes_by_load": 0.0, "braking_pull": (1.0 - c.brake_share_front) * c.wheelbase_m / c.cog_to_front_axle_m}
    return {
        "braking_unloads": -c.cog_height_m / (GRAVITY_MPS2 * c.cog_to_rear_axle_m),
        "brakes_by_load": 0.0,
        "braking_pull": c.brake_share_front * c.wheelbase_m / c.cog_to_rear_axle_m,
    }
