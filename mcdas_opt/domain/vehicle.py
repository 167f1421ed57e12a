"""The car: its size and its limits."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.rules import negative, non_negative, positive, require, within

GRAVITY_MPS2 = 9.80665


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """Size and actuator limits of a car; the limits are what the judge enforces, comfort is a cost.

    What the dynamic plant needs besides may stay open: `Chassis.of` fills in typical figures.

    `zero_sideslip_point_m` ahead of the rear axle is the point at which the vehicle moves along its own axis: 0, the rear axle, of a
    kinematic vehicle. It is no key of a vehicle file: it depends on the speed (`Chassis.zero_sideslip_point_m`); the planner is told it.
    """

    name: str = "sedan"
    wheelbase_m: float = 2.7
    front_overhang_m: float = 0.9
    rear_overhang_m: float = 0.9
    width_m: float = 1.8
    steering_max_rad: float = 0.55
    steering_rate_max_radps: float = 0.5
    acceleration_min_mps2: float = -8.0
    acceleration_max_mps2: float = 3.0
    jerk_min_mps3: float = -40.0
    jerk_max_mps3: float = 20.0
    speed_max_mps: float = 50.0
    mass_kg: float | None = None
    yaw_inertia_kgm2: float | None = None
    cog_to_front_axle_m: float | None = None
    cog_height_m: float | None = None
    cornering_stiffness_front_nprad: float | None = None
    cornering_stiffness_rear_nprad: float | None = None
    zero_sideslip_point_m: float = 0.0

    def __post_init__(self) -> None:
        require(self, positive, "wheelbase_m", "front_overhang_m", "rear_overhang_m", "width_m")
        within("steering_max_rad", self.steering_max_rad, 0.01, 1.4, "rad")
        require(self, positive, "steering_rate_max_radps", "acceleration_max_mps2", "jerk_max_mps3", "speed_max_mps")
        require(self, negative, "acceleration_min_mps2", "jerk_min_mps3")
        non_negative("zero_sideslip_point_m", self.zero_sideslip_point_m, "m")

    @property
    def length_m(self) -> float:
        return self.front_overhang_m + self.wheelbase_m + self.rear_overhang_m

    def strongest_mps2(self, friction: float) -> tuple[float, float]:
        """The most that it brakes, and that it accelerates, on such a road: both greater than 0."""
        grip = friction * GRAVITY_MPS2
        return min(-self.acceleration_min_mps2, grip), min(self.acceleration_max_mps2, grip)

    @property
    def centre_m(self) -> float:
        """Body centre ahead of the zero-sideslip point [m]; of the rear axle, for a kinematic vehicle."""
        return 0.5 * (self.wheelbase_m + self.front_overhang_m - self.rear_overhang_m) - self.zero_sideslip_point_m
