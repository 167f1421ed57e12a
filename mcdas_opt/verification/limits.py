"""What the vehicle and its tyres can do."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.verdict import Violation
from mcdas_opt.dynamics.bicycle import lateral_acceleration
from mcdas_opt.verification.finding import above, below
from mcdas_opt.verification.motion import Motion
from mcdas_opt.verification.tolerances import Tolerances


def actuators(trajectory: Trajectory, motion: Motion, vehicle: Vehicle, tolerances: Tolerances) -> list[Violation]:
    """Speed, acceleration and steering at the samples and between them; jerk and steering rate as they are held."""
    more = 1.0 + tolerances.limit
    t, speed, acceleration = motion.t_s, motion.speed_mps, motion.acceleration_mps2
    jerk, steps = trajectory.jerk_mps3, trajectory.t_s
    top, steer, rate = vehicle.speed_max_mps, vehicle.steering_max_rad, vehicle.steering_rate_max_radps
    return [
        *(below("speed", t, speed, 0.0, -tolerances.reverse_mps, "m/s") or above("speed", t, speed, top, top * more, "m/s")),
        *_between("acceleration", t, acceleration, vehicle.acceleration_min_mps2, vehicle.acceleration_max_mps2, more, "m/s^2"),
        *_between("jerk", steps, jerk, vehicle.jerk_min_mps3, vehicle.jerk_max_mps3, more, "m/s^3"),
        *_between("steering angle", t, motion.steering_rad, -steer, steer, more, "rad"),
        *_between("steering rate", steps, trajectory.steering_rate_radps, -rate, rate, more, "rad/s"),
    ]


def friction(motion: Motion, vehicle: Vehicle, road: Road, tolerances: Tolerances) -> list[Violation]:
    """a_long^2 + (v^2 kappa)^2 <= (mu g)^2, at the rear axle, at every fine step."""
    across = lateral_acceleration(motion.speed_mps, motion.steering_rad, vehicle.wheelbase_m, np)
    total = np.hypot(motion.acceleration_mps2, across)
    grip = road.friction * GRAVITY_MPS2
    return above("friction circle", motion.t_s, total, grip, grip * (1.0 + tolerances.friction), "m/s^2")


def _between(name: str, t: np.ndarray, value: np.ndarray, low: float, high: float, more: float, unit: str) -> list[Violation]:
    """One violation, of the side that is exceeded by the larger share."""
    under = below(name, t, value, low, low * more, unit)
    over = above(name, t, value, high, high * more, unit)
    return sorted(under + over, key=lambda v: v.value / v.limit)[-1:]
