"""Following a parking trajectory forward and in reverse: feedforward ahead of lag and dead time, linear-quadratic feedback.

Across: offset, heading and curvature errors relative to the path; the corrections that wait in the dead time are states as well. The gain
is scheduled on the signed speed. Along: distance and speed. Linearised in curvature, so that one design holds at every steering angle (de
Luca, Oriolo and Samson, Feedback control of a nonholonomic car-like robot, 1998, section 3; the regulator as in Franklin, Powell and
Workman, Digital Control of Dynamic Systems, 3rd ed. 1998, ch. 9).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.parking import ParkingTrajectory
from mcdas_opt.domain.rules import Array, non_negative, positive, require
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.angles import wrapped

_GRID_MPS = (0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 2.5)
_MOVING_MPS = 1e-3
STEP_S = 0.02  # between commands
# Deviations that weigh the same: errors on one side, corrections on the other.
_ACROSS_M, _HEADING_RAD, _CURVATURE_PER_M = 0.03, 0.01, 0.06
_ALONG_M, _SPEED_MPS, _ACCELERATION_MPS2 = 0.03, 0.1, 0.4


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingActuators:
    """Steering angle and acceleration follow their commands by a first-order lag after a common dead time. The figures are assumed."""

    steering_lag_s: float = 0.1
    drive_lag_s: float = 0.1
    delay_s: float = 0.1

    def __post_init__(self) -> None:
        require(self, positive, "steering_lag_s", "drive_lag_s")
        non_negative("delay_s", self.delay_s, "s")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingGains:
    """Of the corrections that wait in the dead time there are `waiting`, oldest first.

    `across` (m, 3 + waiting), at the signed `speed_mps` (m,), is on offset, heading, curvature and those. `along` (3 + waiting) is on
    distance, speed, acceleration and those. `slowest_pole` is the largest modulus of all designs.
    """

    waiting: int
    speed_mps: Array
    across: Array
    along: Array
    slowest_pole: float


class Aim(NamedTuple):
    """The reference at one time."""

    pose: Array
    speed: float
    acceleration: float
    steering: float
    steering_rate: float
    gear: float  # +1 or -1; at rest that of the motion to come


class TrackingError(NamedTuple):
    """Of the car relative to the path: to the left, turned left, ahead in the car's own x direction, faster."""

    across_m: float
    heading_rad: float
    along_m: float
    speed_mps: float


@lru_cache(maxsize=16)
def design_parking_tracker(actuators: ParkingActuators) -> TrackingGains:
    """The regulators for both ways of driving, designed once for the same actuators.

    Raises `ParameterError` when the dead time is no whole number of steps.
    """
    waiting = round(actuators.delay_s / STEP_S)
    if abs(waiting * STEP_S - actuators.delay_s) > 1e-9:
        raise ParameterError("delay_s", actuators.delay_s, f"must be a whole number of steps of {STEP_S:g} s", "s")
    speeds = np.array([*(-v for v in reversed(_GRID_MPS)), *_GRID_MPS])
    errors = (_ACROSS_M**-2, _HEADING_RAD**-2)
    designs = [_regulator(v, v, actuators.steering_lag_s, waiting, errors, _CURVATURE_PER_M**-2) for v in speeds]
    errors = (_ALONG_M**-2, _SPEED_MPS**-2)
    along, pole = _regulator(1.0, 1.0, actuators.drive_lag_s, waiting, errors, _ACCELERATION_MPS2**-2)
    across = np.array([gain for gain, _ in designs])
    for table in (speeds, across, along):
        table.setflags(write=False)
    return TrackingGains(waiting=waiting, speed_mps=speeds, across=across, along=along, slowest_pole=max(pole, *(p for _, p in designs)))


def _regulator(first: float, second: float, lag_s: float, waiting: int, errors: tuple[float, float], effort: float) -> tuple[Array, float]:
    """Gain and slowest pole for x1' = first x2, x2' = second x3, x3' = (u - x3) / lag, u delayed by `waiting` samples."""
    import control

    chain = control.ss([[0.0, first, 0.0], [0.0, 0.0, second], [0.0, 0.0, -1.0 / lag_s]], [[0.0], [0.0], [1.0 / lag_s]], np.eye(3), 0)
    sampled = control.sample_system(chain, STEP_S, method="zoh")
    n = 3 + waiting
    a, b = np.zeros((n, n)), np.zeros((n, 1))
    a[:3, :3] = sampled.A
    if waiting:
        a[:3, 3] = sampled.B[:, 0]
        a[range(3, n - 1), range(4, n)] = 1.0
        b[-1, 0] = 1.0
    else:
        b[:3] = sampled.B
    weights = np.diag([*errors, *[1e-6 * effort] * (n - 2)])
    gain, _, poles = control.dlqr(a, b, weights, np.array([[effort]]))
    return np.asarray(gain, dtype=np.float64)[0], float(np.abs(poles).max())


