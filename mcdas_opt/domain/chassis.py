"""What the forces act on: mass, inertia, centre of gravity and the stiffness of the tyres."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import measurable, non_negative, require, within
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, DrivenAxle, Vehicle
from mcdas_opt.errors import ParameterError

TYPICAL_MASS_KG = 1500.0
TYPICAL_FRONT_SHARE = 4.0 / 9.0  # centre of gravity behind the front axle, in wheelbases
TYPICAL_HEIGHT_M = 0.55
_HIGHEST = 2.0  # times the way to the nearer axle
TYPICAL_STIFFNESS_FRONT = 14.7  # cornering stiffness over the axle's static load [1/rad]
TYPICAL_STIFFNESS_REAR = 21.4


@dataclass(frozen=True, slots=True, kw_only=True)
class Chassis:
    """A rigid body on two axles. Stiffness is of a whole axle (both tyres), positive, at zero slip."""

    wheelbase_m: float
    mass_kg: float
    yaw_inertia_kgm2: float
    cog_to_front_axle_m: float
    cog_height_m: float
    cornering_stiffness_front_nprad: float
    cornering_stiffness_rear_nprad: float
    driven_axle: DrivenAxle = DrivenAxle.BOTH
    brake_share_front: float | None = None  # of the braking force; None: by load
    anti_lock: bool = True

    def __post_init__(self) -> None:
        require_types(self)
        require(self, measurable, "wheelbase_m", "mass_kg", "cog_to_front_axle_m")
        if not self.cog_to_front_axle_m < self.wheelbase_m:
            rule = f"must be less than the wheelbase {self.wheelbase_m:g}"
            raise ParameterError("cog_to_front_axle_m", self.cog_to_front_axle_m, rule, "m")
        require(self, measurable, "yaw_inertia_kgm2", "cornering_stiffness_front_nprad", "cornering_stiffness_rear_nprad")
        non_negative("cog_height_m", self.cog_height_m, "m")
        if self.brake_share_front is not None:
            within("brake_share_front", self.brake_share_front, 0.0, 1.0)

    @classmethod
    def of(cls, vehicle: Vehicle) -> Chassis:
        """The vehicle's figures; those it does not give are typical ones.

        Chosen, after the ranges of passenger cars in Rajamani, Vehicle Dynamics and Control, 2nd ed. 2012: 1500 kg, 5/9 of the load on
        the front axle, yaw inertia m a b (radius of gyration sqrt(a b)), a centre of gravity 0.55 m high, and axles of 14.7 and 21.4 N/rad
        per N of static load, which understeer by 1.2 degrees per g.
        """
        mass, front = TYPICAL_MASS_KG, TYPICAL_FRONT_SHARE * vehicle.wheelbase_m
        if vehicle.axle_loads_kg is not None:
            mass = sum(vehicle.axle_loads_kg)
            front = vehicle.wheelbase_m * vehicle.axle_loads_kg[1] / mass
        mass, front = _first(vehicle.mass_kg, mass), _first(vehicle.cog_to_front_axle_m, front)
        rear = vehicle.wheelbase_m - front
        weight = mass * GRAVITY_MPS2 / vehicle.wheelbase_m
        return cls(
            wheelbase_m=vehicle.wheelbase_m,
            mass_kg=mass,
            yaw_inertia_kgm2=_first(vehicle.yaw_inertia_kgm2, mass * front * rear),
            cog_to_front_axle_m=front,
            cog_height_m=_first(vehicle.cog_height_m, min(TYPICAL_HEIGHT_M, _HIGHEST * min(front, rear))),
            cornering_stiffness_front_nprad=_first(vehicle.cornering_stiffness_front_nprad, TYPICAL_STIFFNESS_FRONT * weight * rear),
            cornering_stiffness_rear_nprad=_first(vehicle.cornering_stiffness_rear_nprad, TYPICAL_STIFFNESS_REAR * weight * front),
            driven_axle=vehicle.driven_axle,
            brake_share_front=vehicle.brake_share_front,
            anti_lock=vehicle.anti_lock,
        )

    @property
    def cog_to_rear_axle_m(self) -> float:
        return self.wheelbase_m - self.cog_to_front_axle_m

    @property
    def understeer_gradient(self) -> float:
        """K_us [rad / (m/s^2)]: steady cornering needs delta = L / R + K_us a_y (Rajamani 2012, eq 3.3)."""
        a, b = self.cog_to_front_axle_m, self.cog_to_rear_axle_m
        return self.mass_kg / self.wheelbase_m * (b / self.cornering_stiffness_front_nprad - a / self.cornering_stiffness_rear_nprad)

    @property
    def rear_slip_gradient(self) -> float:
        """K_r [rad / (m/s^2)]: slip of the rear axle per lateral acceleration in a steady turn (Rajamani 2012, section 3.1)."""
        return self.mass_kg * self.cog_to_front_axle_m / (self.wheelbase_m * self.cornering_stiffness_rear_nprad)

    def sliding_sideslip_rad(self, friction: float) -> float:
        """Sideslip of the rear axle at which the whole contact of its tyres slides, at its load at rest: more of it gives no more lateral
        force, and the car spins unless it is steered against (Fiala 1954; as a limit of stability: Beal and Gerdes, Model predictive
        control for vehicle stabilization at the limits of handling, IEEE Trans. Control Systems Technology 21(4) 2013)."""
        load = self.mass_kg * GRAVITY_MPS2 * self.cog_to_front_axle_m / self.wheelbase_m
        return math.atan(3.0 * friction * load / self.cornering_stiffness_rear_nprad)

    def zero_sideslip_point_m(self, speed_mps: float) -> float:
        """Ahead of the rear axle, the point of the car's axis that moves along it in every steady turn at this speed [m].

        The slip of the rear axle is K_r v^2 / R, and that of a point x ahead of it is less by x / R: it is zero at x = K_r v^2, whatever
        the radius. While tyre forces are in proportion to slip, the vehicle moves as a kinematic one that has its rear axle there.
        """
        return self.rear_slip_gradient * speed_mps**2


def _first(given: float | None, typical: float) -> float:
    return typical if given is None else given
