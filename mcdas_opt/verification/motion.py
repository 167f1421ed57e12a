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
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.dynamics.bicycle import bicycle
from mcdas_opt.geometry.angles import wrapped
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.verification.finding import Findings
from mcdas_opt.verification.record import Samples
from mcdas_opt.verification.tolerances import CONTRACT

FINE_STEP_S = 0.02
BETWEEN_SAMPLES_M = 0.05  # a lateral motion bows out of its samples' chords by a quarter of that at 1 g
_MOST_STEPS = 5  # a sample interval of the contract; a longer one is refused for its length and looked at more coarsely


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """What the samples and their inputs make C cars do between them, K intervals of m fine steps each; times are the same for all.

    `speed_mps`, `acceleration_mps2`, `steering_rad` are (C, K m + K + 1) at `t_s`: each interval from its own sample to its integrated
    end, and the last sample. `node_*` are (C, K m + 1) body-centre poses in the plane at every fine time, `middle_*` (C, K m) half a
    step later; they are bent (by less than the residual) to pass through every sample. `node_s_m` and `node_d_m` are on the samples'
    chords.
    """

    t_s: Array
    speed_mps: Array
    acceleration_mps2: Array
    steering_rad: Array
    node_t_s: Array
    node_s_m: Array
    node_d_m: Array
    node_x_m: Array
    node_y_m: Array
    node_yaw_rad: Array
    middle_t_s: Array
    middle_x_m: Array
    middle_y_m: Array
    middle_yaw_rad: Array

    @property
    def every_t_s(self) -> Array:
        """The fine times and those half a step later, in turn (2 K m + 1)."""
        t_s = np.empty(2 * self.node_t_s.size - 1)
        t_s[::2], t_s[1::2] = self.node_t_s, self.middle_t_s
        return t_s


def drive(samples: Samples, vehicle: Vehicle, frame: FrenetFrame, found: Findings) -> Motion:
    """The fine motion; finds 'dynamics residual' and 're-integrated end'."""
    t = samples.t_s
    dt = t[1:] - t[:-1]
    half = _halves(min(max(math.ceil(float(dt.max()) / FINE_STEP_S - 1e-6), 1), _MOST_STEPS))
    tau = dt[:, None] * half
    centre = vehicle.centre_m

    ends = np.array(frame.to_plane(samples.s_m, samples.d_m, samples.heading_rad))  # (3, C, K + 1): x, y, yaw
    fine, run, way = _integrated(samples, ends[2], tau, vehicle.wheelbase_m, CONTRACT.reverse_mps)
    swing = centre * np.array([np.cos(ends[2]), np.sin(ends[2])])  # from the rear axle to the body centre
    reached = way[:, 1, :, :, -1].sum(axis=-1) + centre * np.array([np.cos(run), np.sin(run)]) - swing[..., 0]
    off = np.hypot(*(ends[:2, :, 0] + reached - ends[:2, :, -1]))
    turn = np.abs(wrapped(ends[2, :, -1] - run))

    pose = np.empty((3, *fine.shape[1:]))
    pose[:2], pose[2] = way[:, 0], fine[3]
    pose[:2] += (ends[:2, :, :-1] - swing[..., :-1])[..., None]
    pose[0] += centre * np.cos(fine[3])
    pose[1] += centre * np.sin(fine[3])
    miss = ends[..., 1:] - pose[..., -1]
    miss[2] = wrapped(miss[2])
    given = np.array([samples.speed_mps, samples.acceleration_mps2, samples.steering_rad])  # (3, C, K + 1), as fine[:3]
    _residual(t[1:], miss, given[..., 1:] - fine[:3, ..., -1], found)
    _end(float(t[-1]), off, turn, found)

    pose += miss[..., None] * half
    ends[2, :, -1] = pose[2, :, -1, -1]  # the yaw goes on from where it was, without a turn
    fine_t = t[:-1, None] + tau
    road = np.array([samples.s_m, samples.d_m])
    chord = road[..., :-1, None] + (road[..., 1:] - road[..., :-1])[..., None] * half[:-1:2]
    speed, acceleration, steering = _joined(fine[:3, ..., ::2], given[..., -1])
    node_s, node_d = _joined(chord, road[..., -1])
    x, y, yaw = _joined(pose[..., :-1:2], ends[..., -1])
    middle_x, middle_y, middle_yaw = pose[..., 1::2].reshape(3, len(run), -1)
    return Motion(
        t_s=_joined(fine_t[:, ::2], t[-1]),
        speed_mps=speed,
        acceleration_mps2=acceleration,
        steering_rad=steering,
        node_t_s=_joined(fine_t[:, :-1:2], t[-1]),
        node_s_m=node_s,
        node_d_m=node_d,
        node_x_m=x,
        node_y_m=y,
        node_yaw_rad=yaw,
        middle_t_s=fine_t[:, 1::2].ravel(),
        middle_x_m=middle_x,
        middle_y_m=middle_y,
        middle_yaw_rad=middle_yaw,
    )


