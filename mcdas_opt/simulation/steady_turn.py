"""How a dynamic vehicle begins: with the slip that goes with its path."""

from __future__ import annotations

import math

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.single_track import slip_share
from mcdas_opt.simulation.actuators import Actuators


def in_steady_turn(state: HostState, vehicle: Vehicle, road: Road) -> SlidingState:
    """The state within the limits of vehicle and road. One without slip, given in a bend, counts as a steady turn: it gets the slip and the
    steering angle of that turn (Rajamani 2012, section 3.1), and moves as that state's no-slip bicycle does."""
    actuators, chassis = Actuators(vehicle=vehicle, friction=road.friction), Chassis.of(vehicle)
    s, d, psi, v, a, delta = (float(q) for q in state.to_vector())
    a, delta = actuators.hold(v, a, delta)
    if isinstance(state, SlidingState):
        aside, yaw_rate = state.lateral_speed_mps, state.yaw_rate_radps
    else:
        yaw_rate = v * math.tan(actuators.steering_held(v, a, delta)) / vehicle.wheelbase_m
        slip, more = (0.0, 0.0) if road.is_straight else _settled(chassis, v, float(road.curvature_at(s)))
        aside, psi, delta = -slip * v, psi + slip, actuators.hold(v, a, delta + more)[1]
    return SlidingState(
        s_m=s,
        d_m=d,
        heading_rad=psi,
        speed_mps=v,
        acceleration_mps2=a,
        steering_rad=delta,
        lateral_speed_mps=aside,
        yaw_rate_radps=yaw_rate,
    )


def _settled(chassis: Chassis, v: float, bend_pm: float) -> tuple[float, float]:
    """(slip of the rear axle, steering beyond that of a kinematic vehicle) [rad] of a steady turn."""
    lateral = slip_share(v) * v**2 * bend_pm
    return chassis.rear_slip_gradient * lateral, chassis.understeer_gradient * lateral
