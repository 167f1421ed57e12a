"""When a car that brakes comes to rest, and a step in which it may."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4


def time_to_stop(v: float, a: float, jerk: float) -> float:
    """First t > 0 at which v + a t + jerk t^2 / 2 falls through zero; infinite when it does not."""
    if a >= 0.0 and jerk >= 0.0:
        return math.inf
    if abs(jerk) < 1e-12:
        return v / -a if a < 0.0 else math.inf
    under = a * a - 2.0 * jerk * v
    if under <= 0.0:
        return math.inf
    roots = [(-a - math.sqrt(under)) / jerk, (-a + math.sqrt(under)) / jerk]
    falling = [t for t in roots if t > 0.0 and a + jerk * t < 0.0]
    return min(falling, default=math.inf)


def times_to_rest(v: Array, a: Array, jerk: Array) -> Array:
    """(n,): when v + a t + jerk t^2 / 2 first meets 0, for braking cars."""
    root = np.sqrt(np.maximum(a * a - 2.0 * jerk * v, 0.0))
    return np.asarray(2.0 * v / np.maximum(root - a, 1e-9))


def held_step(x: list[float], u: tuple[float, float], h: float, curvature: Callable[[float], float], vehicle: Vehicle) -> list[float]:
    """The bicycle along a road, h [s] on under (jerk, steering rate); once it comes to rest the brakes hold it."""
    stop = time_to_stop(x[3], x[4], u[0])
    moved = rk4(lambda state: road_bicycle(state, u, curvature(state[0]), vehicle.wheelbase_m, vehicle.centre_m, math), x, min(stop, h))
    return [*moved[:3], 0.0, 0.0, moved[5] + u[1] * (h - stop)] if stop < h else moved
