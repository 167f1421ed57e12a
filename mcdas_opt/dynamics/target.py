"""Constant-velocity motion of a target along and across the road: x = (s, vs, d, vd)."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array


def transition(dt: float) -> Array:
    """(4, 4) F with x(t + dt) = F x(t); a negative dt goes back."""
    return np.array([[1.0, dt, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, dt], [0.0, 0.0, 0.0, 1.0]])


def process_noise(dt: float, along: float, across: float) -> Array:
    """(4, 4) Q of discrete white-noise acceleration: constant over the step, standard deviations `along`, `across` [m/s^2].

    Per axis sd^2 [[dt^4 / 4, dt^3 / 2], [dt^3 / 2, dt^2]] (Bar-Shalom, Li, Kirubarajan, Estimation, 2001, section 6.3.2). One long
    step has more noise than two short ones: an acceleration lasts as long as nobody has looked.
    """
    p, c, v = 0.25 * dt**4, 0.5 * dt**3, dt**2
    a, b = along**2, across**2
    return np.array([[a * p, a * c, 0.0, 0.0], [a * c, a * v, 0.0, 0.0], [0.0, 0.0, b * p, b * c], [0.0, 0.0, b * c, b * v]])