@lru_cache(maxsize=8)
def _halves(count: int) -> Array:
    """Shares of an interval (2 count + 1,) at the ends and middles of its fine steps."""
    return np.linspace(0.0, 1.0, 2 * count + 1)


def _integrated(samples: Samples, yaw: Array, tau: Array, wheelbase: float, rest_mps: float) -> tuple[Array, Array, Array]:
    """Fine speed, acceleration, steering, yaw (4, C, K, 2m + 1) of every interval from its own sample; the yaw (C,) at the end of the
    whole drive from the first sample and the inputs alone; the ways of the rear axle (2, 2, C, K, 2m + 1): x and y, the intervals' and
    the drive's.
    """
    v, a, delta = samples.speed_mps, samples.acceleration_mps2, samples.steering_rad
    jerk, rate = samples.jerk_mps3[:, :-1], samples.steering_rate_radps[:, :-1]
    dt = tau[:, -1]
    count, k = jerk.shape
    # [0]: the intervals, [1]: the drive, so that both are integrated at once
    fine_a, fine_v = np.empty((2, 2, count, k, tau.shape[1]))
    fine_a[0], fine_v[0] = _under_jerk(a[:, :-1], v[:, :-1], jerk, tau)
    held = _brought_to_rest(fine_v[0], fine_a[0, ..., -1], a[:, 1:], rest_mps)
    run_a = _chain(a[:, 0], jerk * dt, held)
    run_v = _chain(v[:, 0], (run_a[:, :-1] + 0.5 * jerk * dt) * dt, held)
    run_delta = _chain(delta[:, 0], rate * dt)
    fine_a[1], fine_v[1] = _under_jerk(run_a[:, :-1], run_v[:, :-1], jerk, tau)
    fine_delta = np.array([delta[:, :-1], run_delta[:, :-1]])[..., None] + rate[..., None] * tau
    if held.any():
        at_rest = held[..., None] & (np.minimum.accumulate(fine_v, axis=-1) <= rest_mps)
        fine_a[at_rest], fine_v[at_rest] = 0.0, 0.0
    h = 2.0 * tau[:, 1:2]
    turned = _integral(bicycle((0.0, 0.0, 0.0, fine_v, fine_delta), (0.0, 0.0), wheelbase, np)[2], h)
    run_yaw = _chain(yaw[:, 0], turned[1, ..., -1])
    fine_yaw = np.array([yaw[:, :-1], run_yaw[:, :-1]])[..., None] + turned
    velocity = np.array(bicycle((0.0, 0.0, fine_yaw, fine_v, 0.0), (0.0, 0.0), wheelbase, np)[:2])
    return np.array([fine_v[0], fine_a[0], fine_delta[0], fine_yaw[0]]), run_yaw[:, -1], _integral(velocity, h)


def _under_jerk(a: Array, v: Array, jerk: Array, tau: Array) -> tuple[Array, Array]:
    """Acceleration and speed (C, K, 2m + 1) under constant jerk: exact."""
    a, v, gained = a[..., None], v[..., None], jerk[..., None] * tau
    return a + gained, v + tau * (a + 0.5 * gained)


