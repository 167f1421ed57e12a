"""The closed forms that the program is measured against: two arcs, the paper's reverse sigmoid, and that sigmoid made drivable.

All three drive straight until the goal is behind, then reverse sideways into it; they see the slot's offset, not its walls.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.dynamics.rollout import roll_out
from mcdas_opt.dynamics.sigmoid import renormalised, sigmoid
from mcdas_opt.errors import ParameterError
from mcdas_opt.parking.path import Arc, ArcPath, knots_of, sampled, top_curvature

_LITERAL_A, _LITERAL_B, _LITERAL_MPS = 0.4, 50.0, 1.0  # Table 5, whose b goes from 45 to 60
_POINTS = 401
_WIDER = 10.0  # no sigmoid has to be so much wider than it reaches: the search for one runs away


def two_arc(case: ParkingCase) -> ParkingTrajectory:
    """Two arcs of the smallest radius, one against the other, that end along the goal (the parallel-parking S of geometry)."""
    ahead, offset, top = _offset(case)
    radius = 1.0 / top
    angle = float(np.arccos(np.clip(1.0 - abs(offset) / (2.0 * radius), -1.0, 1.0)))
    side = 1.0 if offset >= 0.0 else -1.0
    straight = Arc(0.0, 2.0 * radius * float(np.sin(angle)) - ahead)
    arcs = (straight, Arc(-side * top, -radius * angle), Arc(side * top, -radius * angle))
    return sampled(case, *knots_of(case, ArcPath(case.start, tuple(arc for arc in arcs if abs(arc.length) > 1e-9))))


def corrected(case: ParkingCase) -> ParkingTrajectory:
    """The sigmoid's curvature, its steepness set by the steering limit, integrated from the start's heading: both headings are met.

    Speed stays under what the steering rate allows.
    """
    ahead, offset, top = _offset(case)
    limits, car = case.limits, case.vehicle
    along, kappa = _profile(abs(offset), 0.99 * top)
    side = 1.0 if offset >= 0.0 else -1.0
    delta = -side * np.arctan(kappa * car.wheelbase_m)
    steepest = float(np.max(np.abs(np.diff(delta) / np.diff(along))))
    cruise = min(limits.reverse_mps, 0.98 * car.steering_rate_max_radps / max(steepest, 1e-9))
    a = limits.acceleration_mps2
    v = np.minimum(cruise, np.sqrt(2.0 * a * np.minimum(along, along[-1] - along)))
    dt = 2.0 * np.diff(along) / np.maximum(v[1:] + v[:-1], 1e-9)
    reach = _driven(along, kappa)[-1, 0]
    t, speed, steering = knots_of(case, ArcPath(case.start, (Arc(0.0, reach - ahead),) if abs(reach - ahead) > 1e-9 else ()))
    standing = t[-1] + max(abs(delta[0] - steering[-1]) / car.steering_rate_max_radps, 1e-3)
    times = np.concatenate([t, [standing], standing + np.cumsum(dt)])
    return sampled(case, times, np.concatenate([speed, -v]), np.concatenate([steering, delta]))


def literal(case: ParkingCase) -> ParkingTrajectory:
    """Eq 27-28 as published: x = -K t, y = y(0) - y_max / (1 + b exp(a x)), with Table 5's a and b; nothing bounds it.

    Heading and steering are the tangent's and the curvature's. Speed jumps to K at once, as there.
    """
    ahead, offset, _ = _offset(case)
    a, b = _LITERAL_A, _LITERAL_B
    length = 2.0 * float(np.log(b)) / a
    x = np.linspace(0.0, length, 1 + int(np.ceil(length / (0.04 * _LITERAL_MPS))))
    y = offset - offset * sigmoid(x, -a, b, np)
    slope = np.gradient(y, x)
    curvature = np.gradient(slope, x) / (1.0 + slope**2) ** 1.5
    ground = np.hypot(1.0, slope) * _LITERAL_MPS
    lead = np.arange(0.0, max(length - ahead, 0.0), 0.04)
    local = np.column_stack([np.concatenate([ahead + lead, length - x]), np.concatenate([np.full(lead.size, offset), y])])
    heading = np.concatenate([np.zeros(lead.size), np.arctan(-slope)])
    speed = np.concatenate([np.full(lead.size, _LITERAL_MPS), -ground])
    steering = np.concatenate([np.zeros(lead.size), np.arctan(curvature * case.vehicle.wheelbase_m)])
    t = 0.04 / _LITERAL_MPS * np.arange(len(local))
    c, s = np.cos(case.goal[2]), np.sin(case.goal[2])
    poses = np.column_stack(
        [
            case.goal[0] + c * local[:, 0] - s * local[:, 1],
            case.goal[1] + s * local[:, 0] + c * local[:, 1],
            case.goal[2] + heading,
        ]
    )
    return ParkingTrajectory.from_controls(np.asarray(t, dtype=np.float64), poses, speed, steering)


CLOSED_FORMS: dict[str, Callable[[ParkingCase], ParkingTrajectory]] = {
    "closed-form": literal,
    "closed-form-corrected": corrected,
    "two-arc": two_arc,
}


def _offset(case: ParkingCase) -> tuple[float, float, float]:
    """(how far ahead of the goal the start stands, how far to its left, the largest curvature), along the goal's heading."""
    dx, dy = case.start[0] - case.goal[0], case.start[1] - case.goal[1]
    c, s = np.cos(case.goal[2]), np.sin(case.goal[2])
    return float(c * dx + s * dy), float(c * dy - s * dx), top_curvature(case.vehicle)


def _profile(offset: float, top: float) -> tuple[Array, Array]:
    """(distance, curvature) of the sigmoid that moves sideways by `offset` with curvature up to `top`. Raises `ParameterError` where there
    is none."""
    amplitude = max(offset, 1e-6)
    along = kappa = np.zeros(2)
    for _ in range(12):
        low, high = 0.01, 10.0
        for _ in range(50):
            a = float(np.sqrt(low * high))
            along, kappa = _sigmoid_curvature(amplitude, a)
            low, high = (a, high) if np.abs(kappa).max() < top else (low, a)
        amplitude *= offset / max(_driven(along, kappa)[-1, 1], 1e-9) if offset > 1e-6 else 1.0
        if amplitude > _WIDER * max(offset, 1e-6):
            raise ParameterError("goal", offset, "is farther to the side than one sigmoid of this car reaches", "m")
    return along, kappa


def _sigmoid_curvature(amplitude: float, a: float) -> tuple[Array, Array]:
    x = np.linspace(0.0, 2.0 * np.log(_LITERAL_B) / a, _POINTS)
    y = amplitude * renormalised(x, -a, _LITERAL_B, np)
    slope = np.gradient(y, x, edge_order=2)
    kappa = np.gradient(slope, x, edge_order=2) / (1.0 + slope**2) ** 1.5
    kappa = 0.5 * (kappa - kappa[::-1])  # exactly antisymmetric, so that the heading comes back
    ground = np.hypot(1.0, slope)
    ground = 0.5 * (ground + ground[::-1])
    return np.concatenate([[0.0], np.cumsum(0.5 * (ground[1:] + ground[:-1]) * np.diff(x))]), kappa


def _driven(along: Array, kappa: Array) -> Array:
    """Poses of driving a curvature profile at 1 m/s from the origin."""
    _, poses, _ = roll_out(np.zeros(3), along, np.ones(along.size), np.arctan(kappa), 1.0, 1e9)
    return poses
