"""When a car that brakes comes to rest."""

from __future__ import annotations

import math

import numpy as np

from mcdas_opt.domain.rules import Array


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
