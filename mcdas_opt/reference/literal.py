"""The paper's path as published, faults included: eq 20-24.

The functions named after an equation keep the paper's frame (x forward, y positive to the RIGHT) and its unit of speed (km/h).
`LiteralPath` is the same curve in the project's frame (d positive to the left, SI).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array, as_floats, negative, positive
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.sigmoid import sigmoid
from mcdas_opt.errors import ParameterError

A_PER_M = -0.4
B = 50.0
Y_MAX_M = 3.7
SETTLING_X_M = 20.0  # "absolute x-position at the settling point", section 3.1.5


def offset(off_front: float, off_host: float) -> float:
    """Eq 20: off = off_F - off_H, right positive [m]."""
    return off_front - off_host


def y_right(x: Any, off: float, y_max: float = Y_MAX_M, a: float = A_PER_M, b: float = B) -> Array:
    """Eq 22, right positive [m]; y(0) nullifies y at x = 0."""
    return np.asarray((y_max + off) * _risen(x, a, b))


def y_left(x: Any, off: float, y_max: float = Y_MAX_M, a: float = A_PER_M, b: float = B) -> Array:
    """Eq 23, right positive: negative values lie to the left [m]."""
    return np.asarray(-(y_max - off) * _risen(x, a, b))


def y_parking(x: Any, y_max: float = Y_MAX_M, a: float = 0.4, b: float = B) -> Array:
    """Eq 28, the reverse path (x = -K t runs to negative values, eq 27), right positive [m]; it settles at -y_max b / (1 + b)."""
    return np.asarray(-y_max * _risen(x, a, b))


def _risen(x: Any, a: float, b: float) -> Array:
    """S(x) - S(0); y(0) = +-reach S(0) is the sigmoid's own value at x = 0, subtracted without renormalising."""
    return np.asarray(sigmoid(np.asarray(x, dtype=np.float64), a, b, np) - sigmoid(0.0, a, b, np))


class Eq24(NamedTuple):
    """Left side of eq 24, the paper's frame: speeds in the unit of the commanded speed, bearing [rad] from y, range [m]."""

    vx: Array
    vy: Array
    bearing_rad: Array
    range_m: Array


def commanded_speed(v_rear: float, v_vm: float, v_hm: float, duty: float) -> float:
    """The speed inside eq 24, V_HM (D + (V_Tr / V_VM - D)), in the unit of its arguments; D cancels out.

    With V_VM read as the host's own speed, 60 against 40 km/h commands 360 km/h; read as V_HM it is the rear vehicle's speed.
    """
    return v_hm * (duty + (v_rear / v_vm - duty))


def velocity_literal(x: Any, y: Any, speed: float) -> Eq24:
    """Eq 24 as published: the velocity points along the bearing atan(x / y) of the position, not along the path.

    Raises `ParameterError` where y = 0: at t = 0 the published expression is 0/0. For y < 0 (left) it drives backwards.
    """
    x, y = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
    if np.any(y == 0.0):
        raise ParameterError("y", 0.0, "eq 24 divides x by y", "m")
    bearing = np.arctan(x / y)
    return Eq24(speed * np.sin(bearing), speed * np.cos(bearing), bearing, np.hypot(x, y))


@dataclass(frozen=True, slots=True, kw_only=True)
class LiteralPath:
    """d(s) = start_d + amplitude (S(s - start_s) - S(0)), left positive: eq 22-23 in the road's frame, for s from `start_s_m` on.

    Before the start it is straight at `start_d_m`; beyond `length_m` (the settling point, 20 m) the published curve simply goes on.
    """

    start_s_m: float = 0.0
    start_d_m: float = 0.0
    amplitude_m: float
    a_per_m: float = A_PER_M
    b: float = B

    def __post_init__(self) -> None:
        as_floats(self, self.__slots__)
        negative("a_per_m", self.a_per_m, "1/m")
        positive("b", self.b)

    @property
    def length_m(self) -> float:
        """Distance to the published settling point [m], scaled with 1 / a."""
        return SETTLING_X_M * A_PER_M / self.a_per_m

    @property
    def end_s_m(self) -> float:
        return self.start_s_m + self.length_m

    def d(self, s: Any) -> Array:
        """Lateral position [m] at s [m]."""
        x = np.asarray(s, dtype=np.float64) - self.start_s_m
        return np.asarray(self.start_d_m + self.amplitude_m * _risen(np.maximum(x, 0.0), self.a_per_m, self.b))

    def slope(self, s: Any) -> Array:
        """dd/ds [-]."""
        return self._slope_and_bend(s)[0]

    def curvature(self, s: Any) -> Array:
        """Exact curvature [1/m] on a straight road; the heading jump at the start is not in it."""
        first, second = self._slope_and_bend(s)
        return np.asarray(second / (1.0 + first**2) ** 1.5)

    def _slope_and_bend(self, s: Any) -> tuple[Array, Array]:
        x = np.asarray(s, dtype=np.float64) - self.start_s_m
        shape = sigmoid(np.maximum(x, 0.0), self.a_per_m, self.b, np)
        first = np.where(x >= 0.0, -self.amplitude_m * self.a_per_m * shape * (1.0 - shape), 0.0)
        second = np.where(x >= 0.0, self.amplitude_m * self.a_per_m**2 * shape * (1.0 - shape) * (1.0 - 2.0 * shape), 0.0)
        return first, second


def literal_path(
    side: Side,
    offset_m: float,
    *,
    start_s_m: float = 0.0,
    start_d_m: float = 0.0,
    y_max_m: float = Y_MAX_M,
    a_per_m: float = A_PER_M,
    b: float = B,
) -> LiteralPath:
    """Eq 22 (right) or 23 (left) in the road's frame. `offset_m` = d_front - d_host, LEFT positive: the negative of the paper's off.

    The left path reaches for y_max + offset, the right one for -(y_max - offset).
    """
    if side is Side.NONE:
        raise ParameterError("side", side.value, "must be left or right")
    amplitude = y_max_m + offset_m if side is Side.LEFT else -(y_max_m - offset_m)
    return LiteralPath(start_s_m=start_s_m, start_d_m=start_d_m, amplitude_m=amplitude, a_per_m=a_per_m, b=b)
