"""The dynamic vehicle: a plant of one track with saturating tyres."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.dynamics.single_track import NO_SLIP_BELOW_MPS, axle_forces, body_accelerations, slip_share
from mcdas_opt.simulation.actuators import Actuators, Applied, standstill_after
from mcdas_opt.simulation.idm import STEP_S

_RELAXATION_S = 0.05


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


class DynamicPlant:
    """Forward, sideways and yaw speed follow the forces of two axles (`dynamics.single_track`), by fourth-order Runge-Kutta, STEP_S each.

    Actuators as the kinematic plant's: jerk, steering rate, acceleration and steering angle keep their limits, the wanted acceleration
    mu g as well. The longitudinal force is m a, shared by axle load; what is left of each axle's friction circle is for turning. So the
    acceleration in the state is the one asked of brakes and engine; turning drags the speed down besides.

    Slip angles lose their meaning at low speed. Below 3 m/s the vehicle goes over to the no-slip bicycle, and is one below 1 m/s
    (blended by speed: Kabzan et al., AMZ Driverless, J. Field Robotics 37(7) 2020, section 5.3; here the blend is smooth, and slip
    relaxes to zero). Nobody reverses. The vehicle begins `in_steady_turn`.
    """

    def __init__(self, vehicle: Vehicle, road: Road, state: HostState) -> None:
        self._vehicle, self._road, self._straight = vehicle, road, road.is_straight
        self._chassis = Chassis.of(vehicle)
        self._actuators = Actuators(vehicle=vehicle, friction=road.friction)
        start = in_steady_turn(state, vehicle, road)
        s, d, psi, v, a, delta = (float(q) for q in start.to_vector())
        yaw_rate = start.yaw_rate_radps
        self._x = [s, d, psi, v, start.lateral_speed_mps + self._chassis.cog_to_rear_axle_m * yaw_rate, yaw_rate, a, delta]

    @property
    def state(self) -> SlidingState:
        s, d, psi, v, vy, yaw_rate, a, delta = self._x
        return SlidingState(
            s_m=s,
            d_m=d,
            heading_rad=psi,
            speed_mps=v,
            acceleration_mps2=a,
            steering_rad=delta,
            lateral_speed_mps=vy - self._chassis.cog_to_rear_axle_m * yaw_rate,
            yaw_rate_radps=yaw_rate,
        )

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        v, a, delta = self._x[3], self._x[6], self._x[7]
        jerk, rate = self._actuators.follow(jerk_mps3, steering_rate_radps, v, a, delta)
        applied = Applied(jerk_mps3=jerk, steering_rate_radps=rate, lateral_acceleration_mps2=self._lateral_acceleration())
        stop = standstill_after(v, a, jerk) if v < NO_SLIP_BELOW_MPS else STEP_S
        self._integrate(jerk, rate, stop)
        if stop < STEP_S or self._x[3] < 0.0:
            self._x[3:7] = [0.0, 0.0, 0.0, 0.0]
            self._x[7] += rate * (STEP_S - stop)
        elif self._x[3] > self._vehicle.speed_max_mps:
            self._x[3], self._x[6] = self._vehicle.speed_max_mps, min(self._x[6], 0.0)
        self._x[6:] = self._actuators.hold(self._x[3], self._x[6], self._x[7])  # rounding
        return applied

    def _integrate(self, jerk: float, rate: float, h: float) -> None:
        offset = self._vehicle.centre_m - self._chassis.cog_to_rear_axle_m  # of the body centre ahead of the centre of gravity

        def motion(x: Sequence[float]) -> list[float]:
            s, d, psi, v, vy, yaw_rate, _, _ = x
            kappa = 0.0 if self._straight else float(self._road.curvature_at(s))
            aside = vy + offset * yaw_rate
            s_dot = (v * math.cos(psi) - aside * math.sin(psi)) / (1.0 - d * kappa)
            d_dot = v * math.sin(psi) + aside * math.cos(psi)
            return [s_dot, d_dot, yaw_rate - kappa * s_dot, *self._velocity_rates(x, rate), jerk, rate]

        self._x = rk4(motion, self._x, h)

    def _velocity_rates(self, x: Sequence[float], rate: float) -> tuple[float, float, float]:
        """d/dt of forward, sideways (at the centre of gravity) and yaw speed."""
        _, _, _, v, vy, yaw_rate, a, delta = x
        share, chassis = slip_share(v), self._chassis
        slipping = no_slip = (0.0, 0.0, 0.0)
        if share > 0.0:
            front, rear = axle_forces(v, vy, yaw_rate, a, delta, chassis, self._road.friction)
            forward, aside, turning = body_accelerations(front, rear, delta, chassis)
            slipping = (forward + vy * yaw_rate, aside - v * yaw_rate, turning)
        if share < 1.0:
            held, behind = self._actuators.steering_held(v, a, delta), chassis.cog_to_rear_axle_m
            turn = math.tan(held) / chassis.wheelbase_m
            change = v * rate * (1.0 / chassis.wheelbase_m + chassis.wheelbase_m * turn**2) if held == delta else 0.0
            turning = a * turn + change
            no_slip = (
                a,
                behind * turning + (behind * v * turn - vy) / _RELAXATION_S,
                turning + (v * turn - yaw_rate) / _RELAXATION_S,
            )
        return (
            no_slip[0] + share * (slipping[0] - no_slip[0]),
            no_slip[1] + share * (slipping[1] - no_slip[1]),
            no_slip[2] + share * (slipping[2] - no_slip[2]),
        )

    def _lateral_acceleration(self) -> float:
        _, _, _, v, vy, yaw_rate, a, delta = self._x
        share = slip_share(v)
        front, rear = axle_forces(v, vy, yaw_rate, a, delta, self._chassis, self._road.friction)
        held = self._actuators.steering_held(v, a, delta)
        of_forces = body_accelerations(front, rear, delta, self._chassis)[1]
        return share * of_forces + (1.0 - share) * v**2 * math.tan(held) / self._vehicle.wheelbase_m
