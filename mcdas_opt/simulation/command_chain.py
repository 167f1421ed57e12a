"""From command to actuator: dead time and lags, as a vehicle's file says."""

from __future__ import annotations

import math
from collections import deque
from copy import copy
from typing import Self

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.simulation.actuators import clip
from mcdas_opt.simulation.idm import STEP_S


class CommandChain:
    """Takes the commanded (jerk, steering rate) of every step and gives what reaches the actuators by then.

    Steering: the commanded angle, delayed; the wheels follow it with their lag. Acceleration: delayed by as much; brakes and engine are
    asked for more than they are to give, so that their lag shows only where they are asked for all that they have: they near their limit
    no faster than their time constant allows.
    """

    def __init__(self, vehicle: Vehicle, state: HostState) -> None:
        self._vehicle, self._response = vehicle, vehicle.actuators
        self.delay_steps = round(self._response.steering_delay_s / STEP_S)
        self._waiting = deque([(0.0, 0.0)] * self.delay_steps)
        self.steering_rad = state.steering_rad  # commanded, once everything that waits has arrived
        self._arrived_rad = state.steering_rad  # commanded, as far as it has arrived

    def copied(self) -> Self:
        twin = copy(self)
        twin._waiting = self._waiting.copy()
        return twin

    def apply(self, jerk_mps3: float, steering_rate_radps: float, state: HostState) -> tuple[float, float]:
        """(jerk, steering rate) for the plant, which is in `state`. What a vehicle that answers at once gets is what was commanded."""
        if self._response.is_immediate:
            return jerk_mps3, steering_rate_radps
        car = self._vehicle
        rate = clip(steering_rate_radps, -car.steering_rate_max_radps, car.steering_rate_max_radps)
        before = self.steering_rad
        self.steering_rad = clip(before + rate * STEP_S, -car.steering_max_rad, car.steering_max_rad)
        self._waiting.append((jerk_mps3, self.steering_rad - before))
        jerk, turned = self._waiting.popleft()
        self._arrived_rad += turned
        wheels = (self._arrived_rad - state.steering_rad) * _share(self._response.steering_lag_s) / STEP_S
        return self._braked(jerk, state.acceleration_mps2), wheels

    def _braked(self, jerk: float, a: float) -> float:
        car, response = self._vehicle, self._response
        least, most = car.acceleration_min_mps2, car.acceleration_max_mps2
        if jerk < 0.0:  # the brakes do not wait for the engine
            engine, brakes = max(a, 0.0) * _share(response.engine_lag_s), (min(a, 0.0) - least) * _share(response.brake_build_up_s)
            return max(jerk, min(-(engine + brakes) / STEP_S, 0.0))
        fastest = (most - a) * _share(response.brake_release_s if a < 0.0 else response.engine_lag_s) / STEP_S
        return min(jerk, max(fastest, 0.0))


def _share(lag_s: float) -> float:
    """Of a first-order lag's way to a constant command, what it makes in one step."""
    return 1.0 if lag_s <= 0.0 else -math.expm1(-STEP_S / lag_s)
