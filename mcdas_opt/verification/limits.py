"""What the vehicle and its tyres can do."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.dynamics.axle_limits import driving_mps2
from mcdas_opt.dynamics.bicycle import lateral_acceleration
from mcdas_opt.verification.finding import Findings
from mcdas_opt.verification.motion import Motion
from mcdas_opt.verification.record import Samples
from mcdas_opt.verification.tolerances import CONTRACT

LEAVING_S = 0.2  # a jerk of 10 m/s^3 is enough for 2 m/s^2


def actuators(samples: Samples, motion: Motion, vehicle: Vehicle, road: Road, found: Findings) -> None:
    """Speed, acceleration and steering at the samples and between them; jerk and steering rate as they are held. A start that asks more of
    the driven axle than it can hold has LEAVING_S to leave that."""
    more = 1.0 + CONTRACT.limit
    t, steps = motion.t_s, samples.t_s
    steer, rate = vehicle.steering_max_rad, vehicle.steering_rate_max_radps
    _speed(motion, vehicle.speed_max_mps, more, found)
    for kind, times, value, low, high, unit in (
        (ViolationKind.ACCELERATION, t, motion.acceleration_mps2, vehicle.acceleration_min_mps2, _driving(t, vehicle, road), "m/s^2"),
        (ViolationKind.JERK, steps, samples.jerk_mps3, vehicle.jerk_min_mps3, vehicle.jerk_max_mps3, "m/s^3"),
        (ViolationKind.STEERING_ANGLE, t, motion.steering_rad, -steer, steer, "rad"),
        (ViolationKind.STEERING_RATE, steps, samples.steering_rate_radps, -rate, rate, "rad/s"),
    ):
        _between(kind, times, value, low, high, more, unit, found)


def _driving(t: Array, vehicle: Vehicle, road: Road) -> float | Array:
    """The most that the engine accelerates at each time."""
    driving = driving_mps2(vehicle, road.friction)
    return driving if driving == vehicle.acceleration_max_mps2 else np.where(t < LEAVING_S, vehicle.acceleration_max_mps2, driving)


def friction(motion: Motion, vehicle: Vehicle, road: Road, found: Findings) -> None:
    """a_long^2 + (v^2 kappa)^2 <= (mu g)^2, at the rear axle, at every fine step."""
    across = lateral_acceleration(motion.speed_mps, motion.steering_rad, vehicle.wheelbase_m, np)
    total = np.hypot(motion.acceleration_mps2, across)
    grip = road.grip_mps2
    found.above(ViolationKind.FRICTION, motion.t_s, total, grip, grip * (1.0 + CONTRACT.friction), "m/s^2")


def _speed(motion: Motion, top: float, more: float, found: Findings) -> None:
    """Neither backwards nor beyond the top; one that does both is convicted of going backwards."""
    v, before = motion.speed_mps, [len(list_) for list_ in found.of]
    found.below(ViolationKind.SPEED, motion.t_s, v, 0.0, -CONTRACT.reverse_mps, "m/s")
    found.above(ViolationKind.SPEED, motion.t_s, v, top, top * more, "m/s")
    for list_, count in zip(found.of, before, strict=True):
        del list_[count + 1 :]


def _between(kind: ViolationKind, t: Array, value: Array, low: float, high: float | Array, more: float, unit: str, found: Findings) -> None:
    """One violation, of the side that is exceeded by the larger share."""
    if np.all(value <= high * more) and value.min() >= low * more:
        return
    share = np.maximum(value / low, value / high)
    for which in np.flatnonzero(~(share.max(axis=-1) <= more)).tolist():
        worst = int(share[which].argmax())
        measured = float(value[which, worst])
        found.add(which, kind, t[worst], measured, low if measured < 0.0 else float(np.broadcast_to(high, t.shape)[worst]), unit)
