"""What the axles of a car leave of its friction circle: their loads shift with its acceleration, and the engine may turn one of them alone.

Source: Gillespie, Fundamentals of Vehicle Dynamics, SAE 1992, ch. 1 (dynamic axle loads). Loads and pulls are those of `single_track`.
"""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.rules import non_negative, positive, require
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, DrivenAxle


@dataclass(frozen=True, slots=True, kw_only=True)
class AxleLimits:
    """Of the axle that gives way first: braking the rear one, driving the driven one. Shares are of the load that it carries at rest.

    With these numbers a car as a whole has the friction circle of `ocp.terms.FrictionCircle`.
    """

    braking_unloads: float = 0.0  # [s^2/m] of the rear axle's load
    driving_unloads: float = 0.0  # [s^2/m] of the driven axle's load
    driving_pull: float = 1.0  # force of the driven axle over its share of the mass, per acceleration of the car

    def __post_init__(self) -> None:
        require(self, non_negative, "braking_unloads", "driving_unloads")
        require(self, positive, "driving_pull")

    @classmethod
    def of(cls, chassis: Chassis) -> AxleLimits:
        """A car that drives all wheels shares the pull by load: driving costs it nothing at the rear. What driving presses on a driven
        rear axle is left out: the front one loses it."""
        c = chassis
        to_rear, to_front = (c.cog_height_m / (GRAVITY_MPS2 * lever) for lever in (c.cog_to_front_axle_m, c.cog_to_rear_axle_m))
        if c.driven_axle is DrivenAxle.BOTH:
            return cls(braking_unloads=to_rear)
        if c.driven_axle is DrivenAxle.REAR:
            return cls(braking_unloads=to_rear, driving_pull=c.wheelbase_m / c.cog_to_front_axle_m)
        return cls(braking_unloads=to_rear, driving_unloads=to_front, driving_pull=c.wheelbase_m / c.cog_to_rear_axle_m)
