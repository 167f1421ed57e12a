"""Kinematic bicycle, in the plane at the rear axle and along a road at the body centre.

Source: Rajamani, Vehicle Dynamics and Control, 2nd ed. 2012, section 2.2 (no slip); Frenet form: Werling et al., ICRA 2010.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

STATES = ("s", "d", "psi", "v", "a", "delta")
INPUTS = ("jerk", "delta_rate")


def bicycle(x: Sequence[Any], u: Sequence[Any], wheelbase: float, m: Any) -> list[Any]:
    """dx/dt at the rear axle: x = (px, py, psi, v, delta), u = (a, delta_rate)."""
    _, _, psi, v, delta = x
    a, delta_rate = u
    return [v * m.cos(psi), v * m.sin(psi), v * m.tan(delta) / wheelbase, a, delta_rate]


def road_bicycle(x: Sequence[Any], u: Sequence[Any], kappa: Any, wheelbase: float, centre: Any, m: Any) -> list[Any]:
    """dx/dt along a road of curvature `kappa` at s: x = (s, d, psi, v, a, delta), u = (jerk, delta_rate).

    (s, d) is the body centre, `centre` [m] ahead of the rear axle; psi is relative to the road; v, a, delta are the rear axle's.
    Valid while d * kappa < 1. kappa = 0 is a straight road.
    """
    _, d, psi, v, a, delta = x
    jerk, delta_rate = u
    turn = m.tan(delta) / wheelbase
    s_dot = v * (m.cos(psi) - centre * turn * m.sin(psi)) / (1.0 - d * kappa)
    d_dot = v * (m.sin(psi) + centre * turn * m.cos(psi))
    return [s_dot, d_dot, v * turn - kappa * s_dot, a, jerk, delta_rate]


def swept_inset_m2(length: Any, centre: Any) -> Any:
    """How far inside a path, over the path's curvature [m^2], the body centre is when the middle of what a body sweeps is on it.

    On radius R a body's inner flank is `centre`^2 / 2R inside its centre's circle, beside the rear axle; its outer front corner, `front`
    ahead of that, (`front`^2 - `centre`^2) / 2R outside: to second order.
    """
    front = centre + 0.5 * length
    return 0.25 * (front * front - 2.0 * centre * centre)


def lateral_acceleration(v: Any, delta: Any, wheelbase: float, m: Any) -> Any:
    """v^2 kappa at the rear axle [m/s^2]."""
    return v**2 * m.tan(delta) / wheelbase
