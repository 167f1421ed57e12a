"""A plan, tracked: a steering law turns the wheels, a regulator minds the speed.

A steering law says which angle the wheels should have. Here they are turned there, within the limits of the vehicle and of its front tyres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.actuation.lateral_lqr import GRIP_SHARE, SPEEDS_MPS, LqrTracking, sample
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.single_track import axle_loads, fiala_slip, slip_share

_STEERING_LAG_S = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class PathError:
    """Of a car against its plan at a time: left of it, and turned to the left of it, positive."""

    lateral_m: float  # of the body centre
    lateral_speed_mps: float
    heading_rad: float  # of the body, against the one it has where the plan's curvature is driven steadily
    yaw_rate_radps: float
    speed_mps: float
    steering_rad: float  # the plan's, of a no-slip bicycle
    curvature_pm: float  # the plan's, by what the law looks ahead


class SteeringLaw(Protocol):
    """Front wheels by feedback on a path."""

    @property
    def lead_s(self) -> float:
        """How far ahead on the plan its curvature is taken."""
        ...

    def wheels_rad(self, error: PathError) -> float:
        """The angle of the front wheels."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanTracking:
    """Implements `Controller` by a steering law. Speed by the regulator of `LqrTracking`; beyond the plan's end its inputs are 0.

    Saturation: the front wheels are turned against the way that their axle moves by no more than the slip at which it gives GRIP_SHARE
    of what the road allows beside the acceleration, and curvature feed-forward asks for no more lateral acceleration than that.
    """

    law: SteeringLaw
    vehicle: Vehicle
    step_s: float = 0.01
    turned: bool = False
    grip: GripMonitor | None = None

    def command(self, trajectory: Trajectory, since_s: float, state: HostState) -> tuple[float, float]:
        if since_s >= trajectory.t_s[-1] - 1e-9:
            return 0.0, 0.0
        car, h = self.vehicle, self.step_s
        at, soon = sample(trajectory, since_s, h)
        jerk = LqrTracking.design(car, h).jerk(at, soon, state)
        ahead_rad = float(np.interp(since_s + self.law.lead_s, trajectory.t_s, trajectory.steering_rad))
        wanted = self._held(self.law.wheels_rad(self._error(at, ahead_rad, state)), state)
        rate = (wanted - state.steering_rad) / _STEERING_LAG_S
        most = min(car.steering_rate_max_radps, max((car.steering_max_rad - state.steering_rad) / h, 0.0))
        least = -min(car.steering_rate_max_radps, max((car.steering_max_rad + state.steering_rad) / h, 0.0))
        return min(max(jerk, car.jerk_min_mps3), car.jerk_max_mps3), min(max(rate, least), most)

    def _error(self, at: HostState, ahead_rad: float, state: HostState) -> PathError:
        car, c, speed = self.vehicle, Chassis.of(self.vehicle), max(state.speed_mps, SPEEDS_MPS[0])
        aside, yaw_rate = state.turning(car.wheelbase_m)
        along, across = state.s_m - at.s_m, state.d_m - at.d_m
        curvature = math.tan(at.steering_rad) / car.wheelbase_m
        behind = c.zero_sideslip_point_m(state.speed_mps) if self.turned else 0.0
        slip = 0.0 if self.turned else c.rear_slip_gradient * speed**2 * curvature * slip_share(speed)
        off = state.heading_rad - at.heading_rad
        moves = state.speed_mps * math.sin(off) + aside + car.centre_m * yaw_rate
        return PathError(
            lateral_m=across * math.cos(at.heading_rad) - along * math.sin(at.heading_rad),
            lateral_speed_mps=moves - (car.centre_m - behind) * state.speed_mps * curvature,
            heading_rad=off - slip,
            yaw_rate_radps=yaw_rate - state.speed_mps * curvature,
            speed_mps=speed,
            steering_rad=at.steering_rad,
            curvature_pm=self._within_grip(math.tan(ahead_rad) / car.wheelbase_m, speed),
        )

    def _within_grip(self, curvature_pm: float, speed: float) -> float:
        if self.grip is None:
            return curvature_pm
        most = GRIP_SHARE * self.grip.friction * GRAVITY_MPS2 / speed**2
        return min(max(curvature_pm, -most), most)

    def _held(self, wheels_rad: float, state: HostState) -> float:
        """The wheels, turned no further than the front tyres can use."""
        share = slip_share(state.speed_mps)
        if self.grip is None or share == 0.0:
            return wheels_rad
        c = Chassis.of(self.vehicle)
        aside, yaw_rate = state.turning(c.wheelbase_m)
        course = math.atan2(aside + c.wheelbase_m * yaw_rate, max(state.speed_mps, SPEEDS_MPS[0]))
        left = math.sqrt(max(self.grip.friction**2 - (state.acceleration_mps2 / GRAVITY_MPS2) ** 2, 1e-6))
        limit = left * axle_loads(c, state.acceleration_mps2)[0]
        most = fiala_slip(limit, c.cornering_stiffness_front_nprad, limit, share=GRIP_SHARE)
        return share * min(max(wheels_rad, course - most), course + most) + (1.0 - share) * wheels_rad


def understeer_rad(chassis: Chassis, error: PathError) -> float:
    """Steering for the plan's curvature: that of a no-slip bicycle, and the understeer that goes with it (Rajamani 2012, eq 3.3)."""
    lateral = slip_share(error.speed_mps) * error.speed_mps**2 * error.curvature_pm
    return math.atan(chassis.wheelbase_m * error.curvature_pm) + chassis.understeer_gradient * lateral


def gains_at(speed: float, table: Array) -> Array:
    """Gains scheduled over SPEEDS_MPS, (len(SPEEDS_MPS), n) -> (n,); held beyond the grid."""
    return np.array([np.interp(speed, SPEEDS_MPS, column) for column in table.T])
