"""Plans that can be followed: something is left of every limit for the feedback, and they start wherever the car stands."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array, non_negative, within
from mcdas_opt.geometry.clearance import Body, obstacle_field

_OFF_THE_START_M = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Reserve:
    """Shares of the limits that a plan may use, and clearances [m] beyond the case's that are tried in turn."""

    steering: float = 0.95
    steering_rate: float = 0.85
    speed: float = 0.9
    acceleration: float = 0.8
    tolerance: float = 0.2  # of the end pose
    margins_m: tuple[float, ...] = (0.03, 0.0)
    least_clearance_m: float = 0.02  # where the car stands nearer to something than the case asks

    def __post_init__(self) -> None:
        for name in ("steering", "steering_rate", "speed", "acceleration", "tolerance"):
            within(name, getattr(self, name), 0.05, 1.0)
        for margin in (*self.margins_m, self.least_clearance_m):
            non_negative("margins_m", margin, "m")

    def of(self, case: ParkingCase, clearance_m: float) -> ParkingCase:
        """The case with the limits that a plan may use; the steering angle that the car has now stays within them."""
        car, limits, end = case.vehicle, case.limits, case.tolerance
        angle = max(self.steering * car.steering_max_rad, abs(case.start_steering_rad))
        return replace(
            case,
            tolerance=replace(end, position_m=self.tolerance * end.position_m, heading_rad=self.tolerance * end.heading_rad),
            vehicle=replace(car, steering_max_rad=angle, steering_rate_max_radps=self.steering_rate * car.steering_rate_max_radps),
            limits=replace(
                limits,
                clearance_m=clearance_m,
                forward_mps=self.speed * limits.forward_mps,
                reverse_mps=self.speed * limits.reverse_mps,
                acceleration_mps2=self.acceleration * limits.acceleration_mps2,
            ),
        )


def plan_from(
    case: ParkingCase, pose: Array, steering_rad: float, planner: str = "nlp", reserve: Reserve | None = None
) -> tuple[ParkingTrajectory | None, str]:
    """A judged trajectory from rest at `pose`, relative to the case's origin, or why there is none.

    A car that stands nearer to something than the case asks plans with what it has, down to the reserve's least clearance.
    """
    from mcdas_opt.parking.park import park

    reserve = reserve or Reserve()
    here = replace(case, start=np.asarray(pose, dtype=np.float64), start_steering_rad=steering_rad)
    field, _ = obstacle_field(case.obstacles)
    body = Body.of(case.vehicle)
    has = float(field.clearance(here.start[None], body)[0]) - _OFF_THE_START_M
    ends = float(field.clearance(case.goal[None], body)[0]) - _OFF_THE_START_M
    most = min(has, ends)
    asked = dict.fromkeys(min(case.limits.clearance_m + margin, max(most, case.limits.clearance_m)) for margin in reserve.margins_m)
    if reserve.least_clearance_m <= has < case.limits.clearance_m:
        asked = dict.fromkeys((has,))
    said = ""
    for clearance in asked:
        answer = park(reserve.of(here, clearance), planner)
        if answer.trajectory is not None and answer.passed:
            return answer.trajectory.moved(-case.origin_m[0], -case.origin_m[1]), ""
        said = answer.reason
    return None, said
