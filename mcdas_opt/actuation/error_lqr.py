"""Linear-quadratic steering on the four errors of the single track.

Source: Rajamani, Vehicle Dynamics and Control, 2nd ed. 2012, section 2.5 (errors of position and yaw angle, and their rates), sections
3.1 and 3.2 (state feedback, and the steering with which the errors of a steady turn vanish).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from mcdas_opt.actuation.lateral_lqr import SPEEDS_MPS, gains_at
from mcdas_opt.actuation.plan_tracking import PathError
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle

# the errors that cost as much as STEERING_RAD of steering does [Bryson's rule]
_LATERAL_M, _LATERAL_SPEED_MPS, _HEADING_RAD, _YAW_RATE_RADPS, STEERING_RAD = 0.3, 1.0, 0.06, 0.4, 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorLqr:
    """A `SteeringLaw`: gains on lateral error, its rate, heading error and its rate, for each of SPEEDS_MPS."""

    vehicle: Vehicle
    gains: Array  # (len(SPEEDS_MPS), 4)
    lead_s: float = 0.12

    @classmethod
    def design(cls, vehicle: Vehicle, lead_s: float = 0.12) -> ErrorLqr:
        return cls(vehicle=vehicle, gains=_gains(vehicle), lead_s=lead_s)

    def wheels_rad(self, error: PathError) -> float:
        c = Chassis.of(self.vehicle)
        to_cog = c.cog_to_rear_axle_m - self.vehicle.centre_m - self.vehicle.zero_sideslip_point_m  # from the body centre
        errors = np.array(
            [
                error.lateral_m + to_cog * error.heading_rad,
                error.lateral_speed_mps + to_cog * error.yaw_rate_radps,
                error.heading_rad,
                error.yaw_rate_radps,
            ]
        )
        return error.feed_forward_rad - float(gains_at(error.speed_mps, self.gains) @ errors)


@cache
def _gains(vehicle: Vehicle) -> Array:
    import control

    weights = np.diag([_LATERAL_M**-2, _LATERAL_SPEED_MPS**-2, _HEADING_RAD**-2, _YAW_RATE_RADPS**-2])
    rows = [np.array(control.lqr(*error_model(Chassis.of(vehicle), v), weights, np.array([[STEERING_RAD**-2]]))[0][0]) for v in SPEEDS_MPS]
    gains = np.array(rows, dtype=np.float64)
    gains.setflags(write=False)
    return gains


def error_model(chassis: Chassis, speed: float) -> tuple[Array, Array]:
    """(A, B) of the errors (e1, e1', e2, e2') under the steering angle (Rajamani 2012, eq 2.45; C of a whole axle)."""
    c, m, inertia = chassis, chassis.mass_kg, chassis.yaw_inertia_kgm2
    a, b = c.cog_to_front_axle_m, c.cog_to_rear_axle_m
    front, rear = c.cornering_stiffness_front_nprad, c.cornering_stiffness_rear_nprad
    both, lever, square = front + rear, front * a - rear * b, front * a**2 + rear * b**2
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [0.0, -both / (m * speed), both / m, -lever / (m * speed)],
            [0.0, 0.0, 0.0, 1.0],
            [0.0, -lever / (inertia * speed), lever / inertia, -square / (inertia * speed)],
        ]
    )
    return matrix, np.array([[0.0], [front / m], [0.0], [front * a / inertia]])
