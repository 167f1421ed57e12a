"""Single-track car with tyres that saturate: forces, and the equations of motion at the centre of gravity.

Sources: Rajamani, Vehicle Dynamics and Control, 2nd ed. 2012, sections 2.3 and 13.5 (single track, Fiala's tyre); slip while a longitudinal
force is carried: Hindiyeh and Gerdes, J. Dyn. Sys. Meas. Control 136(4) 2014 (the lateral force keeps what the friction circle leaves).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, DrivenAxle

NO_SLIP_BELOW_MPS, SLIPS_ABOVE_MPS = 1.0, 3.0
_STILL_STEERS = 0.95  # of its friction is what anti-lock brakes take of an axle; assumed: it leaves 0.31 for steering
_LOCKED = 1.0 - 1e-9  # of an axle's friction: asked for so much, it locks without anti-lock brakes
_SLOWEST_MPS = 0.1  # below, slip angles are taken at this speed


def slip_share(speed_mps: float) -> float:
    """How much of a car slips where slip angles lose their meaning: 0 up to NO_SLIP_BELOW_MPS, 1 from SLIPS_ABOVE_MPS on, smooth between
    (a blend with the no-slip bicycle: Kabzan et al., AMZ Driverless, J. Field Robotics 37(7) 2020, section 5.3)."""
    q = min(max((speed_mps - NO_SLIP_BELOW_MPS) / (SLIPS_ABOVE_MPS - NO_SLIP_BELOW_MPS), 0.0), 1.0)
    return q * q * (3.0 - 2.0 * q)


def zero_sideslip_point_m(chassis: Chassis, speed_mps: float) -> float:
    """`Chassis.zero_sideslip_point_m` of a car that slips by `slip_share`: 0 at low speed."""
    return slip_share(speed_mps) * chassis.zero_sideslip_point_m(speed_mps)


class AxleForces(NamedTuple):
    """Forces of one axle [N] along and across its wheels, and the load that presses it on the road."""

    along: float
    across: float
    load: float


def fiala(slip_rad: float, stiffness: float, limit: float) -> float:
    """Lateral force [N] for a slip angle (positive: force to the left): slope `stiffness` at zero, `limit` once the whole contact
    slides (Fiala 1954, with one coefficient of friction)."""
    z = math.tan(min(max(slip_rad, -1.5), 1.5))
    if limit <= 0.0:
        return 0.0
    q = min(stiffness * abs(z) / (3.0 * limit), 1.0)  # 1: the whole contact slides
    return math.copysign(limit * min(q * (3.0 - 3.0 * q + q * q), 1.0), z)


def fiala_slip(force: float, stiffness: float, limit: float, share: float = 0.99) -> float:
    """Slip angle [rad] at which an axle gives `force` [N]: `fiala`, solved for its slip. Who asks for more than `share` of the limit gets
    the slip of that share: beyond, there is hardly more to be had."""
    part = min(abs(force) / limit, share) if limit > 0.0 else share
    return math.copysign(math.atan(3.0 * limit / stiffness * (1.0 - math.cbrt(1.0 - part))), force)


def axle_loads(chassis: Chassis, acceleration: float) -> tuple[float, float]:
    """Loads of front and rear axle [N] at a steady longitudinal acceleration; no axle pulls on the road."""
    c = chassis
    total, shift = c.mass_kg * GRAVITY_MPS2, c.mass_kg * acceleration * c.cog_height_m / c.wheelbase_m
    front = min(max(total * c.cog_to_rear_axle_m / c.wheelbase_m - shift, 0.0), total)
    return front, total - front


def axle_pulls(chassis: Chassis, acceleration: float, loads: tuple[float, float]) -> tuple[float, float]:
    """Longitudinal forces [N] asked of front and rear axle: brakes share by load or by the file, the engine's goes to the driven axle."""
    if acceleration < 0.0 and chassis.brake_share_front is not None:
        pull = chassis.mass_kg * acceleration
        return chassis.brake_share_front * pull, (1.0 - chassis.brake_share_front) * pull
    if acceleration <= 0.0 or chassis.driven_axle is DrivenAxle.BOTH:
        return acceleration / GRAVITY_MPS2 * loads[0], acceleration / GRAVITY_MPS2 * loads[1]
    pull = chassis.mass_kg * acceleration
    return (pull, 0.0) if chassis.driven_axle is DrivenAxle.FRONT else (0.0, pull)


def axle_forces(
    vx: float, vy: float, yaw_rate: float, acceleration: float, steering: float, chassis: Chassis, friction: float
) -> tuple[AxleForces, AxleForces]:
    """Front and rear: the wanted acceleration is shared by `axle_pulls`, and the rest of each circle is for turning.

    Anti-lock brakes of a fixed split leave an axle something to steer with, and the other one takes what it cannot. Without them an axle
    that is asked for all of its friction locks: it slides, and its force points against where it goes.
    """
    c = chassis
    v = max(vx, _SLOWEST_MPS)
    slip = (
        steering - math.atan2(vy + c.cog_to_front_axle_m * yaw_rate, v),
        -math.atan2(vy - c.cog_to_rear_axle_m * yaw_rate, v),
    )
    stiffness = (c.cornering_stiffness_front_nprad, c.cornering_stiffness_rear_nprad)
    forces, loads = [], axle_loads(c, acceleration)
    pulls, limits = axle_pulls(c, acceleration, loads), (friction * loads[0], friction * loads[1])
    if acceleration < 0.0 and c.anti_lock and c.brake_share_front is not None:
        pulls = _anti_lock(pulls, limits)
    for load, pull, most, angle, stiff in zip(loads, pulls, limits, slip, stiffness, strict=True):
        if not c.anti_lock and pull < 0.0 and -pull >= _LOCKED * most:
            forces.append(AxleForces(-most * math.cos(angle), most * math.sin(angle), load))
            continue
        along = min(max(pull, -most), most)
        forces.append(AxleForces(along, fiala(angle, stiff, math.sqrt(max(most**2 - along**2, 0.0))), load))
    return forces[0], forces[1]


def _anti_lock(pulls: tuple[float, float], limits: tuple[float, float]) -> tuple[float, float]:
    """Braking forces of two axles that keep something for steering: each takes what is beyond the other's share."""
    (front, rear), (most_front, most_rear) = pulls, (_STILL_STEERS * limits[0], _STILL_STEERS * limits[1])
    beyond = min(front + most_front, 0.0), min(rear + most_rear, 0.0)
    return max(front + beyond[1], -most_front), max(rear + beyond[0], -most_rear)


def body_accelerations(front: AxleForces, rear: AxleForces, steering: float, chassis: Chassis) -> tuple[float, float, float]:
    """(forward, to the left [m/s^2], yaw [rad/s^2]) of the centre of gravity, from the forces."""
    c, cos, sin = chassis, math.cos(steering), math.sin(steering)
    aside = front.across * cos + front.along * sin
    return (
        (front.along * cos - front.across * sin + rear.along) / c.mass_kg,
        (aside + rear.across) / c.mass_kg,
        (c.cog_to_front_axle_m * aside - c.cog_to_rear_axle_m * rear.across) / c.yaw_inertia_kgm2,
    )
