"""The judge of parking: integrates speed and steering anew, and measures the body against every obstacle throughout.

Shares no solver and no search with the planners. Anybody's trajectory may be handed in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.dynamics.rollout import roll_out
from mcdas_opt.geometry.angles import wrapped
from mcdas_opt.geometry.clearance import Body, obstacle_field

STEP_S = 0.005
SAMPLING_S = 0.05
_LIMIT_SHARE = 0.01  # tolerance on limits
_POSE_M, _POSE_RAD = 0.005, 0.002  # how far claimed poses may lie off their integral
_REST_MPS = 1e-3


@dataclass(frozen=True, slots=True)
class Judgement:
    """The verdict, and what was measured for it."""

    verdict: Verdict
    min_clearance_m: float | None
    poses: Array  # (n, 3) re-integrated


def judge_parking(case: ParkingCase, trajectory: ParkingTrajectory) -> Judgement:
    """Judge a trajectory in the case's coordinates (relative to its origin).

    Checked: two samples or more, every column finite, in time order at most 0.05 s apart; start pose, steering and rest; limits of
    speed, acceleration, steering angle and rate from the slopes, whatever their columns claim; poses against the 5 ms integral of speed
    and steering; clearance of the integrated body, and of the claimed one; end pose and rest.
    """
    t = trajectory.t_s
    unreadable = _unreadable(trajectory)
    if unreadable is not None:
        return Judgement(Verdict(violations=(unreadable,)), None, trajectory.poses[:0])
    found: list[Violation] = []
    _start(case, trajectory, found)
    _limits(case, trajectory, found)
    fine_t, poses, at_samples = roll_out(
        trajectory.poses[0], t, trajectory.speed_mps, trajectory.steering_rad, case.vehicle.wheelbase_m, STEP_S
    )
    _integral(trajectory, poses[at_samples], found)
    (field, owner), body = obstacle_field(case.obstacles), Body.of(case.vehicle)
    clearance = field.separation(poses, body)
    _clearance(case, ViolationKind.CLEARANCE, clearance, owner, fine_t, found)
    if any(v.kind is ViolationKind.INTEGRAL for v in found):
        _clearance(case, ViolationKind.PUBLISHED_CLEARANCE, field.separation(trajectory.poses, body), owner, t, found)
    _end(case, trajectory, poses[-1], found)
    _exceeds(found, ViolationKind.SAMPLING, t[:-1], np.diff(t), SAMPLING_S, "s", 1e-6)
    least = float(clearance.min()) if clearance.size else None
    return Judgement(Verdict(violations=tuple(found)), least, poses)


def _unreadable(trajectory: ParkingTrajectory) -> Violation | None:
    """What leaves nothing to drive: too few samples, numbers that are none, time that stands or runs back."""
    t = trajectory.t_s
    if len(t) < 2:
        return Violation(kind=ViolationKind.SAMPLING, t_s=0.0, value=float(len(t)), limit=2.0, unit="samples")
    bad = int(np.sum(~np.isfinite(list(trajectory.columns().values()))))
    if bad:
        return Violation(kind=ViolationKind.NOT_FINITE, t_s=0.0, value=float(bad), limit=0.0, unit="values")
    dt = np.diff(t)
    if dt.min() < 0.0 or t[-1] <= t[0]:
        k = int(np.argmin(dt))
        return Violation(kind=ViolationKind.TIME_ORDER, t_s=float(t[k]), value=float(dt[k]), limit=0.0, unit="s")
    return None


def _exceeds(found: list[Violation], kind: ViolationKind, t: Array, value: Array, limit: float, unit: str, slack: float) -> None:
    """Record the worst of |value| where it exceeds `limit` by more than `slack`, which is the limit of what ought to be nothing."""
    if value.size == 0:
        return
    k = int(np.argmax(np.abs(value)))
    if abs(float(value[k])) > limit + slack:
        found.append(Violation(kind=kind, t_s=float(t[min(k, len(t) - 1)]), value=abs(float(value[k])), limit=limit or slack, unit=unit))


def _start(case: ParkingCase, trajectory: ParkingTrajectory, found: list[Violation]) -> None:
    at = trajectory.t_s[:1]
    off = trajectory.poses[0] - case.start
    _exceeds(found, ViolationKind.START_POSITION, at, np.array([np.hypot(off[0], off[1])]), 0.0, "m", case.tolerance.position_m)
    _exceeds(found, ViolationKind.START_HEADING, at, np.array([wrapped(off[2])]), 0.0, "rad", case.tolerance.heading_rad)
    _exceeds(found, ViolationKind.START_STEERING, at, trajectory.steering_rad[:1] - case.start_steering_rad, 0.0, "rad", 0.01)
    _exceeds(found, ViolationKind.START_SPEED, at, trajectory.speed_mps[:1], 0.0, "m/s", _REST_MPS)


def _limits(case: ParkingCase, trajectory: ParkingTrajectory, found: list[Violation]) -> None:
    t, v, delta = trajectory.t_s, trajectory.speed_mps, trajectory.steering_rad
    dt = np.maximum(np.diff(t), 1e-9)  # two samples at one time are a jump
    limits, car = case.limits, case.vehicle
    for kind, value, limit, unit in (
        (ViolationKind.FORWARD_SPEED, np.maximum(v, 0.0), limits.forward_mps, "m/s"),
        (ViolationKind.REVERSE_SPEED, np.minimum(v, 0.0), limits.reverse_mps, "m/s"),
        (ViolationKind.ACCELERATION, np.diff(v) / dt, limits.acceleration_mps2, "m/s^2"),
        (ViolationKind.STEERING_ANGLE, delta, car.steering_max_rad, "rad"),
        (ViolationKind.STEERING_RATE, np.diff(delta) / dt, car.steering_rate_max_radps, "rad/s"),
    ):
        _exceeds(found, kind, t, value, limit, unit, _LIMIT_SHARE * limit)


def _integral(trajectory: ParkingTrajectory, integrated: Array, found: list[Violation]) -> None:
    off = trajectory.poses - integrated
    apart = np.hypot(off[:, 0], off[:, 1])
    before = len(found)
    _exceeds(found, ViolationKind.INTEGRAL, trajectory.t_s, apart, 0.0, "m", _POSE_M)
    if len(found) == before:
        _exceeds(found, ViolationKind.INTEGRAL, trajectory.t_s, wrapped(off[:, 2]), 0.0, "rad", _POSE_RAD)


def _clearance(case: ParkingCase, kind: ViolationKind, apart: Array, owner: list[int], t: Array, found: list[Violation]) -> None:
    """The worst of all obstacles; overlap is named as such."""
    if apart.size == 0:
        return
    k, part = np.unravel_index(int(np.argmin(apart)), apart.shape)
    least, limit = float(apart[k, part]), case.limits.clearance_m
    if least < limit - max(_LIMIT_SHARE * limit, 1e-6):
        obstacle = case.names[owner[int(part)]]
        found.append(Violation(kind=kind, t_s=float(t[k]), value=least, limit=limit, unit="m", body=obstacle))


def _end(case: ParkingCase, trajectory: ParkingTrajectory, pose: Array, found: list[Violation]) -> None:
    at = trajectory.t_s[-1:]
    off = pose - case.goal
    _exceeds(found, ViolationKind.END_POSITION, at, np.array([np.hypot(off[0], off[1])]), 0.0, "m", case.tolerance.position_m)
    _exceeds(found, ViolationKind.END_HEADING, at, np.array([wrapped(off[2])]), 0.0, "rad", case.tolerance.heading_rad)
    _exceeds(found, ViolationKind.END_SPEED, at, trajectory.speed_mps[-1:], 0.0, "m/s", _REST_MPS)
