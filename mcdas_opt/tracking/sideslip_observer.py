"""Sideslip and friction from what a car measures: an unscented Kalman filter on the single track with Fiala's tyres.

Source: Doumiati, Victorino, Charara and Lechner, Onboard real-time estimation of vehicle lateral tire-road forces and sideslip angle,
IEEE/ASME Trans. Mechatronics 16(4) 2011 (yaw rate and lateral acceleration, unscented); friction as a state that walks at random: Ray,
Nonlinear tire force estimation and road friction identification, Automatica 33(10) 1997. Points: Arasaratnam and Haykin, Cubature Kalman
filters, IEEE Trans. Automatic Control 54(6) 2009.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host_motion import MotionMeasurement, SlipEstimate
from mcdas_opt.domain.rules import Array, positive
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.single_track import SLIPS_ABOVE_MPS, axle_forces, body_accelerations, slip_share

LEAST_FRICTION, MOST_FRICTION = 0.05, 1.5
UNKNOWN_SD = 0.15  # of friction while the tyres do little: no estimate is less certain

# what a single track does not know of a car (roll, suspension, combined slip), as white noise, and a part that does not average out; chosen
# on swerves of the plants dynamic, std and multi-body, such that some 95 % of their sideslip lies within two standard deviations
_LATERAL_MPS2, _YAW_RADPS2, _FRICTION = 0.3, 0.3, 0.3  # per root second
_YAW_RATE_SD_RADPS, _LATERAL_SD_MPS2 = 0.005, 0.2  # of what is measured
_LASTING_RAD = 0.003
_START_SD = (0.05, 0.01, UNKNOWN_SD)  # of lateral speed, yaw rate, friction


class SideslipObserver:
    """Takes a measurement every `step_s`. State: lateral speed of the centre of gravity, yaw rate, friction.

    While tyres give force in proportion to slip, friction shows in nothing: its standard deviation stays near UNKNOWN_SD. A car that hardly
    moves (below SLIPS_ABOVE_MPS) does not slip.
    """

    def __init__(self, vehicle: Vehicle, friction: float, step_s: float = 0.01) -> None:
        self._chassis, self._step_s = Chassis.of(vehicle), positive("step_s", step_s, "s")
        self._friction = min(max(positive("friction", friction), LEAST_FRICTION), MOST_FRICTION)
        self._filter: Any = None  # while the car moves

    def update(self, measured: MotionMeasurement) -> SlipEstimate:
        """The estimate of now, from all that was measured until now."""
        if measured.speed_mps < SLIPS_ABOVE_MPS:
            self._filter = None
            yaw_rate = measured.speed_mps * math.tan(measured.steering_rad) / self._chassis.wheelbase_m
            return SlipEstimate(
                lateral_speed_mps=0.0,
                lateral_speed_sd_mps=_START_SD[0],
                yaw_rate_radps=yaw_rate + slip_share(measured.speed_mps) * (measured.yaw_rate_radps - yaw_rate),
                friction=self._friction,
                friction_sd=UNKNOWN_SD,
            )
        if self._filter is None:
            self._filter = self._begun(measured)
        else:
            self._filter.predict(measured=measured)
        self._filter.update(np.array([measured.yaw_rate_radps, measured.lateral_mps2]), measured=measured)
        self._bounded()
        return self._estimate(measured.speed_mps)

    def _begun(self, measured: MotionMeasurement) -> Any:
        """Started in the steady turn of its yaw rate."""
        from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

        c, yaw_rate = self._chassis, measured.yaw_rate_radps
        slip = c.rear_slip_gradient * measured.speed_mps * yaw_rate
        points = MerweScaledSigmaPoints(3, alpha=1.0, beta=0.0, kappa=0.0)
        found = UnscentedKalmanFilter(dim_x=3, dim_z=2, dt=self._step_s, fx=self._moved, hx=self._seen, points=points)
        found.x = np.array([c.cog_to_rear_axle_m * yaw_rate - measured.speed_mps * slip, yaw_rate, self._friction])
        found.P = np.diag(np.square(_START_SD))
        found.Q = self._step_s * np.diag([_LATERAL_MPS2**2, _YAW_RADPS2**2, _FRICTION**2])
        found.R = np.diag([_YAW_RATE_SD_RADPS**2, _LATERAL_SD_MPS2**2])
        found.sigmas_f = found.points_fn.sigma_points(found.x, found.P)
        return found

    def _accelerations(self, x: Array, measured: MotionMeasurement) -> tuple[float, float]:
        """(to the left [m/s^2], yaw [rad/s^2]) of the centre of gravity."""
        friction = min(max(float(x[2]), LEAST_FRICTION), MOST_FRICTION)
        front, rear = axle_forces(
            measured.speed_mps, float(x[0]), float(x[1]), measured.demand_mps2, measured.steering_rad, self._chassis, friction
        )
        _, aside, turning = body_accelerations(front, rear, measured.steering_rad, self._chassis)
        return aside, turning

    def _moved(self, x: Array, dt: float, measured: MotionMeasurement) -> Array:
        """A step later, by the midpoint rule."""
        aside, turning = self._accelerations(x, measured)
        half = np.array([x[0] + 0.5 * dt * (aside - measured.speed_mps * x[1]), x[1] + 0.5 * dt * turning, x[2]])
        aside, turning = self._accelerations(half, measured)
        return np.array([x[0] + dt * (aside - measured.speed_mps * half[1]), x[1] + dt * turning, x[2]])

    def _seen(self, x: Array, measured: MotionMeasurement) -> Array:
        return np.array([x[1], self._accelerations(x, measured)[0]])

    def _bounded(self) -> None:
        """Friction within what roads have; its uncertainty at most UNKNOWN_SD."""
        found = self._filter
        found.x[2] = min(max(found.x[2], LEAST_FRICTION), MOST_FRICTION)
        less = min(UNKNOWN_SD / math.sqrt(found.P[2, 2]), 1.0)
        scale = np.array([1.0, 1.0, less])
        found.P = 0.5 * (found.P + found.P.T) * np.outer(scale, scale)

    def _estimate(self, speed_mps: float) -> SlipEstimate:
        x, P, behind = self._filter.x, self._filter.P, self._chassis.cog_to_rear_axle_m
        self._friction = float(x[2])
        variance = P[0, 0] - 2.0 * behind * P[0, 1] + behind**2 * P[1, 1]
        return SlipEstimate(
            lateral_speed_mps=float(x[0] - behind * x[1]),
            lateral_speed_sd_mps=math.sqrt(max(float(variance), 0.0) + (_LASTING_RAD * speed_mps) ** 2),
            yaw_rate_radps=float(x[1]),
            friction=self._friction,
            friction_sd=math.sqrt(float(P[2, 2])),
        )