def _integral(f: Array, h: Array) -> Array:
    """Integral of f (..., K, 2m + 1), given at the ends and middles of steps h (K, 1), by the parabola through each step's values."""
    return np.asarray((f @ _parabolas(f.shape[-1] // 2)) * h)


@lru_cache(maxsize=8)
def _parabolas(count: int) -> Array:
    """(2 count + 1, 2 count + 1): values at the ends and middles of unit steps to the integral up to there."""
    weights = np.zeros((2 * count + 1, 2 * count + 1))
    for i in range(count):
        first = slice(2 * i, 2 * i + 3)
        weights[:, 2 * i + 1] = weights[:, 2 * i + 2] = weights[:, 2 * i]
        weights[first, 2 * i + 1] += np.array([5.0, 8.0, -1.0]) / 24.0
        weights[first, 2 * i + 2] += np.array([4.0, 16.0, 4.0]) / 24.0
    return weights


def _brought_to_rest(free_v: Array, free_a_end: Array, next_a: Array, rest_mps: float) -> NDArray[np.bool_]:
    """Intervals (C, K) in which the brakes stop the car and hold it, by the sample that follows.

    Where the speed would fall through 0 the car stands instead, and its deceleration ends at once: the one jump of acceleration that
    no jerk limit forbids. A trajectory that runs through 0 smoothly, its acceleration going on, is not taken for that.
    """
    stops = (free_v.min(axis=-1) <= rest_mps) & (free_a_end < 0.0)
    return np.asarray(stops & (np.abs(next_a) < np.abs(next_a - free_a_end)))


def _chain(first: Array, increments: Array, held: NDArray[np.bool_] | None = None) -> Array:
    """The sums (C, K + 1) that begin at `first` (C,), and anew at 0 after every interval in which the car came to rest."""
    count, k = increments.shape
    total = np.zeros((count, k + 1))
    np.cumsum(increments, axis=-1, out=total[:, 1:])
    if held is None or not held.any():
        return total + first[:, None]
    rest = np.zeros((count, k + 1), dtype=np.intp)
    rest[:, 1:] = np.maximum.accumulate(np.where(held, np.arange(1, k + 1), 0), axis=-1)
    return np.asarray(np.where(rest > 0, total - np.take_along_axis(total, rest, axis=-1), first[:, None] + total))


def _joined(fine: Array, last: Array) -> Array:
    """(..., K, m) and the value after them (...): one row (..., K m + 1)."""
    *leading, k, m = fine.shape
    out = np.empty((*leading, k * m + 1))
    out[..., :-1] = fine.reshape(*leading, k * m)
    out[..., -1] = last
    return out


def _residual(t: Array, pose: Array, rest: Array, found: Findings) -> None:
    """The part of the state that misses the next sample by most, in units of its tolerance; `pose` and `rest` (3, C, K) are the misses
    of x, y, yaw and of speed, acceleration, steering.
    """
    parts = (
        (np.hypot(pose[0], pose[1]), CONTRACT.residual_position_m, "m"),
        (np.abs(pose[2]), CONTRACT.residual_heading_rad, "rad"),
        *zip(
            np.abs(rest),
            (CONTRACT.residual_speed_mps, CONTRACT.residual_acceleration_mps2, CONTRACT.residual_steering_rad),
            ("m/s", "m/s^2", "rad"),
            strict=True,
        ),
    )
    if all(value.max() <= allowed for value, allowed, _ in parts):
        return
    shares = np.array([value.max(axis=-1) / allowed for value, allowed, _ in parts])
    for which in np.flatnonzero(~(shares.max(axis=0) <= 1.0)).tolist():
        value, allowed, unit = parts[int(shares[:, which].argmax())]
        worst = int(value[which].argmax())
        found.add(which, ViolationKind.RESIDUAL, t[worst], value[which, worst], allowed, unit)


def _end(t: float, off_m: Array, turn_rad: Array, found: Findings) -> None:
    for which, (off, turn) in enumerate(zip(off_m.tolist(), turn_rad.tolist(), strict=True)):
        if off > CONTRACT.end_position_m:
            found.add(which, ViolationKind.REINTEGRATED_END, t, off, CONTRACT.end_position_m, "m")
        elif turn > CONTRACT.end_heading_rad:
            found.add(which, ViolationKind.REINTEGRATED_END, t, turn, CONTRACT.end_heading_rad, "rad")
