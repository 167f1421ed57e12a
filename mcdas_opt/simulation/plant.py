"""The car that is driven: a kinematic bicycle whose actuators and tyres saturate."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.bicycle import lateral_acceleration, road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.simulation.idm import STEP_S

_AT_REST_MPS = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class Applied:
    """What the actuators did over one step: jerk, steering rate, and v^2 kappa of the path at the beginning of the step."""

    jerk_mps3: float
    steering_rate_radps: float
    lateral_acceleration_mps2: float


class Plant(Protocol):
    """A car in the loop."""

    @property
    def state(self) -> HostState: ...

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        """Moves on by STEP_S under the commanded inputs, as far as the car can follow them."""
        ...


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
        self._grip = road.friction * GRAVITY_MPS2
        self._a_low = max(vehicle.acceleration_min_mps2, -self._grip)
        self._a_high = min(vehicle.acceleration_max_mps2, self._grip)
        s, d, psi, v, a, delta = (float(q) for q in state.to_vector())
        a = min(max(a, 0.0 if v <= 0.0 else self._a_low), self._a_high)
        self._x = [s, d, psi, v, a, min(max(delta, -vehicle.steering_max_rad), vehicle.steering_max_rad)]

    @property
    def state(self) -> HostState:
        s, d, psi, v, a, delta = self._x
        return HostState(s_m=s, d_m=d, heading_rad=psi, speed_mps=v, acceleration_mps2=a, steering_rad=delta)

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        car = self._vehicle
        _, _, _, v, a, delta = self._x
        low = 0.0 if v <= 0.0 else self._a_low
        high = 0.0 if v >= car.speed_max_mps else self._a_high
        jerk = _towards(_clip(jerk_mps3, car.jerk_min_mps3, car.jerk_max_mps3), a, low, high)
        rate = _clip(steering_rate_radps, -car.steering_rate_max_radps, car.steering_rate_max_radps)
        rate = _towards(rate, delta, -car.steering_max_rad, car.steering_max_rad)
        turned = self._path_steering(v, a, delta)
        applied = Applied(
            jerk_mps3=jerk,
            steering_rate_radps=rate,
            lateral_acceleration_mps2=float(lateral_acceleration(v, turned, car.wheelbase_m, math)),
        )
        stop = _standstill_after(v, a, jerk)
        if stop < STEP_S:
            self._integrate(jerk, rate, stop)
            self._x[5] += rate * (STEP_S - stop)
            self._x[3], self._x[4] = 0.0, 0.0
        else:
            self._integrate(jerk, rate, STEP_S)
            self._x[3] = max(self._x[3], 0.0)
            if self._x[3] > car.speed_max_mps:
                self._x[3], self._x[4] = car.speed_max_mps, min(self._x[4], 0.0)
        self._x[4] = _clip(self._x[4], self._a_low, self._a_high)  # rounding
        self._x[5] = _clip(self._x[5], -car.steering_max_rad, car.steering_max_rad)
        return applied

    def _integrate(self, jerk: float, rate: float, h: float) -> None:
        wheelbase, centre = self._vehicle.wheelbase_m, self._vehicle.centre_m

        def motion(x: Sequence[float]) -> list[float]:
            s, d, psi, v, a, delta = x
            kappa = 0.0 if self._straight else float(self._road.curvature_at(s))
            turned = self._path_steering(v, a, delta)
            return road_bicycle((s, d, psi, v, a, turned), (jerk, rate), kappa, wheelbase, centre, math)

        self._x = rk4(motion, self._x, h)

    def _path_steering(self, v: float, a: float, delta: float) -> float:
        """The steering angle whose curvature the tyres can hold."""
        left = math.sqrt(max(self._grip**2 - a**2, 0.0))
        if abs(lateral_acceleration(v, delta, self._vehicle.wheelbase_m, math)) <= left:
            return delta
        return math.copysign(math.atan(self._vehicle.wheelbase_m * left / v**2), delta)


def _clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def _towards(rate: float, value: float, low: float, high: float) -> float:
    """`rate`, slowed so that `value` stays within its limits over one step."""
    return _clip(rate, min((low - value) / STEP_S, 0.0), max((high - value) / STEP_S, 0.0))


def _standstill_after(v: float, a: float, jerk: float) -> float:
    """Time [s] until v + a t + jerk t^2 / 2 falls below 0, at least STEP_S when it does not within a step."""
    if v + a * STEP_S + 0.5 * jerk * STEP_S**2 >= 0.0:
        return STEP_S
    if v <= _AT_REST_MPS:
        return 0.0
    root = math.sqrt(max(a * a - 2.0 * jerk * v, 0.0))
    return (a + root) / -jerk if a > 0.0 else 2.0 * v / (root - a)


PLANTS: dict[str, Callable[[Vehicle, Road, HostState], Plant]] = {"kinematic": KinematicPlant}


def make_plant(name: str, vehicle: Vehicle, road: Road, state: HostState) -> Plant:
    """The plant of that name. Raises `ParameterError` that lists the known ones."""
    if name not in PLANTS:
        raise ParameterError("plant", name, nearest(name, PLANTS))
    return PLANTS[name](vehicle, road, state)
