"""The paper's sigmoid over the distance driven, for many members at once, joined to the car's own heading and steering."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.manoeuvres.paths import Paths, body_paths
from mcdas_opt.manoeuvres.phases import SpeedHistory
from mcdas_opt.manoeuvres.starts import rear_axle

PEAK = 6.0 * math.sqrt(3.0)  # max |S''| = a^2 / (6 sqrt 3)
SPEED_FLOOR_MPS = 3.0
LEAST_SHIFT_M = 0.1
JOIN_S = 0.35  # in so much time the car's own heading and curvature have gone over into the sigmoid's
JOIN_LEAST_M = 1.5


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneChangeProfiles:
    """Where to (d of the rear axle at the end [m]), at which peak of lateral acceleration [m/s^2], after which delay [s], and the
    sigmoid's b (eq 22: the larger, the softer the start); arrays of one shape (members)."""

    target_d_m: Array
    lateral_mps2: Array
    delay_s: Array
    b: Array

    def __getitem__(self, index: Any) -> LaneChangeProfiles:
        parts = (self.target_d_m, self.lateral_mps2, self.delay_s, self.b)
        target, lateral, delay, b = (q[index] for q in parts)
        return LaneChangeProfiles(target_d_m=target, lateral_mps2=lateral, delay_s=delay, b=b)


def paths(profiles: LaneChangeProfiles, speeds: SpeedHistory, times_s: Array, start: HostState, vehicle: Vehicle, road: Road) -> Paths:
    """The paths of lane changes driven at these speeds; the shapes of both broadcast.

    d is the sigmoid as a function of the distance l that the rear axle has driven, so that sin(psi) = d'(l), and kappa = d''(l) / cos(psi)
    + the road's part: the exact kinematics of the bicycle's rear axle on the grid, no small angles. The sigmoid's steepness is the
    paper's, repaired by speed: a = -sqrt(6 sqrt(3) a_lat / (Y v^2)) with v about where it is steepest. Of its
    start only d is kept; heading and curvature there are the car's own, and go over into the sigmoid's by (m l + n l^2) exp(-l / l_join).
    """
    s0, d0, sine0, bend0 = rear_axle(start, vehicle, road)

    shift = profiles.target_d_m - d0
    a, begin, height = _shape(profiles, shift, speeds, times_s)
    s_at_0 = 1.0 / (1.0 + profiles.b * np.exp(-a * begin))
    gain = height * a
    slope0, curl0 = -gain * s_at_0 * (1.0 - s_at_0), gain * a * s_at_0 * (1.0 - s_at_0) * (1.0 - 2.0 * s_at_0)
    join = np.maximum(JOIN_S * np.asarray(start.speed_mps, dtype=np.float64), JOIN_LEAST_M)
    m = sine0 - slope0
    n = 0.5 * (bend0 - curl0) + m / join

    # from here on members by times, in the precision of the speeds, with as few arrays as will do
    precision = speeds.travelled_m.dtype
    small = (a, begin, profiles.b, height, d0 - height * s_at_0, gain, m * join, n * join**2, join, s0)
    a, begin, b, height, base, gain, m, n, join, s0 = (np.asarray(q, dtype=precision)[..., None] for q in small)
    e = speeds.travelled_m - begin
    e *= a
    np.minimum(e, 80.0, out=e)  # far before the start; beyond it single precision overflows
    np.exp(e, out=e)
    e *= b
    s = 1.0 / (1.0 + e)
    e *= s
    e *= s  # f = S (1 - S) carries the sigmoid's derivatives
    d = height * s
    d += base
    slope = -gain * e
    s *= -2.0
    s += 1.0
    curl = np.multiply(slope, s, out=s)
    curl *= -a
    x = speeds.travelled_m / join
    fade = np.exp(-x)
    for total, of_m, of_n in (
        (d, x * fade, x * x * fade),
        (slope, (1.0 - x) * fade / join, (2.0 - x) * x * fade / join),
        (curl, (x - 2.0) * fade / join**2, (2.0 - 4.0 * x + x * x) * fade / join**2),
    ):
        total += np.multiply(m, of_m, out=e)
        total += np.multiply(n, of_n, out=e)

    sine = np.clip(slope, -0.9, 0.9)
    cosine = np.sqrt(1.0 - sine * sine)
    return body_paths(s0, speeds.travelled_m, d, sine, cosine, curl / cosine, vehicle, road)


def _shape(profiles: LaneChangeProfiles, shift: Array, speeds: SpeedHistory, times_s: Array) -> tuple[Array, Array, Array]:
    """a [1/m], the distance driven at which the sigmoid begins, and its height, each of the members' broadcast shape."""
    size = np.maximum(np.abs(shift), LEAST_SHIFT_M)
    h = float(times_s[1] - times_s[0])
    middle = profiles.delay_s + 1.22 * np.sqrt(size / profiles.lateral_mps2)
    v = np.maximum(_at(speeds.speed_mps, middle / h), SPEED_FLOOR_MPS)
    a = -np.sqrt(PEAK * profiles.lateral_mps2 / size) / v
    start = _at(speeds.travelled_m, profiles.delay_s / h)
    rest = profiles.b * np.exp(-a * start)  # 1 / S(0) - 1
    return a, start, shift * (1.0 + rest) / rest


def _at(history: Array, index: Array) -> Array:
    """History (..., T) at fractional indices (members), by the nearest sample."""
    shape = np.broadcast_shapes(history.shape[:-1], index.shape)
    nearest = np.clip(np.rint(index), 0, history.shape[-1] - 1).astype(np.intp)
    rows = np.broadcast_to(history, (*shape, history.shape[-1]))
    return np.asarray(np.take_along_axis(rows, np.broadcast_to(nearest, shape)[..., None], axis=-1)[..., 0])
