"""The car that is parked: a kinematic bicycle at the rear axle behind slow, late and limited actuators."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.parking import ParkingLimits
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.bicycle import bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.parking.closed_loop.tracker import ParkingActuators

STEP_S = 0.01
HOLD_BELOW_MPS = 0.05


class ParkingPlant:
    """Steps of STEP_S. Commands take effect after the dead time; then steering angle and acceleration follow them by first-order lags.

    The steering keeps the vehicle's rate and angle, acceleration and both speeds the case's limits, braking the vehicle's.
    """

    def __init__(self, vehicle: Vehicle, limits: ParkingLimits, actuators: ParkingActuators, pose: Array, steering_rad: float) -> None:
        self._vehicle, self._limits, self._actuators = vehicle, limits, actuators
        self._x = [float(q) for q in pose] + [0.0, float(steering_rad)]
        self._a = 0.0
        waiting = round(actuators.delay_s / STEP_S)
        self._line = deque([(0.0, float(steering_rad))] * waiting)

    @property
    def pose(self) -> Array:
        return np.array(self._x[:3])

    @property
    def speed_mps(self) -> float:
        return self._x[3]

    @property
    def steering_rad(self) -> float:
        return self._x[4]

    def step(self, acceleration_mps2: float, steering_rad: float, hold: bool = False) -> None:
        """Move on under the commanded acceleration and angle; `hold` sets the brake for good once the car all but stands."""
        car, lags, limits = self._vehicle, self._actuators, self._limits
        self._line.append((acceleration_mps2, steering_rad))
        pushed, turned = self._line.popleft()
        brakes = pushed * self._x[3] < 0.0
        most = max(limits.acceleration_mps2, -car.acceleration_min_mps2) if brakes else limits.acceleration_mps2
        self._a += (min(max(pushed, -most), most) - self._a) * (1.0 - math.exp(-STEP_S / lags.drive_lag_s))
        v, delta = self._x[3], self._x[4]
        top, fastest = car.steering_max_rad, car.steering_rate_max_radps
        rate = (min(max(turned, -top), top) - delta) * (1.0 - math.exp(-STEP_S / lags.steering_lag_s)) / STEP_S
        rate = min(max(rate, -fastest), fastest)
        if hold and abs(v) < HOLD_BELOW_MPS:
            self._x[3], self._x[4], self._a = 0.0, delta + rate * STEP_S, 0.0
            return
        reached = min(max(v + self._a * STEP_S, -limits.reverse_mps), limits.forward_mps)
        u = ((reached - v) / STEP_S, rate)

        def motion(x: Sequence[float]) -> list[float]:
            return bicycle(x, u, car.wheelbase_m, math)

        self._x = rk4(motion, self._x, STEP_S)
