"""The trajectory driven again in the plane, in steps of 0.02 s.

The kinematic bicycle is a cascade: acceleration and steering follow from the inputs, speed from acceleration, yaw from speed and
steering, position from yaw and speed. Each stage is a time integral of the stage before, so that every interval, and the whole drive,
is integrated at once by Simpson's rule on `dynamics.bicycle` (with known time integrands that is the Runge-Kutta method, to the same
order). In the plane this holds on every road; the Frenet frame only says where the samples are.

Braking ends at standstill: where the speed meets 0 the car may stand, its deceleration 0 at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Violation
from mcdas_opt.dynamics.bicycle import bicycle
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.verification.finding import above, wrapped
from mcdas_opt.verification.tolerances import Tolerances

FINE_STEP_S = 0.02
_MOST_STEPS = 5  # a sample interval of the contract; a longer one is refused for its length and looked at more coarsely


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """What the samples and their inputs make the car do between them, K intervals of m fine steps each.

    `t_s`, `speed_mps`, `acceleration_mps2`, `steering_rad` are (K m + K + 1,): each interval from its own sample to its integrated
    end, and the last sample. `node_*` are (K m + 1,) body-centre poses in the plane at every fine time, `middle_*` (K m,) half a step
    later; they are bent (by less than the residual) to pass through every sample.
    """

    t_s: Array
    speed_mps: Array
    acceleration_mps2: Array
    steering_rad: Array
    node_t_s: Array
    node_s_m: Array
    node_x_m: Array
    node_y_m: Array
    node_yaw_rad: Array
    middle_t_s: Array
    middle_x_m: Array
    middle_y_m: Array
    middle_yaw_rad: Array


def drive(trajectory: Trajectory, vehicle: Vehicle, frame: FrenetFrame, tolerances: Tolerances) -> tuple[Motion, list[Violation]]:
    """The fine motion, and the violations 'dynamics residual' and 're-integrated end'."""
    t = trajectory.t_s
    dt = np.diff(t)
    k = dt.size
    count = min(max(math.ceil(float(dt.max()) / FINE_STEP_S - 1e-6), 1), _MOST_STEPS)
    half = np.linspace(0.0, 1.0, 2 * count + 1)
    tau = dt[:, None] * half
    centre, wheelbase = vehicle.centre_m, vehicle.wheelbase_m

    x, y, yaw = frame.to_plane(trajectory.s_m, trajectory.d_m, trajectory.heading_rad)
    v, a, delta = trajectory.speed_mps, trajectory.acceleration_mps2, trajectory.steering_rad
    fine_v, fine_a, fine_delta, fine_yaw, run_yaw, way_x, way_y = _integrated(trajectory, yaw, tau, wheelbase, tolerances.reverse_mps)

    off = math.hypot(
        float(x[0] - x[-1] + way_x[k:, -1].sum()) + centre * (math.cos(run_yaw) - math.cos(yaw[0])),
        float(y[0] - y[-1] + way_y[k:, -1].sum()) + centre * (math.sin(run_yaw) - math.sin(yaw[0])),
    )
    turn = abs(math.remainder(float(yaw[-1]) - run_yaw, math.tau))
    fine_x = (x[:-1] - centre * np.cos(yaw[:-1]))[:, None] + way_x[:k] + centre * np.cos(fine_yaw)
    fine_y = (y[:-1] - centre * np.sin(yaw[:-1]))[:, None] + way_y[:k] + centre * np.sin(fine_yaw)
    miss_x, miss_y, miss_yaw = x[1:] - fine_x[:, -1], y[1:] - fine_y[:, -1], wrapped(yaw[1:] - fine_yaw[:, -1])
    found = _residual(
        t[1:],
        (
            (np.hypot(miss_x, miss_y), tolerances.residual_position_m, "m"),
            (np.abs(miss_yaw), tolerances.residual_heading_rad, "rad"),
            (np.abs(v[1:] - fine_v[:, -1]), tolerances.residual_speed_mps, "m/s"),
            (np.abs(a[1:] - fine_a[:, -1]), tolerances.residual_acceleration_mps2, "m/s^2"),
            (np.abs(delta[1:] - fine_delta[:, -1]), tolerances.residual_steering_rad, "rad"),
        ),
    )
    found += _end(float(t[-1]), off, turn, tolerances)

    fine_t = t[:-1, None] + tau
    fine_s = trajectory.s_m[:-1, None] + np.diff(trajectory.s_m)[:, None] * half
    fine_x += miss_x[:, None] * half
    fine_y += miss_y[:, None] * half
    fine_yaw = fine_yaw + miss_yaw[:, None] * half
    motion = Motion(
        t_s=_with_last(fine_t[:, ::2], t[-1]),
        speed_mps=_with_last(fine_v[:, ::2], v[-1]),
        acceleration_mps2=_with_last(fine_a[:, ::2], a[-1]),
        steering_rad=_with_last(fine_delta[:, ::2], delta[-1]),
        node_t_s=_with_last(fine_t[:, :-1:2], t[-1]),
        node_s_m=_with_last(fine_s[:, :-1:2], trajectory.s_m[-1]),
        node_x_m=_with_last(fine_x[:, :-1:2], x[-1]),
        node_y_m=_with_last(fine_y[:, :-1:2], y[-1]),
        node_yaw_rad=_with_last(fine_yaw[:, :-1:2], fine_yaw[-1, -1]),
        middle_t_s=fine_t[:, 1::2].ravel(),
        middle_x_m=fine_x[:, 1::2].ravel(),
        middle_y_m=fine_y[:, 1::2].ravel(),
        middle_yaw_rad=fine_yaw[:, 1::2].ravel(),
    )
    return motion, found


def _integrated(
    trajectory: Trajectory, yaw: Array, tau: Array, wheelbase: float, rest_mps: float
) -> tuple[Array, Array, Array, Array, float, Array, Array]:
    """Fine speed, acceleration, steering, yaw (K, 2m + 1) of every interval from its own sample; the yaw at the end of the whole drive
    from the first sample and the inputs alone; and the ways of the rear axle (2K, 2m + 1) in x and y, the intervals' and the drive's.
    """
    v, a, delta = trajectory.speed_mps, trajectory.acceleration_mps2, trajectory.steering_rad
    jerk, rate = trajectory.jerk_mps3[:-1], trajectory.steering_rate_radps[:-1]
    dt, k = tau[:, -1], len(tau)
    free_a, free_v = _under_jerk(a[:-1], v[:-1], jerk, tau)
    held = _brought_to_rest(free_v, free_a[:, -1], a[1:], rest_mps)
    run_a = _chain(a[0], jerk * dt, held)
    run_v = _chain(v[0], (run_a[:-1] + 0.5 * jerk * dt) * dt, held)
    run_delta = _chain(delta[0], rate * dt)
    drive_a, drive_v = _under_jerk(run_a[:-1], run_v[:-1], jerk, tau)
    # the intervals' rows and below them the drive's, so that both are integrated at once
    fine_a, fine_v = np.concatenate([free_a, drive_a]), np.concatenate([free_v, drive_v])
    fine_delta = np.concatenate([delta[:-1], run_delta[:-1]])[:, None] + np.tile(rate[:, None] * tau, (2, 1))
    if held.any():
        at_rest = np.tile(held, 2)[:, None] & (np.minimum.accumulate(fine_v, axis=1) <= rest_mps)
        fine_a[at_rest], fine_v[at_rest] = 0.0, 0.0
    h = np.tile(2.0 * tau[:, 1], 2)[:, None]
    turned = _integral(bicycle((0.0, 0.0, 0.0, fine_v, fine_delta), (0.0, 0.0), wheelbase, np)[2], h)
    run_yaw = _chain(yaw[0], turned[k:, -1])
    fine_yaw = np.concatenate([yaw[:-1], run_yaw[:-1]])[:, None] + turned
    dx, dy, *_ = bicycle((0.0, 0.0, fine_yaw, fine_v, fine_delta), (0.0, 0.0), wheelbase, np)
    return fine_v[:k], fine_a[:k], fine_delta[:k], fine_yaw[:k], float(run_yaw[-1]), _integral(dx, h), _integral(dy, h)


def _under_jerk(a: Array, v: Array, jerk: Array, tau: Array) -> tuple[Array, Array]:
    """Acceleration and speed (K, 2m + 1) under constant jerk: exact."""
    a, v, jerk = a[:, None], v[:, None], jerk[:, None]
    return a + jerk * tau, v + tau * (a + 0.5 * jerk * tau)


def _integral(f: Array, h: Array) -> Array:
    """Integral of f (K, 2m + 1), given at the ends and middles of steps h (K, 1), by the parabola through each step's three values."""
    first, middle, last = f[:, :-1:2], 8.0 * f[:, 1::2], f[:, 2::2]
    step = h / 24.0
    out = np.zeros_like(f)
    whole = np.cumsum(step * (4.0 * (first + last) + 2.0 * middle), axis=1)
    out[:, 2::2] = whole
    out[:, 1::2] = step * (5.0 * first + middle - last)
    out[:, 3::2] += whole[:, :-1]
    return out


