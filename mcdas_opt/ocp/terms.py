"""The terms of the lane problem: costs and constraints as small objects with a name and a unit.

A cost gives residuals (their squares, halved and weighted, are summed); a constraint gives rows g <= slack. Both read the stage's
state, input and parameters by name from a `Stage`, and say which parameters they need.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from mcdas_opt.dynamics.bicycle import lateral_acceleration, swept_inset_m2
from mcdas_opt.dynamics.sigmoid import hump, renormalised

_NARROWEST = 0.1  # of 1 - d kappa, on a road


class CarSizes(Protocol):
    """What the terms know of a vehicle [m], in numbers or in symbols."""

    @property
    def wheelbase_m(self) -> Any: ...
    @property
    def length_m(self) -> Any: ...
    @property
    def width_m(self) -> Any: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """One stage in symbols (or numbers): state, input, parameters by name, the number system, the vehicle; `centre` is its body centre's
    lead over the point that moves along its axis [m]."""

    s: Any
    d: Any
    psi: Any
    v: Any
    a: Any
    delta: Any
    jerk: Any
    delta_rate: Any
    p: Mapping[str, Any]
    m: Any
    vehicle: CarSizes
    centre: Any

    @property
    def kappa(self) -> Any:
        """The road's curvature [1/m] where the body centre is."""
        p = self.p
        return p["kappa"] + p["kappa_slope"] * (self.s - p["kappa_s"])

    @property
    def lateral_acceleration(self) -> Any:
        return lateral_acceleration(self.v, self.delta, self.vehicle.wheelbase_m, self.m)

    @property
    def half_along(self) -> Any:
        return 0.5 * self.vehicle.length_m

    @property
    def half_across(self) -> Any:
        """Half the width that the turned body takes across the road."""
        return 0.5 * (self.vehicle.width_m * self.m.cos(self.psi) + self.vehicle.length_m * smooth_magnitude(self.m.sin(self.psi), self.m))

    @property
    def reach(self) -> tuple[Any, Any]:
        """How far the turned body reaches to the left and to the right of its centre's d across a road that bends, to its nose and to its
        tail each as `kappa_nose` and `kappa_tail` say: to the corner that is further out; where both lie off a flank's middle to the
        outside, to the flank between them."""
        m, p, length, width = self.m, self.p, self.vehicle.length_m, self.vehicle.width_m
        cosine, change = m.cos(self.psi), p["kappa_slope"] * (self.s - p["kappa_s"])

        def off_tangent(kappa: Any, x: Any, y: Any, d: Any) -> Any:
            """How far a corner x ahead of the centre and y to its left lies from the tangent's d, on a circle."""
            narrowed = m.fmax(1.0 - kappa * (d + y), _NARROWEST)
            return kappa * x**2 / (narrowed + m.sqrt(narrowed**2 + (kappa * x) ** 2))

        def to(side: float) -> Any:
            sine, d = side * m.sin(self.psi), side * self.d
            along, across = 0.5 * (length * cosine - width * sine), 0.5 * (width * cosine + length * sine)
            nose = off_tangent(side * (p["kappa_nose"] + change), along, across, d)
            along, across = 0.5 * (length * cosine + width * sine), 0.5 * (width * cosine - length * sine)
            tail = off_tangent(side * (p["kappa_tail"] + change), along, across, d)
            turned = smooth_magnitude(sine + (tail - nose) / length, m)
            bow = m.fmax(0.5 * (nose + tail), 0.0)
            flank = m.fmax(2.0 * bow - 0.5 * length * turned, 0.0) ** 2 / (4.0 * bow + 1e-3)
            return 0.5 * (width * cosine + length * turned) - 0.5 * (nose + tail) + flank

        return to(1.0), to(-1.0)


def smooth_magnitude(value: Any, m: Any) -> Any:
    """|value|, rounded at 0 and less by up to 0.01."""
    return m.sqrt(value**2 + 1e-4) - 1e-2


class Cost(Protocol):
    """`weight` multiplies the square of each residual, per node."""

    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> Sequence[str]: ...
    @property
    def weight(self) -> float: ...
    @property
    def terminal_weight(self) -> float: ...
    def residual(self, stage: Stage) -> Any: ...


class Constraint(Protocol):
    """Rows g(stage) <= slack of the family `slack`."""

    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> Sequence[str]: ...
    @property
    def slack(self) -> str: ...
    def rows(self, stage: Stage) -> list[Any]: ...


BEND = ("kappa", "kappa_slope", "kappa_s")
BODY_BEND = (*BEND, "kappa_nose", "kappa_tail")
REFERENCE = (
    "ref_start_s",
    "ref_start_d",
    "ref_amplitude",
    "ref_a",
    "ref_b",
    "ref_bend",
    "ref_bend_s",
    "ref_bend_width",
)


