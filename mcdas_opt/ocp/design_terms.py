"""The terms of the sigmoid's design: every limit a small object with a name and a unit, every objective too.

Along the path the shape S runs from S(0) = 1 / (1 + b) to 1 - S(0), and all derivatives are polynomials in it (q = S (1 - S)):
y' = Y' |a| q, y'' = Y' a^2 q (1 - 2 S), y''' = Y' |a|^3 q (1 - 6 q), with Y' = Y / (S(X) - S(0)). K = dx/dt (eq 21) is constant, so that
K^2 y'' bounds the lateral acceleration v^2 kappa at the path speed K from above, by 2 % at 60 km/h.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from mcdas_opt.dynamics.sigmoid import PEAK_OF_SECOND_DERIVATIVE, PEAK_OF_THIRD_DERIVATIVE, renormalised

B_LEAST = 4.0  # from 2 + sqrt(3) on the peaks of y'' and y''' lie on the path, and their closed forms hold
_SAMPLES = 33


class Sigmoid:
    """The unknowns in symbols or numbers, y positive to the side of the path; `towards` is the front vehicle's offset to that side [m].

    `gain` is Y' and `end` X [m]; `along` holds three derivatives at samples of the path's first half, which the second mirrors.
    """

    def __init__(self, *, a: Any, b: Any, y_max: Any, speed: Any, towards: Any, m: Any) -> None:
        self.a, self.b, self.speed, self.m = a, b, speed, m
        self.reach = y_max + towards
        self.gain = self.reach * (b + 1.0) / (b - 1.0)
        self.end = -2.0 * m.log(b) / a
        self.along = self._along()
        self.curvatures = [second / (1.0 + first**2) ** 1.5 for first, second, _ in self.along]

    def y(self, x: Any) -> Any:
        """Position at x >= 0 [m]; it stays after the end."""
        return self.reach * renormalised(self.m.fmin(x, self.end), self.a, self.b, self.m)

    def heading(self, x: Any) -> Any:
        """Angle of the path at x [rad], smooth through the end."""
        shape = 1.0 / (1.0 + self.b * self.m.exp(self.a * x))
        return self.m.atan(-self.gain * self.a * shape * (1.0 - shape))

    def reached(self, y: Any) -> Any:
        """Where the path reaches y [m]; y at most its reach."""
        start = 1.0 / (1.0 + self.b)
        shape = start + y / self.reach * (1.0 - 2.0 * start)
        return self.m.log((1.0 - shape) / (shape * self.b)) / self.a

    def _along(self) -> list[tuple[Any, Any, Any]]:
        start, rows = 1.0 / (1.0 + self.b), []
        for share in np.linspace(0.0, 1.0, _SAMPLES).tolist():
            shape = start + (0.5 - start) * share
            q = shape * (1.0 - shape)
            slope = -self.gain * self.a * q
            rows.append((slope, self.gain * self.a**2 * q * (1.0 - 2.0 * shape), -self.gain * self.a**3 * q * (1.0 - 6.0 * q)))
        return rows


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignTerm(ABC):
    """Rows of a quantity, each at most `limit` (`at_least`: at least)."""

    name: str
    limit: float
    unit: ClassVar[str] = "m"
    at_least: ClassVar[bool] = False

    @abstractmethod
    def rows(self, path: Sigmoid) -> Sequence[Any]: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class LateralAcceleration(DesignTerm):
    """K^2 max |y''|, in closed form."""

    name: str = "lateral acceleration"
    unit: ClassVar[str] = "m/s^2"

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        return [path.speed**2 * path.gain * path.a**2 * PEAK_OF_SECOND_DERIVATIVE]


@dataclass(frozen=True, slots=True, kw_only=True)
class LateralJerk(DesignTerm):
    """K^3 max |y'''|, in closed form: the peak is halfway."""

    name: str = "lateral jerk"
    unit: ClassVar[str] = "m/s^3"

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        return [-(path.speed**3) * path.gain * path.a**3 * PEAK_OF_THIRD_DERIVATIVE]


@dataclass(frozen=True, slots=True, kw_only=True)
class Curvature(DesignTerm):
    """Exact curvature of the body centre's path, sampled."""

    name: str = "curvature"
    unit: ClassVar[str] = "1/m"

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        return path.curvatures


@dataclass(frozen=True, slots=True, kw_only=True)
class Steering(DesignTerm):
    """atan(L kappa), sampled."""

    wheelbase_m: float
    name: str = "steering"
    unit: ClassVar[str] = "rad"

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        return [path.m.atan(self.wheelbase_m * kappa) for kappa in path.curvatures]


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeringRate(DesignTerm):
    """K d atan(L kappa) / dx, both signs, sampled. The jump at the start, which no car follows, is the heading jump's affair."""

    wheelbase_m: float
    name: str = "steering rate"
    unit: ClassVar[str] = "rad/s"

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        rows = []
        for first, second, third in path.along:
            bent = 1.0 + first**2
            kappa, change = second / bent**1.5, (third * bent - 3.0 * first * second**2) / bent**2.5
            rate = path.speed * self.wheelbase_m * change / (1.0 + (self.wheelbase_m * kappa) ** 2)
            rows += [rate, -rate]
        return rows


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadingJump(DesignTerm):
    """atan(y'(0+)); at the end the heading jumps back by as much."""

    name: str = "initial heading jump"
    unit: ClassVar[str] = "rad"

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        return [path.m.atan(-path.gain * path.a * path.b / (1.0 + path.b) ** 2)]


@dataclass(frozen=True, slots=True, kw_only=True)
class SettlingError(DesignTerm):
    """|end of the path - centre of the target lane|."""

    lane_centre_m: float
    name: str = "settling error"

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        return [path.reach - self.lane_centre_m, self.lane_centre_m - path.reach]


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadEdge(DesignTerm):
    """Outermost reach of the turned body, sampled over the second half of the path."""

    width_m: float
    length_m: float
    name: str = "road edge"

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        rows = []
        for share in np.linspace(0.5, 1.0, 13).tolist():
            psi = path.heading(share * path.end)
            turned = self.width_m * path.m.cos(psi) + self.length_m * path.m.sin(psi)
            rows.append(path.y(share * path.end) + 0.5 * turned)
        return rows


@dataclass(frozen=True, slots=True, kw_only=True)
class PassingClearance(DesignTerm):
    """Room between the host's near flank and the near corner of another vehicle that it passes, or is passed by.

    Each of nine points of the flank, from the front bumper to the rear one, has its moment beside that corner: the other vehicle's
    bumper is `gap_m` away at the start and comes nearer by `closing` = |K - other speed|. Then the lateral distance is the row.
    """

    gap_m: float
    other_speed_mps: float
    other_edge_m: float  # lateral position of the other body's near flank, towards the side of the path
    width_m: float
    length_m: float
    at_least: ClassVar[bool] = True

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        m, rows = path.m, []
        ahead = self.name.startswith("front")
        closing = path.speed - self.other_speed_mps if ahead else self.other_speed_mps - path.speed
        for share in np.linspace(0.0, 1.0, 9).tolist():
            x = path.speed * (self.gap_m + share * self.length_m) / closing
            from_centre = (0.5 - share) * self.length_m * (1.0 if ahead else -1.0)
            psi = path.heading(x)
            rows.append(path.y(x) + from_centre * m.sin(psi) - 0.5 * self.width_m * m.cos(psi) - self.other_edge_m)
        return rows


@dataclass(frozen=True, slots=True, kw_only=True)
class Length(DesignTerm):
    """From the start of steering until the path stays within `band_m` of the centre of the target lane."""

    lane_centre_m: float
    band_m: float
    name: str = "length"

    def rows(self, path: Sigmoid) -> Sequence[Any]:
        return [path.reached(self.lane_centre_m - self.band_m)]
