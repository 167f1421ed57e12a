"""The fixed tracking law that drives a closed-form path with the bicycle, inside the car's limits.

Lateral: curvature of the path plus critically damped feedback of the body centre's offset and heading (linear in the errors at a given
speed), so that in the road's bends the middle of what the body sweeps is on the path; longitudinal: a jerk-limited approach to a target
speed. Steering gives way to the lateral bound, acceleration to the circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.axle_limits import driving_mps2
from mcdas_opt.dynamics.bicycle import swept_inset_m2
from mcdas_opt.dynamics.stopping import held_step

BANDWIDTH_RADPS = 2.5  # of the lateral feedback
PREVIEW_S = 0.1
LIMIT_SHARE, FRICTION_SHARE = 0.98, 0.96  # of the limits that are used
STEP_S = 0.05


class Path(Protocol):
    """d(s) [m] with its first two derivatives."""

    def d(self, s: Any) -> Any: ...
    def slope(self, s: Any) -> Any: ...
    def curvature(self, s: Any) -> Any: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedLaw:
    """Go to `speed_mps` with at most `acceleration_mps2` either way, from `start_s` on; before that hold the acceleration at zero."""

    speed_mps: float
    acceleration_mps2: float
    start_s: float = 0.0


class AccelerationLaw(Protocol):
    """A law that asks for an acceleration [m/s^2], by the time since the drive began, the place of the body centre and the speed."""

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float: ...


def follow(
    start: HostState,
    path: Path,
    law: SpeedLaw | AccelerationLaw,
    *,
    vehicle: Vehicle,
    road: Road,
    duration_s: float,
    lateral_acceleration_mps2: float,
) -> Trajectory:
    """The trajectory of the bicycle from the measured state along `path`, every `STEP_S`, inputs constant in between."""
    h = STEP_S
    steps = max(2, round(duration_s / h))
    x = [float(value) for value in start.to_vector()]
    states, inputs = [x], []
    grip, driving = FRICTION_SHARE * road.friction * GRAVITY_MPS2, driving_mps2(vehicle, road.friction)
    knots = [(float(s), float(k)) for s, k in road.curvature]

    def curvature(s: float) -> float:
        return 0.0 if road.is_straight else _interpolate(knots, s)

    for k in range(steps):
        rate = _steering_rate(x, path, curvature(x[0]), vehicle, min(lateral_acceleration_mps2, grip))
        jerk = _jerk(x, _wanted(x, law, k * h, vehicle), vehicle, grip, driving)
        x = held_step(x, (jerk, rate), h, curvature, vehicle)
        states.append(x)
        inputs.append((jerk, rate))
    times = np.round(np.arange(steps + 1) * h, 9)
    return Trajectory.from_states(times, np.array(states), np.array(inputs))


def _interpolate(knots: list[tuple[float, float]], s: float) -> float:
    if s <= knots[0][0]:
        return knots[0][1]
    for (s0, k0), (s1, k1) in pairwise(knots):
        if s <= s1:
            return k0 + (k1 - k0) * (s - s0) / (s1 - s0)
    return knots[-1][1]


def _steering_rate(x: list[float], path: Path, kappa: float, vehicle: Vehicle, lateral: float) -> float:
    s, d, psi, v, _, delta = x
    speed = max(v, 2.0)
    ahead = s + v * PREVIEW_S
    w = BANDWIDTH_RADPS
    centre = vehicle.centre_m
    offset = d - float(path.d(s)) - swept_inset_m2(vehicle.length_m, centre) * kappa
    heading = psi - math.atan(float(path.slope(s))) + centre * kappa
    wanted = kappa * math.cos(psi) / (1.0 - d * kappa) + float(path.curvature(ahead))
    wanted -= (w / speed) ** 2 * offset + 2.0 * w / speed * heading
    most = min(lateral / max(v, 0.1) ** 2, math.tan(LIMIT_SHARE * vehicle.steering_max_rad) / vehicle.wheelbase_m)
    target = math.atan(vehicle.wheelbase_m * max(-most, min(most, wanted)))
    limit = LIMIT_SHARE * vehicle.steering_rate_max_radps
    return 0.0 if v < 0.05 else max(-limit, min(limit, (target - delta) / STEP_S))


def _wanted(x: list[float], law: SpeedLaw | AccelerationLaw, t_s: float, vehicle: Vehicle) -> float:
    """The acceleration that the law asks for, eased where it meets the law's speed, or standstill."""
    if not isinstance(law, SpeedLaw):
        asked = law.wanted_mps2(t_s, x[0], x[3])
        return max(asked, _halting(x[3], vehicle.jerk_max_mps3)) if asked < 0.0 else asked
    if t_s < law.start_s - 1e-9:
        return 0.0
    gap = law.speed_mps - x[3]
    easing = -vehicle.jerk_min_mps3 if gap > 0.0 else vehicle.jerk_max_mps3
    return math.copysign(min(law.acceleration_mps2, _eased(abs(gap), easing)), gap)


def _eased(gap_mps: float, jerk_mps3: float) -> float:
    """The acceleration from which a gap of speed can still be closed without overshoot."""
    return min(math.sqrt(1.6 * LIMIT_SHARE * jerk_mps3 * gap_mps), gap_mps / (2.0 * STEP_S))


def _halting(v: float, jerk_mps3: float) -> float:
    """The hardest braking from which the car still comes to rest without rolling back."""
    if v <= 0.0:
        return -v / (2.0 * STEP_S)
    return -min(math.sqrt(0.7 * LIMIT_SHARE * jerk_mps3 * v), v / (3.0 * STEP_S))


def _jerk(x: list[float], wanted: float, vehicle: Vehicle, grip: float, driving: float) -> float:
    v, a, delta = x[3], x[4], x[5]
    share, h = LIMIT_SHARE, STEP_S
    lateral = v**2 * math.tan(delta) / vehicle.wheelbase_m
    room = math.sqrt(max(grip**2 - lateral**2, 0.0))
    low, high = share * vehicle.acceleration_min_mps2, share * driving
    wanted = max(low, -room, min(high, room, wanted))
    return max(share * vehicle.jerk_min_mps3, min(share * vehicle.jerk_max_mps3, (wanted - a) / h))
