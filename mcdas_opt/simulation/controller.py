"""What stands between plan and plant: a controller."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from mcdas_opt.actuation.error_lqr import ErrorLqr
from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.actuation.lateral_lqr import LqrTracking
from mcdas_opt.actuation.plan_tracking import PlanTracking
from mcdas_opt.actuation.stanley import Stanley
from mcdas_opt.actuation.tracking_mpc import TrackingMpc
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError, nearest

STEERING_RATE_SHARE = 0.3  # planned with at speed; chosen on sandwiches that were left at the side without it
FRICTION_SHARE = 0.965  # planned with, of the 97 % that a kinematic vehicle is planned with
EDGE_RESERVE_M = 0.2  # beside the road's edges: the least that is left of it in the hard scenes of seed 9 is 0.16


class Controller(Protocol):
    """Turns a plan into inputs, every step of the plant."""

    def command(self, trajectory: Trajectory, since_s: float, state: HostState) -> tuple[float, float]:
        """(jerk, steering rate) at `since_s` after the plan's time 0, for a car in `state`."""
        ...


class FeedForward:
    """Takes acceleration and steering to the plan's next sample, on a straight line in time.

    From the plan's own states these are the plan's own inputs. Where the car is elsewhere (an actuator saturated, or a plan that
    jumps) the acceleration and the steering angle catch up; position and speed are left to the next plan. Beyond the plan's end
    nothing changes any more.
    """

    def command(self, trajectory: Trajectory, since_s: float, state: HostState) -> tuple[float, float]:
        after = int(np.searchsorted(trajectory.t_s, since_s + 1e-9, side="right"))
        if after >= len(trajectory):
            return 0.0, 0.0
        left = float(trajectory.t_s[after]) - since_s
        jerk = (float(trajectory.acceleration_mps2[after]) - state.acceleration_mps2) / left
        return jerk, (float(trajectory.steering_rad[after]) - state.steering_rad) / left


# of the vehicle, whether plans are `turned` (`make_controller`), and the grip that is found
CONTROLLERS: dict[str, Callable[[Vehicle, bool, GripMonitor | None], Controller]] = {
    "feed-forward": lambda car, turned, grip: FeedForward(),
    "lqr-inverse-tyre": lambda car, turned, grip: LqrTracking.design(car, turned=turned, grip=grip),
    "stanley": lambda car, turned, grip: PlanTracking(law=Stanley(vehicle=car), vehicle=car, turned=turned, grip=grip),
    "lqr-errors": lambda car, turned, grip: PlanTracking(law=ErrorLqr.design(car), vehicle=car, turned=turned, grip=grip),
    "mpc-single-track": lambda car, turned, grip: TrackingMpc(vehicle=car, turned=turned, grip=grip),
}
WITHOUT_SLIP, WITH_SLIP = "feed-forward", "stanley"  # the defaults


def make_controller(name: str, vehicle: Vehicle, *, turned: bool = False, grip: GripMonitor | None = None) -> Controller:
    """The controller of that name. `turned`: whether plans are made about the zero-sideslip point of a dynamic vehicle (`LqrTracking`).
    Raises `ParameterError` that names the nearest known one."""
    if name not in CONTROLLERS:
        raise ParameterError("controller", name, f"is not a known controller; {nearest(name, CONTROLLERS)}")
    return CONTROLLERS[name](vehicle, turned, grip)


def default_controller(vehicle: Vehicle, *, slips: bool, turned: bool = False, grip: GripMonitor | None = None) -> Controller:
    """Feed-forward alone suffices for a kinematic vehicle, which plans are made with. A dynamic one, that `slips`, is tracked with
    feedback."""
    return make_controller(WITH_SLIP if slips else WITHOUT_SLIP, vehicle, turned=turned, grip=grip)


def planned_for(settings: Settings, *, slips: bool) -> Settings:
    """The settings to plan with; those of a dynamic vehicle, that `slips`, leave something to the feedback.

    A dynamic vehicle turns later than its wheels: a plan that steers back at the last moment at the full rate leaves the road. Tyres at
    their limit slip without giving more: a plan that takes all the grip leaves none against spinning. So plans get at most
    STEERING_RATE_SHARE (at low speed more: `Settings.lateral_jerk_mps3`) and FRICTION_SHARE. They also keep EDGE_RESERVE_M to the road's
    edges, where there is so much room: a vehicle that leaves its plan at the very edge cannot come back to it.
    """
    if not slips:
        return settings
    return replace(
        settings,
        steering_rate_share=min(settings.steering_rate_share, STEERING_RATE_SHARE),
        friction_share=min(settings.friction_share, FRICTION_SHARE),
        edge_reserve_m=max(settings.edge_reserve_m, EDGE_RESERVE_M),
    )