class ParkingTracker:
    """Commands (acceleration, steering angle) once every `STEP_S`; remembers the corrections that wait in the dead time.

    `acceleration_mps2` bounds what is commanded in both directions and may be changed between commands.
    """

    def __init__(self, gains: TrackingGains, actuators: ParkingActuators, vehicle: Vehicle, acceleration_mps2: float) -> None:
        self._gains, self._actuators, self._vehicle = gains, actuators, vehicle
        self.acceleration_mps2 = acceleration_mps2
        self._bends = deque([0.0] * gains.waiting)
        self._pushes = deque([0.0] * gains.waiting)
        self._pushed = 0.0  # acceleration by corrections, from the model
        self._decay = math.exp(-STEP_S / actuators.drive_lag_s)

    def aim_at(self, trajectory: ParkingTrajectory) -> None:
        """Follow this one from now on; corrections that wait in the dead time stay."""
        self._path = trajectory
        moving = np.where(np.abs(trajectory.speed_mps) > _MOVING_MPS, np.sign(trajectory.speed_mps), 0.0)
        gear = 1.0
        for value in moving:
            gear = float(value) or gear
        gears = np.empty(len(trajectory))
        for k in range(len(trajectory) - 1, -1, -1):
            gear = float(moving[k]) or gear
            gears[k] = gear
        self._gears = gears

    def aim(self, since_s: float) -> Aim:
        """The reference `since_s` after the trajectory's first sample; waiting there before it, at rest beyond its end."""
        path = self._path
        t = since_s + float(path.t_s[0])
        if since_s < 0.0:
            return Aim(path.poses[0], float(path.speed_mps[0]), 0.0, float(path.steering_rad[0]), 0.0, float(self._gears[0]))
        if t >= path.t_s[-1]:
            return Aim(path.poses[-1], 0.0, 0.0, float(path.steering_rad[-1]), 0.0, float(self._gears[-1]))
        k = int(np.searchsorted(path.t_s, t, side="right")) - 1
        span = float(path.t_s[k + 1] - path.t_s[k])
        w = (t - float(path.t_s[k])) / span
        a, rate = float(path.acceleration_mps2[k]), float(path.steering_rate_radps[k])
        here = np.array([path.x_m[k], path.y_m[k], path.heading_rad[k]])
        there = np.array([path.x_m[k + 1], path.y_m[k + 1], path.heading_rad[k + 1]])
        speed = float(path.speed_mps[k]) + a * w * span
        gear = math.copysign(1.0, speed) if abs(speed) > _MOVING_MPS else float(self._gears[k])
        return Aim(here + w * (there - here), speed, a, float(path.steering_rad[k]) + rate * w * span, rate, gear)

    def error(self, aim: Aim, pose: Array, speed_mps: float) -> TrackingError:
        """Relative to the circle that the path is at the reference: the offset does not mistake being early for being beside."""
        dx, dy = float(pose[0] - aim.pose[0]), float(pose[1] - aim.pose[1])
        c, s = math.cos(aim.pose[2]), math.sin(aim.pose[2])
        along, across = c * dx + s * dy, c * dy - s * dx
        bend = math.tan(aim.steering) / self._vehicle.wheelbase_m
        turn = float(wrapped(float(pose[2] - aim.pose[2]) - bend * along))
        return TrackingError(across - 0.5 * bend * along**2, turn, along, speed_mps - aim.speed)

    def command(self, since_s: float, pose: Array, speed_mps: float, steering_rad: float) -> tuple[float, float]:
        """(acceleration, steering angle) for a car that is measured at `pose`, `speed_mps` and `steering_rad`."""
        lags, car = self._actuators, self._vehicle
        now = self.aim(since_s)
        off = self.error(now, pose, speed_mps)
        ahead = self.aim(since_s + lags.delay_s + 0.5 * STEP_S)
        lead = self.aim(since_s + lags.delay_s + 0.5 * STEP_S + lags.drive_lag_s)
        bent = (math.tan(steering_rad) - math.tan(now.steering)) / car.wheelbase_m
        across = self._across(now.gear * max(abs(now.speed), _GRID_MPS[0]))
        bend = -float(across @ np.array([off.across_m, off.heading_rad, bent, *self._bends]))
        push = -float(self._gains.along @ np.array([off.along_m, off.speed_mps, self._pushed, *self._pushes]))
        plain = ahead.steering + lags.steering_lag_s * ahead.steering_rate
        plain = min(max(plain, -car.steering_max_rad), car.steering_max_rad)
        steering = math.atan(math.tan(plain) + car.wheelbase_m * bend)
        steering = min(max(steering, -car.steering_max_rad), car.steering_max_rad)
        acceleration = min(max(lead.acceleration + push, -self.acceleration_mps2), self.acceleration_mps2)
        self._bends.append((math.tan(steering) - math.tan(plain)) / car.wheelbase_m)
        self._pushes.append(acceleration - lead.acceleration)
        self._bends.popleft()
        arriving = self._pushes.popleft()
        self._pushed = arriving + (self._pushed - arriving) * self._decay
        return acceleration, steering

    def _across(self, speed: float) -> Array:
        grid, table = self._gains.speed_mps, self._gains.across
        k = min(max(int(np.searchsorted(grid, speed)) - 1, 0), len(grid) - 2)
        w = min(max((speed - float(grid[k])) / float(grid[k + 1] - grid[k]), 0.0), 1.0)
        return np.asarray(table[k] + w * (table[k + 1] - table[k]))
