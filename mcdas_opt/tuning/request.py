"""What is asked of the sigmoid's design, as one frozen record, and the problem that it poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import finite, non_negative, positive, require, within, word
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.ocp.design_terms import (
    B_LEAST,
    Curvature,
    DesignTerm,
    HeadingJump,
    LateralAcceleration,
    LateralJerk,
    Length,
    PassingClearance,
    RoadEdge,
    SettlingError,
    Steering,
    SteeringRate,
)
from mcdas_opt.ocp.sigmoid_design import BOUNDED, OBJECTIVES, SigmoidProblem

SETTLED_M = 0.1  # "until the path stays within 0.1 m of the lane centre"
FRICTION_SHARE = 0.97
CLOSING_MPS = 20.0 / 3.6  # the paper's sandwich: 60 against 40 km/h
FRONT_GAP_M = 25.0  # d_spf of Table 1
_A_BOUNDS, _B_BOUNDS = (-3.0, -2e-3), (B_LEAST, 5000.0)
_CLEAR_OF_NOTHING = 0.999  # share of the settled band that y_max may use


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignRequest:
    """One design: a speed, an offset, an objective, and every limit with its unit.

    `offset_m` = d_front - d_host, left positive. `front_gap_m` and `rear_gap_m` are bumper to bumper at the start; None: nobody there
    (objectives `clearance` and `jerk` put somebody 25 m ahead, closing at 20 km/h, when nobody else is). `length_max_m` is a limit on
    the answer's length. Bounds are (low, high); `speed_bounds_mps` lets K be chosen, otherwise it is `speed_mps`.
    """

    speed_mps: float = 60.0 / 3.6
    offset_m: float = 0.0
    side: Side = Side.LEFT
    objective: str = "shortest"
    lateral_acceleration_mps2: float = 4.0
    lateral_jerk_mps3: float = 20.0
    friction: float = 0.9
    lane_width_m: float = 3.7
    settling_m: float = 0.01
    heading_jump_rad: float = 0.015
    curvature_1pm: float = 0.2
    clearance_m: float = 0.25
    length_max_m: float | None = None
    front_gap_m: float | None = None
    front_speed_mps: float | None = None
    rear_gap_m: float | None = None
    rear_speed_mps: float | None = None
    other_width_m: float = 1.8
    a_bounds_per_m: tuple[float, float] = _A_BOUNDS
    b_bounds: tuple[float, float] = _B_BOUNDS
    y_max_bounds_m: tuple[float, float] | None = None
    speed_bounds_mps: tuple[float, float] | None = None
    vehicle: Vehicle = field(default_factory=Vehicle)

    def __post_init__(self) -> None:
        require_types(self)
        object.__setattr__(self, "side", word("side", self.side, Side))
        require(self, positive, "speed_mps", "lateral_acceleration_mps2", "lateral_jerk_mps3", "friction")
        require(self, positive, "lane_width_m", "heading_jump_rad", "curvature_1pm", "other_width_m")
        if self.lane_width_m <= self.vehicle.width_m:
            raise ParameterError("lane_width_m", self.lane_width_m, f"must be greater than the vehicle's {self.vehicle.width_m:g} m", "m")
        within("offset_m", self.offset_m, -self.lane_width_m, self.lane_width_m, "m")
        within("settling_m", self.settling_m, 1e-6, 0.99 * SETTLED_M, "m")
        non_negative("clearance_m", self.clearance_m, "m")
        if self.objective not in OBJECTIVES:
            raise ParameterError("objective", self.objective, f"is not a known objective; {nearest(self.objective, OBJECTIVES)}")
        if self.side is Side.NONE:
            raise ParameterError("side", self.side.value, "must be left or right")
        for name, given in (("length_max_m", self.length_max_m), ("front_gap_m", self.front_gap_m), ("rear_gap_m", self.rear_gap_m)):
            if given is not None:
                positive(name, given, "m")
        for name, given in (("front_speed_mps", self.front_speed_mps), ("rear_speed_mps", self.rear_speed_mps)):
            if given is not None:
                finite(name, given, "m/s")
        low, high = self._ordered("a_bounds_per_m", self.a_bounds_per_m, "1/m")
        if high >= 0.0:
            raise ParameterError("a_bounds_per_m", self.a_bounds_per_m, "a is less than 0", "1/m")
        low, high = self._ordered("b_bounds", self.b_bounds, "")
        if low < B_LEAST:
            raise ParameterError("b_bounds", self.b_bounds, f"b is at least {B_LEAST:g}: below, the curve's peaks lie before its start")
        if self.y_max_bounds_m is not None:
            self._ordered("y_max_bounds_m", self.y_max_bounds_m, "m")
        speeds = (self.speed_mps, self.speed_mps)
        if self.speed_bounds_mps is not None:
            speeds = self._ordered("speed_bounds_mps", self.speed_bounds_mps, "m/s")
            positive("speed_bounds_mps", speeds[0], "m/s")
        if speeds[1] > self.vehicle.speed_max_mps:
            raise ParameterError("speed_mps", speeds[1], f"the vehicle drives at most {self.vehicle.speed_max_mps:g} m/s", "m/s")
        if self.front is not None and not 0.0 <= self.front[1] < speeds[0]:
            raise ParameterError("front_speed_mps", self.front[1], f"must lie in [0, {speeds[0]:g}): it would not be reached", "m/s")
        if self.rear is not None and not self.rear[1] > speeds[1]:
            raise ParameterError("rear_speed_mps", self.rear[1], f"must be greater than {speeds[1]:g}: it would not reach the host", "m/s")

    def _ordered(self, name: str, value: Sequence[float], unit: str) -> tuple[float, float]:
        low, high = (finite(name, v, unit) for v in value)
        if low > high:
            raise ParameterError(name, tuple(value), "are in the wrong order: low, then high", unit)
        return low, high

    @property
    def towards_m(self) -> float:
        """The front vehicle's offset, to the side of the path positive [m]."""
        return self.side.sign * self.offset_m

    @property
    def front(self) -> tuple[float, float] | None:
        """(gap [m], speed [m/s]) of who is ahead."""
        asked = self.front_gap_m is not None or self.front_speed_mps is not None
        if not asked and (self.objective == "shortest" or self.rear_gap_m is not None or self.rear_speed_mps is not None):
            return None
        slowest = self.speed_mps if self.speed_bounds_mps is None else self.speed_bounds_mps[0]
        speed = max(slowest - CLOSING_MPS, 0.0) if self.front_speed_mps is None else self.front_speed_mps
        return (FRONT_GAP_M if self.front_gap_m is None else self.front_gap_m), speed

    @property
    def rear(self) -> tuple[float, float] | None:
        """(gap [m], speed [m/s]) of who comes from behind."""
        if self.rear_gap_m is None and self.rear_speed_mps is None:
            return None
        fastest = self.speed_mps if self.speed_bounds_mps is None else self.speed_bounds_mps[1]
        speed = fastest + CLOSING_MPS if self.rear_speed_mps is None else self.rear_speed_mps
        return (FRONT_GAP_M if self.rear_gap_m is None else self.rear_gap_m), speed

    def problem(self) -> SigmoidProblem:
        car, centre = self.vehicle, self.lane_width_m
        length = Length(limit=float("inf") if self.length_max_m is None else self.length_max_m, lane_centre_m=centre, band_m=SETTLED_M)
        terms: list[DesignTerm] = [
            LateralAcceleration(limit=self.lateral_acceleration_mps2),
            LateralAcceleration(limit=FRICTION_SHARE * self.friction * GRAVITY_MPS2, name="friction"),
            LateralJerk(limit=self.lateral_jerk_mps3),
            Curvature(limit=self.curvature_1pm),
            Steering(limit=car.steering_max_rad, wheelbase_m=car.wheelbase_m),
            SteeringRate(limit=car.steering_rate_max_radps, wheelbase_m=car.wheelbase_m),
            HeadingJump(limit=self.heading_jump_rad),
            SettlingError(limit=self.settling_m, lane_centre_m=centre),
            RoadEdge(limit=1.5 * self.lane_width_m, width_m=car.width_m, length_m=car.length_m),
        ]
        half = 0.5 * self.other_width_m
        for name, other, aside in (("front clearance", self.front, self.towards_m), ("rear clearance", self.rear, 0.0)):
            if other is not None:
                gap, speed = other
                terms.append(
                    PassingClearance(
                        name=name,
                        limit=-100.0 if self.objective == "clearance" else self.clearance_m,
                        gap_m=gap,
                        other_speed_mps=speed,
                        other_edge_m=aside + half,
                        width_m=car.width_m,
                        length_m=car.length_m,
                    )
                )
        if self.length_max_m is not None:
            terms.append(length)
        reach = _CLEAR_OF_NOTHING * SETTLED_M
        y_low, y_high = centre - self.towards_m - reach, centre - self.towards_m + reach
        if self.y_max_bounds_m is not None:
            low, high = self.y_max_bounds_m
            if low > y_high or high < y_low:
                rule = f"exclude every path that settles: y_max must reach [{y_low:.2f}, {y_high:.2f}] m at this offset"
                raise ParameterError("y_max_bounds_m", self.y_max_bounds_m, rule, "m")
            y_low, y_high = max(low, y_low), min(high, y_high)
        speeds = (self.speed_mps, self.speed_mps) if self.speed_bounds_mps is None else self.speed_bounds_mps
        bounds = dict(zip(BOUNDED, (self.a_bounds_per_m, self.b_bounds, (y_low, y_high), speeds), strict=True))
        return SigmoidProblem(objective=self.objective, terms=tuple(terms), length=length, towards_m=self.towards_m, bounds=bounds)

    def eased(self) -> DesignRequest:
        """The shortest design with nobody near and no limit on its length: what is possible at all."""
        return replace(
            self,
            objective="shortest",
            length_max_m=None,
            front_gap_m=None,
            front_speed_mps=None,
            rear_gap_m=None,
            rear_speed_mps=None,
        )
