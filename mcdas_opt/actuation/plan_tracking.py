"""A plan, tracked: a steering law turns the wheels, a regulator minds the speed.

A steering law says which angle the wheels should have. Here they are turned there, within the limits of the vehicle and of its front tyres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.actuation.lateral_lqr import GRIP_SHARE, SPEEDS_MPS, LqrTracking, grip_left, sample, within_limits
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.single_track import axle_loads, fiala_slip, slip_share

_YAW_ENDS = 1.5  # times the yaw rate that the road can keep: faster yawing is steered against


@dataclass(frozen=True, slots=True, kw_only=True)
class PathError:
    """Of a car against its plan at a time: left of it, and turned to the left of it, positive."""

    lateral_m: float  # of the body centre
    lateral_speed_mps: float
    heading_rad: float  # of the body, against the one it has where the plan's curvature is driven steadily
    yaw_rate_radps: float
    speed_mps: float
    feed_forward_rad: (
        float  # the wheels that drive the plan's curvature steadily, by what the law looks ahead: L kappa, and what tyres slip
    )


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
    of what the road allows beside the acceleration; the slip that goes with the plan's curvature is taken up to there.
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
        lead_s = self.law.lead_s if isinstance(state, SlidingState) else 0.0  # a car without slip turns with its wheels
        ahead_rad = float(np.interp(since_s + lead_s, trajectory.t_s, trajectory.steering_rad))
        wanted = self._held(self.law.wheels_rad(self._error(at, ahead_rad, state)), state)
        return within_limits(jerk, wanted, state, car, h)

    def _error(self, at: HostState, ahead_rad: float, state: HostState) -> PathError:
        car, c, speed = self.vehicle, Chassis.of(self.vehicle), max(state.speed_mps, SPEEDS_MPS[0])
        aside, yaw_rate = state.turning(car.wheelbase_m)
        along, across = state.s_m - at.s_m, state.d_m - at.d_m
        curvature = math.tan(at.steering_rad) / car.wheelbase_m
        behind = c.zero_sideslip_point_m(state.speed_mps) if self.turned else 0.0
        lateral = speed**2 * curvature
        planned = c.rear_slip_gradient * lateral * slip_share(speed) if self.turned else 0.0  # in the plan's heading already
        off = state.heading_rad - at.heading_rad
        moves = state.speed_mps * math.sin(off) + aside + car.centre_m * yaw_rate
        front, rear = self._slips(speed**2 * math.tan(ahead_rad) / car.wheelbase_m, state)
        return PathError(
            lateral_m=across * math.cos(at.heading_rad) - along * math.sin(at.heading_rad),
            lateral_speed_mps=moves - (car.centre_m - behind) * state.speed_mps * curvature,
            heading_rad=off - (self._slips(lateral, state)[1] - planned),
            yaw_rate_radps=yaw_rate - state.speed_mps * curvature,
            speed_mps=speed,
            feed_forward_rad=ahead_rad + front - rear,
        )

    def _slips(self, lateral_mps2: float, state: HostState) -> tuple[float, float]:
        """Slip [rad] of front and rear tyres that goes with a steady lateral acceleration, by their own curve (`fiala_slip`)."""
        c = Chassis.of(self.vehicle)
        left, loads = grip_left(self.grip, state), axle_loads(c, state.acceleration_mps2)
        force, share = c.mass_kg * lateral_mps2 / c.wheelbase_m, slip_share(state.speed_mps) if isinstance(state, SlidingState) else 0.0
        return (
            share * fiala_slip(force * c.cog_to_rear_axle_m, c.cornering_stiffness_front_nprad, left * loads[0], share=GRIP_SHARE),
            share * fiala_slip(force * c.cog_to_front_axle_m, c.cornering_stiffness_rear_nprad, left * loads[1], share=GRIP_SHARE),
        )

    def _held(self, wheels_rad: float, state: HostState) -> float:
        """The wheels, turned no further than the front tyres can use, and less where that would yaw the car faster still than the road can
        keep it turning: not at all at half as fast again, against it beyond (the limit of Rajamani 2012, section 8.2)."""
        share = slip_share(state.speed_mps)
        if self.grip is None or share == 0.0:
            return wheels_rad
        c = Chassis.of(self.vehicle)
        aside, yaw_rate = state.turning(c.wheelbase_m)
        speed, grip = max(state.speed_mps, SPEEDS_MPS[0]), grip_left(self.grip, state)
        course = math.atan2(aside + c.wheelbase_m * yaw_rate, speed)
        limit = grip * axle_loads(c, state.acceleration_mps2)[0]
        most = fiala_slip(limit, c.cornering_stiffness_front_nprad, limit, share=GRIP_SHARE)
        turning = yaw_rate * speed / (grip * GRAVITY_MPS2)  # beyond 1 in size no road keeps it
        left, right = (min(max((_YAW_ENDS - way) / (_YAW_ENDS - 1.0), -1.0), 1.0) * most for way in (turning, -turning))
        return share * min(max(wheels_rad, course - right), course + left) + (1.0 - share) * wheels_rad
