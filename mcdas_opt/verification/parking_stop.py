"""Is there a stop? The judge of parking on a trajectory that begins in motion and ends at rest, wherever that is."""

from __future__ import annotations

from dataclasses import replace

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.verdict import Verdict, ViolationKind
from mcdas_opt.verification.parking_judge import Judgement, judge_parking

_IN_MOTION = ViolationKind.START_SPEED  # the one rule that a stop need not keep


def judge_stop(case: ParkingCase, stop: ParkingTrajectory, clearance_m: float) -> Judgement:
    """All rules of parking but the start at rest: integral, limits, rest at the end, and `clearance_m` to every obstacle throughout."""
    if not len(stop):
        return judge_parking(case, stop)
    here = replace(
        case,
        start=stop.poses[0],
        goal=stop.poses[-1],
        start_steering_rad=float(stop.steering_rad[0]),
        limits=replace(case.limits, clearance_m=clearance_m),
    )
    found = judge_parking(here, stop)
    return replace(found, verdict=Verdict(violations=tuple(v for v in found.verdict.violations if v.kind is not _IN_MOTION)))