def _brought_to_rest(free_v: Array, free_a_end: Array, next_a: Array, rest_mps: float) -> NDArray[np.bool_]:
    """Intervals (K,) in which the brakes stop the car and hold it, by the sample that follows.

    Where the speed would fall through 0 the car stands instead, and its deceleration ends at once: the one jump of acceleration that
    no jerk limit forbids. A trajectory that runs through 0 smoothly, its acceleration going on, is not taken for that.
    """
    stops = (free_v.min(axis=1) <= rest_mps) & (free_a_end < 0.0)
    return np.asarray(stops & (np.abs(next_a) < np.abs(next_a - free_a_end)))


def _chain(first: float, increments: Array, held: NDArray[np.bool_] | None = None) -> Array:
    """The sum (K + 1,) that begins at `first`, and anew at 0 after every interval in which the car came to rest."""
    total = np.concatenate([np.zeros(1), np.cumsum(increments)])
    if held is None or not held.any():
        return np.asarray(first + total)
    rest = np.maximum.accumulate(np.concatenate([np.zeros(1, dtype=np.intp), np.where(held, np.arange(1, held.size + 1), 0)]))
    return np.asarray(np.where(rest > 0, total - total[rest], first + total))


def _with_last(fine: Array, last: float) -> Array:
    return np.append(fine, last)


def _residual(t: Array, parts: tuple[tuple[Array, float, str], ...]) -> list[Violation]:
    """The part of the state that misses the next sample by most, in units of its tolerance."""
    shares = [float(value.max()) / allowed for value, allowed, _ in parts]
    value, allowed, unit = parts[int(np.argmax(shares))]
    return above("dynamics residual", t, value, allowed, allowed, unit)


def _end(t: float, off_m: float, turn_rad: float, tolerances: Tolerances) -> list[Violation]:
    for value, limit, unit in ((off_m, tolerances.end_position_m, "m"), (turn_rad, tolerances.end_heading_rad, "rad")):
        if value > limit:
            return [Violation(name="re-integrated end", t_s=t, value=value, limit=limit, unit=unit)]
    return []
