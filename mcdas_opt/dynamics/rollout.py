"""Poses of the bicycle for speed and steering that are linear between given times."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.dynamics.bicycle import bicycle
from mcdas_opt.dynamics.integrator import rk4


def roll_out(
    pose: Array, t_s: Array, speed_mps: Array, steering_rad: Array, wheelbase_m: float, step_s: float
) -> tuple[Array, Array, Array]:
    """(times, poses (n, 3), index of each given time among them), from `pose` at t_s[0], in steps of at most `step_s`.

    Every step's increment is integrated in its own frame, all steps at once, and the increments are chained: the same numbers as a
    step-by-step Runge-Kutta, up to rounding.
    """
    dt = np.diff(t_s)
    counts = np.maximum(1, np.ceil(dt / step_s - 1e-9).astype(np.int64))
    ends = np.concatenate([[0], np.cumsum(counts)])
    within = np.arange(1, ends[-1] + 1) - np.repeat(ends[:-1], counts)
    h = np.repeat(dt / counts, counts)
    fine = np.concatenate([t_s[:1], np.repeat(t_s[:-1], counts) + within * h])
    rates = [np.repeat(np.diff(q) / np.maximum(dt, 1e-9), counts) for q in (speed_mps, steering_rad)]
    begin = [np.repeat(q[:-1], counts) + r * (within - 1) * h for q, r in zip((speed_mps, steering_rad), rates, strict=True)]
    zero = np.zeros_like(h)
    dx, dy, turn, _, _ = rk4(lambda x: bicycle(x, rates, wheelbase_m, np), [zero, zero, zero, *begin], h)
    psi = pose[2] + np.concatenate([[0.0], np.cumsum(turn)])
    c, s = np.cos(psi[:-1]), np.sin(psi[:-1])
    x = pose[0] + np.concatenate([[0.0], np.cumsum(c * dx - s * dy)])
    y = pose[1] + np.concatenate([[0.0], np.cumsum(s * dx + c * dy)])
    return fine, np.column_stack([x, y, psi]), ends
