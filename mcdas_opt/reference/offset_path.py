"""The corrected offset path: the paper's sigmoid (eq 20-23) scaled by speed, renormalised, bent around the front vehicle.

Corrections of the published path: its length follows from the speed, so that a bound on lateral acceleration holds at every speed;
the value removed at the start, y(0), is made up for, so that start and end are met exactly; and the front vehicle's offset bends the
path beside that vehicle only, instead of moving its end out of the lane.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array, as_floats, finite, negative, positive
from mcdas_opt.dynamics.sigmoid import PEAK_OF_FIRST_DERIVATIVE, PEAK_OF_SECOND_DERIVATIVE, hump, renormalised_shape, sigmoid
from mcdas_opt.errors import ParameterError
from mcdas_opt.native.library import library

_PEAK_OF_HUMP_SLOPE = math.sqrt(2.0 / math.e)  # max |hump'| * width
_PEAK_OF_HUMP_BEND = 2.0  # max |hump''| * width^2
_BEND_SHARE = 0.5  # of the lateral acceleration, that the bend alone may use
_SHARPENING = 1.5  # a bend may at most make the path this much sharper than one without
_SAMPLED_SHARE = 0.995  # of the bound, for the curvature between samples
_ROUNDS, _TRIED = 3, 9  # of the search for the steepest path, and steepnesses in each
_ALONG, _AROUND = 129, 97  # samples of the whole path, and around its bend
NUMBERS_IN_C = {"ALONG": _ALONG, "AROUND": _AROUND, "ROUNDS": _ROUNDS, "TRIED": _TRIED}
LEAST_DISPLACEMENT_M = 0.1  # smaller ones are given the length of this one


@dataclass(frozen=True, slots=True, kw_only=True)
class OffsetPath:
    """d(s) = start_d + R(s - start_s) (amplitude + bend hump(s - bend_s)), left positive, on a straight road.

    R rises from exactly 0 at `start_s_m` to exactly 1 at `start_s_m + length_m`. Before the start the path is straight at `start_d_m`;
    beyond the end R stays 1, where the bare curve would overshoot by 1 / (b - 1) (2 % at b = 50). So d is continuous everywhere and its
    slope jumps at both ends by the same amount, |amplitude a| b / (b^2 - 1): 0.84 degrees at 60 km/h and 4 m/s^2. A car cannot follow
    that jump: what is *driven* is what the bicycle makes of this path.
    """

    start_s_m: float
    start_d_m: float
    amplitude_m: float
    a_per_m: float
    b: float
    bend_m: float = 0.0
    bend_s_m: float = 0.0
    bend_width_m: float = 1.0

    def __post_init__(self) -> None:
        as_floats(self, self.__slots__)
        negative("a_per_m", self.a_per_m, "1/m")
        if self.b <= 1.0:
            raise ParameterError("b", self.b, "must be greater than 1")
        positive("bend_width_m", self.bend_width_m, "m")

    @property
    def length_m(self) -> float:
        """Distance from the start to where the target is reached [m]."""
        return -2.0 * math.log(self.b) / self.a_per_m

    @property
    def target_d_m(self) -> float:
        """Lateral position that the path ends at, away from the bend [m]."""
        return self.start_d_m + self.amplitude_m

    def d(self, s: Any) -> Array:
        """Lateral position [m] at s [m], of the shape of `s`."""
        return self._derivatives(s)[0]

    def slope(self, s: Any) -> Array:
        """dd/ds [-] at s [m]; at a jump the value inside the path."""
        return self._derivatives(s)[1]

    def d_and_slope(self, s: Any) -> tuple[Array, Array]:
        """Both at once."""
        if self.amplitude_m == 0.0 and self.bend_m == 0.0:  # a straight line: what follows with nothing to scale the sigmoid by
            s = np.asarray(s, dtype=np.float64)
            return np.full(s.shape, self.start_d_m + 0.0), np.zeros(s.shape)
        return self._derivatives(s)[:2]

    def curvature(self, s: Any) -> Array:
        """Exact curvature d'' / (1 + d'^2)^(3/2) [1/m] at s [m], on a straight road; the slope's jumps at the ends are not in it."""
        _, first, second = self._derivatives(s)
        return np.asarray(second / (1.0 + first**2) ** 1.5)

    def _derivatives(self, s: Any) -> tuple[Array, Array, Array]:
        s = np.asarray(s, dtype=np.float64)
        offset = _offset(s - self.start_s_m, s - self.bend_s_m, self.a_per_m, self.b, self.amplitude_m, self.bend_m, self.bend_width_m)
        return self.start_d_m + offset[0], offset[1], offset[2]


def _offset(x: Array, z: Array, a: Any, b: float, amplitude: float, bend: float, width: float) -> tuple[Array, Array, Array]:
    """R(x) (amplitude + bend hump(z)) and its first two derivatives by s; `a` may be an array that broadcasts against x and z."""
    length, gain = -2.0 * math.log(b) / a, (b + 1.0) / (b - 1.0)
    inside, beyond = (x >= 0.0) & (x <= length), x > length
    shape = sigmoid(np.minimum(np.maximum(x, 0.0), length), a, b, np)
    r = np.where(inside, renormalised_shape(shape, b), np.where(beyond, 1.0, 0.0))
    r1 = np.where(inside, -gain * a * shape * (1.0 - shape), 0.0)
    r2 = np.where(inside, gain * a**2 * shape * (1.0 - shape) * (1.0 - 2.0 * shape), 0.0)
    w2 = width**2
    h = bend * hump(z, width, np)
    h1, h2 = -2.0 * z / w2 * h, (4.0 * z**2 / w2 - 2.0) / w2 * h
    level = amplitude + h
    return np.asarray(r * level), np.asarray(r1 * level + r * h1), np.asarray(r2 * level + 2.0 * r1 * h1 + r * h2)


def corrected(
    start_s_m: float,
    start_d_m: float,
    target_d_m: float,
    speed_mps: float,
    lateral_acceleration_mps2: float,
    b: float = 50.0,
    speed_floor_mps: float = 3.0,
    bend_m: float = 0.0,
    bend_s_m: float = 0.0,
    bend_width_m: float = 10.0,
) -> OffsetPath:
    """The shortest path of this shape whose v^2 kappa stays at or under the bound at `speed_mps`, on a straight road.

    Without a bend a*(v) = -sqrt(6 sqrt(3) a_lat / (Y' v^2)) with the renormalised amplitude Y' = Y / (S(X) - S(0)); Y under 0.1 m is
    given the length of 0.1 m, v under the floor that of the floor. A bend so narrow that it would use more than half of the bound by
    itself is widened; then a starts from the root of the quadratic that bounds the three terms of (R (Y + bend hump))'' apart, and
    grows while the exact curvature, sampled, keeps the bound.
    """
    v = max(finite("speed_mps", speed_mps, "m/s"), positive("speed_floor_mps", speed_floor_mps, "m/s"))
    sharpest = positive("lateral_acceleration_mps2", lateral_acceleration_mps2, "m/s^2") / v**2
    if b <= 1.0:
        raise ParameterError("b", b, "must be greater than 1")
    amplitude = target_d_m - start_d_m
    gain = (b + 1.0) / (b - 1.0)  # 1 / (S(X) - S(0))
    width = max(positive("bend_width_m", bend_width_m, "m"), math.sqrt(_PEAK_OF_HUMP_BEND * abs(bend_m) / (_BEND_SHARE * sharpest)))
    level = max(abs(amplitude), abs(amplitude + bend_m), LEAST_DISPLACEMENT_M)
    quadratic = gain * level * PEAK_OF_SECOND_DERIVATIVE
    linear = 2.0 * gain * PEAK_OF_FIRST_DERIVATIVE * abs(bend_m) * _PEAK_OF_HUMP_SLOPE / width
    constant = _PEAK_OF_HUMP_BEND * abs(bend_m) / width**2 - sharpest
    a = (-linear + math.sqrt(linear**2 - 4.0 * quadratic * constant)) / (2.0 * quadratic)
    if bend_m != 0.0:
        bare = math.sqrt(sharpest / (gain * max(abs(amplitude), LEAST_DISPLACEMENT_M) * PEAK_OF_SECOND_DERIVATIVE))
        a = _sharpest_within(a, max(_SHARPENING * bare, a), sharpest, b, amplitude, bend_m, bend_s_m - start_s_m, width)
    return OffsetPath(
        start_s_m=start_s_m,
        start_d_m=start_d_m,
        amplitude_m=amplitude,
        a_per_m=-a,
        b=b,
        bend_m=bend_m,
        bend_s_m=bend_s_m,
        bend_width_m=width,
    )


def _sharpest_within(
    low: float, high: float, curvature: float, b: float, amplitude: float, bend: float, bend_x: float, width: float
) -> float:
    """The largest -a from `low`, which keeps the bound, towards `high`, up to which every tried one keeps it: three rounds of a grid."""
    compiled = library()
    search = sharpest_within if compiled is None else compiled.mcdas_sharpest
    return float(search(_samples(b), low, high, _SAMPLED_SHARE * curvature, b, amplitude, bend, bend_x, width))


def sharpest_within(
    tables: Array, low: float, high: float, bound: float, b: float, amplitude: float, bend: float, bend_x: float, width: float
) -> float:
    """The search as array operations, the reference of the compiled one."""
    kept = _bound_keeper(tables, bound, b, amplitude, bend, bend_x, width)
    tried = np.linspace(low, high, _TRIED)
    soft = kept(tried)
    if not soft[0] or soft.all():
        return high if soft[0] else low
    for _ in range(_ROUNDS - 1):
        last = int(np.argmin(soft)) - 1
        tried = np.linspace(float(tried[last]), float(tried[last + 1]), _TRIED)
        soft[1:-1] = kept(tried[1:-1])  # the first one keeps it, the last one does not
        soft[0], soft[-1] = True, False
    return float(tried[int(np.argmin(soft)) - 1])


def _bound_keeper(
    tables: Array, bound: float, b: float, amplitude: float, bend: float, bend_x: float, width: float
) -> Callable[[Array], NDArray[np.bool_]]:
    """For each -a (n,) whether the curvature stays within the bound [1/m] on samples of the whole path, and around the bend.

    As `_offset` has it; but along the path the sigmoid is the same for every a, as is the hump around the bend.
    """
    end, gain = 2.0 * math.log(b), (b + 1.0) / (b - 1.0)
    along, rising, around, squeezed = np.split(tables, (_ALONG, 2 * _ALONG, 2 * _ALONG + _AROUND))
    places = bend_x + width * around

    def kept(steepness: Array) -> NDArray[np.bool_]:
        a = steepness[:, None]
        x = a * places
        shape, q, hump_ = (np.empty((steepness.size, along.size + around.size)) for _ in range(3))
        shape[:, : along.size] = rising
        shape[:, along.size :] = sigmoid(np.clip(x, 0.0, end), -1.0, b, np)
        q[:, : along.size] = (along * end / a - bend_x) / width
        q[:, along.size :] = around
        np.exp(-(q[:, : along.size] ** 2), out=hump_[:, : along.size])
        hump_[:, along.size :] = squeezed
        hump_ *= bend
        r = (shape - 1.0 / (1.0 + b)) * gain
        r1 = shape - shape * shape
        r1[:, along.size :] *= (x >= 0.0) & (x <= end)
        r1 *= gain * a
        slope = (-2.0 / width) * q * hump_
        level = amplitude + hump_
        first = r1 * level + r * slope
        second = r1 * (a * (1.0 - 2.0 * shape) * level + 2.0 * slope) + r * hump_ * ((4.0 * q * q - 2.0) / width**2)
        straight = 1.0 + first * first
        return np.asarray((np.abs(second) <= bound * straight * np.sqrt(straight)).all(axis=1))

    return kept


@lru_cache(maxsize=16)
def _samples(b: float) -> Array:
    """Shares of the path's length, the sigmoid there; shares of the bend's width, the hump there: one behind the other."""
    along, around = np.linspace(0.0, 1.0, _ALONG), np.linspace(-3.0, 3.0, _AROUND)
    return np.concatenate([along, sigmoid(along * (2.0 * math.log(b)), -1.0, b, np), around, hump(around, 1.0, np)])
