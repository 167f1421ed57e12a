"""The stop that is always possible: on along the present path until the brake takes effect, then to rest on the same path."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.dynamics.rollout import roll_out

STEP_S = 0.025
_REST_MPS = 1e-9


def braking(
    case: ParkingCase, path: ParkingTrajectory, since_s: float, reaction_s: float, pose: Array, speed_mps: float, steering_rad: float
) -> ParkingTrajectory:
    """To rest from the car's own state, `since_s` after the path's first sample.

    The path's speed and steering are kept for `reaction_s`. Then the car brakes as hard as the case allows, with the steering that the path
    has at each place. Steering starts at the car's own angle and goes to the path's at the vehicle's rate. Times start at 0. A reversal
    ahead ends the braking: behind it the path is another.
    """
    car, limits = case.vehicle, case.limits
    zero = float(path.t_s[0]) + since_s
    count = max(int(np.ceil(reaction_s / STEP_S - 1e-9)), 0)
    times: Array = zero + STEP_S * np.arange(count + 1, dtype=np.float64)
    planned = _speed_at(path, times)
    speed = np.clip(planned + (speed_mps - planned[0]), -limits.reverse_mps, limits.forward_mps)
    speed[0] = min(max(speed_mps, -limits.reverse_mps), limits.forward_mps)
    speed = _within_rate(speed, limits.acceleration_mps2 * STEP_S)
    wanted = np.interp(times, path.t_s, path.steering_rad)
    left = abs(float(speed[-1]))
    drop = limits.acceleration_mps2 * STEP_S
    steps = int(np.ceil(left / drop - 1e-9))
    if steps:
        slower = np.maximum(left - drop * np.arange(1, steps + 1), 0.0)
        distance = np.cumsum(0.5 * STEP_S * (slower + np.concatenate([[left], slower[:-1]])))
        wanted = np.concatenate([wanted, _steering_ahead(path, float(times[-1]), distance)])
        speed = np.concatenate([speed, np.sign(speed[-1]) * slower])
    speed[np.abs(speed) < _REST_MPS] = 0.0
    if len(speed) == 1:
        speed, wanted = np.append(speed, 0.0), np.append(wanted, wanted[-1])
    wanted[0] = steering_rad
    top = car.steering_max_rad
    steering = np.clip(_within_rate(wanted, car.steering_rate_max_radps * STEP_S), -top, top)
    t: Array = STEP_S * np.arange(len(speed), dtype=np.float64)
    _, poses, at = roll_out(np.asarray(pose, dtype=np.float64), t, speed, steering, car.wheelbase_m, 0.005)
    return ParkingTrajectory.from_controls(t, poses[at], speed, steering)


def _speed_at(path: ParkingTrajectory, times: Array) -> Array:
    found: Array = np.interp(times, path.t_s, path.speed_mps, right=0.0)
    return found


def _within_rate(values: Array, most: float) -> Array:
    """The values, followed from the first one by at most `most` a sample."""
    followed = np.array(values)
    for k in range(1, len(followed)):
        followed[k] = followed[k - 1] + min(max(float(values[k]) - followed[k - 1], -most), most)
    return followed


def _steering_ahead(path: ParkingTrajectory, at_s: float, distance: Array) -> Array:
    """The path's steering at these distances beyond the place where it is at time `at_s`, within the present gear."""
    k = int(np.searchsorted(path.t_s, at_s, side="right"))
    t = np.concatenate([[at_s], path.t_s[k:]])
    v, delta = _speed_at(path, t), np.interp(t, path.t_s, path.steering_rad)
    ends = np.flatnonzero(v * np.sign(v[0] or 1.0) <= _REST_MPS)
    end = int(ends[0]) + 1 if ends.size else len(t)
    end = max(end, 1)
    driven = np.concatenate([[0.0], np.cumsum(0.5 * np.abs(v[1:end] + v[: end - 1]) * np.diff(t[:end]))])
    return np.asarray(np.interp(distance, driven, delta[:end]))