def reference_d(stage: Stage, s: Any) -> Any:
    """The corrected sigmoid offset path d_ref(s) [m]: `reference.offset_path.OffsetPath` in the stage's number system."""
    p, m = stage.p, stage.m
    x = m.fmin(m.fmax(s - p["ref_start_s"], 0.0), -2.0 * m.log(p["ref_b"]) / p["ref_a"])
    level = p["ref_amplitude"] + p["ref_bend"] * hump(s - p["ref_bend_s"], p["ref_bend_width"], m)
    return p["ref_start_d"] + renormalised(x, p["ref_a"], p["ref_b"], m) * level


@dataclass(frozen=True, slots=True, kw_only=True)
class PathDeviation:
    """(d - d_ref(s) - inset kappa)^2: in a bend the middle of what the body sweeps is on the path (`dynamics.bicycle.swept_inset_m2`)."""

    weight: float
    terminal_weight: float
    name: str = "path deviation [m]"
    parameters: Sequence[str] = (*REFERENCE, *BEND)

    def residual(self, stage: Stage) -> Any:
        return stage.d - reference_d(stage, stage.s) - swept_inset_m2(stage.vehicle.length_m, stage.centre) * stage.kappa


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadingDeviation:
    """(psi - atan(d d_ref / ds) + centre kappa)^2: in a bend the body's axis is no tangent at its centre (Rajamani, 2.2: its sideslip
    there). The slope is a central difference over 2 m (it smooths the curve's ends)."""

    weight: float
    terminal_weight: float
    name: str = "heading deviation [rad]"
    parameters: Sequence[str] = (*REFERENCE, *BEND)

    def residual(self, stage: Stage) -> Any:
        slope = 0.5 * (reference_d(stage, stage.s + 1.0) - reference_d(stage, stage.s - 1.0))
        return stage.psi - stage.m.atan(slope) + stage.centre * stage.kappa


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedDeviation:
    """(v - v_ref)^2."""

    weight: float
    terminal_weight: float
    name: str = "speed deviation [m/s]"
    parameters: Sequence[str] = ("speed_ref",)

    def residual(self, stage: Stage) -> Any:
        return stage.v - stage.p["speed_ref"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """The square of one quantity of the stage: 'a', 'jerk', 'delta_rate' or 'lateral_acceleration'."""

    quantity: str
    unit: str
    weight: float
    terminal_weight: float = 0.0
    parameters: Sequence[str] = ()

    @property
    def name(self) -> str:
        return f"{self.quantity} [{self.unit}]"

    def residual(self, stage: Stage) -> Any:
        return getattr(stage, self.quantity)


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionCircle:
    """sqrt(a^2 + (v^2 tan(delta) / L)^2) <= grip."""

    name: str = "friction circle [m/s^2]"
    slack: str = "friction"
    parameters: Sequence[str] = ("grip",)

    def rows(self, stage: Stage) -> list[Any]:
        return [stage.m.sqrt(stage.a**2 + stage.lateral_acceleration**2 + 1e-2) - stage.p["grip"]]


@dataclass(frozen=True, slots=True, kw_only=True)
class AxleFriction:
    """The friction circle of the axle that gives way first, in place of the car's own.

    sqrt(pull^2 + (v^2 tan(delta) / L)^2) <= grip load; parameters: `dynamics.axle_limits.AxleLimits`. `load` is what the axle carries, over
    what it carries at rest: braking takes `braking_unloads` times the deceleration from the braked one, driving `driving_unloads` times the
    acceleration from the driven one. Brakes share by load, or ask the axle for `braking_pull` times the deceleration; the engine asks the
    driven one for `driving_pull` times the acceleration.
    Steady turns: what yawing faster asks of either axle is left out.
    """

    name: str = "axle friction [m/s^2]"
    slack: str = "friction"
    parameters: Sequence[str] = (
        "grip",
        "braking_unloads",
        "brakes_by_load",
        "braking_pull",
        "driving_unloads",
        "driving_pull",
    )

    def rows(self, stage: Stage) -> list[Any]:
        m, p = stage.m, stage.p
        driving = m.fmax(stage.a, 0.0)
        braking = stage.a - driving
        load = 1.0 + p["braking_unloads"] * braking - p["driving_unloads"] * driving
        pull = p["brakes_by_load"] * load * braking + p["braking_pull"] * braking + p["driving_pull"] * driving
        return [m.sqrt(pull**2 + stage.lateral_acceleration**2 + 1e-2) - p["grip"] * load]


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadEdges:
    """The turned body between the edges, `margin` [m] inside."""

    margin: float
    name: str = "road edge [m]"
    slack: str = "road"
    parameters: Sequence[str] = ("left_edge", "right_edge", *BODY_BEND)

    def rows(self, stage: Stage) -> list[Any]:
        left, right = (reach + self.margin for reach in stage.reach)
        return [stage.d + left - stage.p["left_edge"], stage.p["right_edge"] - (stage.d - right)]


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopingRoadEdges:
    """The same between edges that change along the road: linear in s around `edge_s`."""

    margin: float
    name: str = "road edge [m]"
    slack: str = "road"
    parameters: Sequence[str] = ("left_edge", "right_edge", "left_slope", "right_slope", "edge_s", *BODY_BEND)

    def rows(self, stage: Stage) -> list[Any]:
        p, on = stage.p, stage.s - stage.p["edge_s"]
        left, right = (reach + self.margin for reach in stage.reach)
        left_edge, right_edge = p["left_edge"] + p["left_slope"] * on, p["right_edge"] + p["right_slope"] * on
        return [stage.d + left - left_edge, right_edge - (stage.d - right)]


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadEnd:
    """The front bumper short of the road's end; far away where there is none."""

    name: str = "road end [m]"
    slack: str = "road"
    parameters: Sequence[str] = ("road_end",)

    def rows(self, stage: Stage) -> list[Any]:
        return [stage.s + stage.half_along - stage.p["road_end"]]


@dataclass(frozen=True, slots=True, kw_only=True)
class MovingBody:
    """A neighbour's inflated body, as the outside of a superellipse of power 4 around the Minkowski sum of both bodies.

    Row: (1 - |(ds / A, dd / B)|_4) B <= slack, in metres across. A convex norm: its linearisation is on the safe side.
    `roundness` enlarges the half axes towards circumscribing the rectangle (2^(1/4) = 1.19 does so fully).
    """

    slot: int
    roundness: float = 1.1
    slack: str = "collision"

    @property
    def name(self) -> str:
        return f"neighbour {self.slot + 1} [m]"

    @property
    def parameters(self) -> Sequence[str]:
        i = self.slot
        return (f"body{i}_s", f"body{i}_d", f"body{i}_along", f"body{i}_across")

    def rows(self, stage: Stage) -> list[Any]:
        s, d, along, across = (stage.p[name] for name in self.parameters)
        half_s = self.roundness * (stage.half_along + along)
        half_d = self.roundness * (stage.half_across + across)
        m = stage.m
        norm = m.sqrt(m.sqrt(((stage.s - s) / half_s) ** 4 + ((stage.d - d) / half_d) ** 4 + 1e-8))  # cheaper than a power
        return [(1.0 - norm) * half_d]


@dataclass(frozen=True, slots=True, kw_only=True)
class Headway:
    """Room to the vehicle ahead and behind in the lane: gap >= standstill gap + horizon * closing speed; ahead also time gap * speed.

    `front_bumper` is s of the rear bumper ahead, `rear_bumper` s of the front bumper behind; far away where there is none or where
    the row does not apply (the vehicle is of a lane that the host is leaving).
    """

    horizon_s: float
    name: str = "headway [m]"
    slack: str = "headway"
    parameters: Sequence[str] = ("front_bumper", "front_speed", "rear_bumper", "rear_speed", "standstill", "time_gap")

    def rows(self, stage: Stage) -> list[Any]:
        m, p = stage.m, stage.p

        def closing(speed: Any) -> Any:
            return 0.5 * (speed + m.sqrt(speed**2 + 0.25))

        ahead = p["front_bumper"] - (stage.s + stage.half_along)
        behind = (stage.s - stage.half_along) - p["rear_bumper"]
        return [
            p["standstill"] + p["time_gap"] * stage.v + self.horizon_s * closing(stage.v - p["front_speed"]) - ahead,
            p["standstill"] + self.horizon_s * closing(p["rear_speed"] - stage.v) - behind,
        ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comfort:
    """-most_braking <= a <= most_acceleration, and |jerk| <= most_jerk; far limits where comfort counts for nothing."""

    name: str = "comfort [m/s^2]"
    slack: str = "comfort"
    parameters: Sequence[str] = ("most_acceleration", "most_braking", "most_jerk")

    def rows(self, stage: Stage) -> list[Any]:
        p = stage.p
        return [
            stage.a - p["most_acceleration"],
            -stage.a - p["most_braking"],
            stage.m.sqrt(stage.jerk**2 + 1e-4) - p["most_jerk"],
        ]
