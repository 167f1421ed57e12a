"""The kinematic vehicle: a plant without slip whose actuators and tyres saturate."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.bicycle import lateral_acceleration, road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.simulation.actuators import Actuators, Applied, clip, standstill_after
from mcdas_opt.simulation.idm import STEP_S


class KinematicPlant:
    """`road_bicycle` by fourth-order Runge-Kutta in steps of STEP_S, with what a car cannot do cut off, in this order:

    1. jerk and steering rate are clipped to the vehicle's limits;
    2. they end where the acceleration or the steering angle meets its limit, and the acceleration at mu g of the true road;
    3. over the friction circle the *steering gives way first*: the wheels keep their angle, but the path bends no more than
       sqrt((mu g)^2 - a^2) / v^2 (understeer); with no grip left for turning at all, the acceleration is the one of 2;
    4. the speed stays in [0, speed_max]: where it meets an end, the acceleration towards it becomes 0 at once. Nobody reverses.

    Where nothing saturates the inputs applied are the inputs commanded, and the motion is the bicycle's.
    """

    def __init__(self, vehicle: Vehicle, road: Road, state: HostState) -> None:
        self._vehicle, self._road, self._straight = vehicle, road, road.is_straight
        self._actuators = Actuators(vehicle=vehicle, friction=road.friction)
        s, d, psi, v, a, delta = (float(q) for q in state.to_vector())
        self._x = [s, d, psi, v, *self._actuators.hold(v, a, delta)]

    @property
    def state(self) -> HostState:
        s, d, psi, v, a, delta = self._x
        return HostState(s_m=s, d_m=d, heading_rad=psi, speed_mps=v, acceleration_mps2=a, steering_rad=delta)

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        car = self._vehicle
        _, _, _, v, a, delta = self._x
        jerk, rate = self._actuators.follow(jerk_mps3, steering_rate_radps, v, a, delta)
        turned = self._actuators.steering_held(v, a, delta)
        applied = Applied(
            jerk_mps3=jerk,
            steering_rate_radps=rate,
            lateral_acceleration_mps2=float(lateral_acceleration(v, turned, car.wheelbase_m, math)),
        )
        stop = standstill_after(v, a, jerk)
        if stop < STEP_S:
            self._integrate(jerk, rate, stop)
            self._x[5] += rate * (STEP_S - stop)
            self._x[3], self._x[4] = 0.0, 0.0
        else:
            self._integrate(jerk, rate, STEP_S)
            self._x[3] = max(self._x[3], 0.0)
            if self._x[3] > car.speed_max_mps:
                self._x[3], self._x[4] = car.speed_max_mps, min(self._x[4], 0.0)
        low, high = self._actuators.acceleration_range  # rounding
        self._x[4] = clip(self._x[4], low, high)
        self._x[5] = clip(self._x[5], -car.steering_max_rad, car.steering_max_rad)
        return applied

    def _integrate(self, jerk: float, rate: float, h: float) -> None:
        wheelbase, centre = self._vehicle.wheelbase_m, self._vehicle.centre_m

        def motion(x: Sequence[float]) -> list[float]:
            s, d, psi, v, a, delta = x
            kappa = 0.0 if self._straight else float(self._road.curvature_at(s))
            turned = self._actuators.steering_held(v, a, delta)
            return road_bicycle((s, d, psi, v, a, turned), (jerk, rate), kappa, wheelbase, centre, math)

        self._x = rk4(motion, self._x, h)
