"""The car: its size and its limits."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from operator import attrgetter

from mcdas_opt.domain.actuator_response import ActuatorResponse
from mcdas_opt.domain.rules import measurable, negative, non_negative, positive, require, require_type, true_or_false, unit_of, within, word
from mcdas_opt.errors import ParameterError

GRAVITY_MPS2 = 9.80665
_IMMEDIATE = ActuatorResponse()
_OPEN = {  # may stay open; the least and the most as below, so that tonnes, kN/rad and N/deg are told from what is asked for
    "mass_kg": (100.0, 1e5),
    "yaw_inertia_kgm2": (25.0, 1e7),
    "cog_to_front_axle_m": (1e-3, 50.0),
    "cornering_stiffness_front_nprad": (5e3, 1e7),
    "cornering_stiffness_rear_nprad": (5e3, 1e7),
    "axle_load_front_kg": (50.0, 1e5),
    "axle_load_rear_kg": (50.0, 1e5),
}
_TIPS_MPS2, _NEAREST_AXLE = 2.0, 0.4  # a share of the wheelbase: where the centre of gravity may be that nobody gave
_SIZES = {  # the least and the most, of those below 0 by amount, that a road vehicle can have, by far
    "wheelbase_m": (0.1, 50.0),
    "front_overhang_m": (1e-3, 50.0),
    "rear_overhang_m": (1e-3, 50.0),
    "width_m": (0.05, 20.0),
    "steering_rate_max_radps": (1e-3, 1e4),
    "acceleration_max_mps2": (0.01, 1e3),
    "acceleration_min_mps2": (0.01, 1e3),
    "jerk_max_mps3": (0.01, 1e6),
    "jerk_min_mps3": (0.01, 1e6),
    "speed_max_mps": (0.1, 1e3),
    "zero_sideslip_point_m": (0.0, 1e3),
}
_LOADS_AGREE = 0.01  # of the mass, of the wheelbase: figures of data sheets are rounded


class DrivenAxle(StrEnum):
    """Which wheels the engine turns; brakes act on all."""

    FRONT = "front"
    REAR = "rear"
    BOTH = "both"


@dataclass(frozen=True, slots=True, kw_only=True)
class Vehicle:
    """Size and actuator limits of a car; the limits are what the judge enforces, comfort is a cost.

    What the dynamic plant needs besides may stay open: `Chassis.of` fills in typical figures. Axle loads, where both are given, say the
    mass and the place of the centre of gravity; what is given of these besides has to agree with them.

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
    axle_load_front_kg: float | None = None
    axle_load_rear_kg: float | None = None
    driven_axle: DrivenAxle = DrivenAxle.BOTH
    brake_share_front: float | None = None  # of the braking force; None: by load, as electronic distribution has it
    anti_lock: bool = True
    actuators: ActuatorResponse = _IMMEDIATE
    zero_sideslip_point_m: float = 0.0

    def __post_init__(self) -> None:
        require_type("name", self.name, str)
        require_type("actuators", self.actuators, ActuatorResponse)
        require(self, positive, "wheelbase_m", "front_overhang_m", "rear_overhang_m", "width_m")
        within("steering_max_rad", self.steering_max_rad, 0.01, 1.4, "rad")
        require(self, positive, "steering_rate_max_radps", "acceleration_max_mps2", "jerk_max_mps3", "speed_max_mps")
        require(self, negative, "acceleration_min_mps2", "jerk_min_mps3")
        non_negative("zero_sideslip_point_m", self.zero_sideslip_point_m, "m")
        for name, (least, most) in _SIZES.items():
            value = attrgetter(name)(self)
            within(name, value, *((-most, -least) if value < 0.0 else (least, most)), unit_of(name))
        for name, (least, most) in _OPEN.items():
            value = attrgetter(name)(self)
            if value is not None:
                within(name, measurable(name, value, unit_of(name)), least, most, unit_of(name))
        if self.cog_height_m is not None:
            non_negative("cog_height_m", self.cog_height_m, "m")
        object.__setattr__(self, "driven_axle", word("driven_axle", self.driven_axle, DrivenAxle))
        if self.brake_share_front is not None:
            within("brake_share_front", self.brake_share_front, 0.0, 1.0)
        true_or_false("anti_lock", self.anti_lock)
        self._check_loads()
        self._check_balance()

    def _check_loads(self) -> None:
        loads = self.axle_loads_kg
        if loads is None:
            for name, value in (("axle_load_front_kg", self.axle_load_front_kg), ("axle_load_rear_kg", self.axle_load_rear_kg)):
                if value is not None:
                    raise ParameterError(name, value, "says nothing without the other axle's load", "kg")
            return
        total = sum(loads)
        if self.mass_kg is not None and abs(total - self.mass_kg) > _LOADS_AGREE * self.mass_kg:
            rule = f"and axle_load_rear_kg = {loads[1]:g} kg must add up to mass_kg = {self.mass_kg:g}"
            raise ParameterError("axle_load_front_kg", loads[0], rule, "kg")
        behind = self.wheelbase_m * loads[1] / total
        if self.cog_to_front_axle_m is not None and abs(self.cog_to_front_axle_m - behind) > _LOADS_AGREE * self.wheelbase_m:
            rule = f"must be {behind:.3f}, as the axle loads say"
            raise ParameterError("cog_to_front_axle_m", self.cog_to_front_axle_m, rule, "m")

    def _check_balance(self) -> None:
        """The centre of gravity lies between the axles, and so low that braking at `_TIPS_MPS2` keeps both of them on the road."""
        front, nearest, loads = self.cog_to_front_axle_m, _NEAREST_AXLE * self.wheelbase_m, self.axle_loads_kg
        if front is None and loads is not None:
            front = self.wheelbase_m * loads[1] / sum(loads)
        if front is not None:
            if not front < self.wheelbase_m:
                raise ParameterError("cog_to_front_axle_m", front, f"must be less than the wheelbase {self.wheelbase_m:g}", "m")
            nearest = min(front, self.wheelbase_m - front)
        if self.cog_height_m is not None:
            within("cog_height_m", self.cog_height_m, 0.0, nearest * GRAVITY_MPS2 / _TIPS_MPS2, "m")

    @property
    def axle_loads_kg(self) -> tuple[float, float] | None:
        """Static loads of front and rear axle, where both are given."""
        front, rear = self.axle_load_front_kg, self.axle_load_rear_kg
        return None if front is None or rear is None else (front, rear)

    @property
    def length_m(self) -> float:
        return self.front_overhang_m + self.wheelbase_m + self.rear_overhang_m

    @property
    def centre_m(self) -> float:
        """Body centre ahead of the zero-sideslip point [m]; of the rear axle, for a kinematic vehicle."""
        return 0.5 * (self.wheelbase_m + self.front_overhang_m - self.rear_overhang_m) - self.zero_sideslip_point_m
