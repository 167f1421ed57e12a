"""Plans that can be followed: something is left of every limit for the feedback, and they start wherever the car stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body, obstacle_field
from mcdas_opt.parking.park import park

# Shares of the limits that a plan may use:
STEERING_SHARE, STEERING_RATE_SHARE = 0.95, 0.85
_SPEED_SHARE, _ACCELERATION_SHARE = 0.9, 0.8
_TOLERANCE_SHARE = 0.2  # of the end pose
MARGINS_M = (0.03, 0.0)  # clearances beyond the case's that are tried in turn
_LEAST_CLEARANCE_M = 0.02  # where the car stands nearer to something than the case asks
_OFF_THE_START_M = 1e-3


def with_reserve(case: ParkingCase, clearance_m: float) -> ParkingCase:
    """The case with the limits that a plan may use; the steering angle that the car has now stays within them."""
    car, limits, end = case.vehicle, case.limits, case.tolerance
    angle = max(STEERING_SHARE * car.steering_max_rad, abs(case.start_steering_rad))
    return replace(
        case,
        tolerance=replace(end, position_m=_TOLERANCE_SHARE * end.position_m, heading_rad=_TOLERANCE_SHARE * end.heading_rad),
        vehicle=replace(car, steering_max_rad=angle, steering_rate_max_radps=STEERING_RATE_SHARE * car.steering_rate_max_radps),
        limits=replace(
            limits,
            clearance_m=clearance_m,
            forward_mps=_SPEED_SHARE * limits.forward_mps,
            reverse_mps=_SPEED_SHARE * limits.reverse_mps,
            acceleration_mps2=_ACCELERATION_SHARE * limits.acceleration_mps2,
        ),
    )


def plan_from(case: ParkingCase, pose: Array, steering_rad: float, planner: str = "nlp") -> tuple[ParkingTrajectory | None, str]:
    """A judged trajectory from rest at `pose`, relative to the case's origin, or why there is none.

    A car that stands nearer to something than the case asks plans with what it has, down to `_LEAST_CLEARANCE_M`.
    """
    here = replace(case, start=np.asarray(pose, dtype=np.float64), start_steering_rad=steering_rad)
    field, _ = obstacle_field(case.obstacles)
    body = Body.of(case.vehicle)
    has = float(field.clearance(here.start[None], body)[0]) - _OFF_THE_START_M
    ends = float(field.clearance(case.goal[None], body)[0]) - _OFF_THE_START_M
    most = min(has, ends)
    asked = dict.fromkeys(min(case.limits.clearance_m + margin, max(most, case.limits.clearance_m)) for margin in MARGINS_M)
    if _LEAST_CLEARANCE_M <= has < case.limits.clearance_m:
        asked = dict.fromkeys((has,))
    said = ""
    for clearance in asked:
        answer = park(with_reserve(here, clearance), planner)
        if answer.trajectory is not None and answer.passed:
            return answer.trajectory.moved(-case.origin_m[0], -case.origin_m[1]), ""
        said = answer.reason
    return None, said
