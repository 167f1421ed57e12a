"""When an answer counts: the judge passes it, and none of the judge's tolerance on clearance is used."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.angles import wrapped
from mcdas_opt.verification.parking_judge import Judgement

_ACROSS_M, _ALONG_M = 0.05, 0.3  # what a slot should leave
_SHORT_M = 5e-5  # of the asked clearance: what rounding may take


def is_sound(judgement: Judgement, clearance_m: float) -> bool:
    """Whether the judge passes the trajectory with all of the asked clearance."""
    least = judgement.min_clearance_m
    return judgement.verdict.passed and (least is None or least >= clearance_m - _SHORT_M)


def close_fits(case: ParkingCase) -> tuple[str, ...]:
    """What is said of a slot that leaves next to nothing beyond the car and its clearance on both sides."""
    if case.slot is None:
        return ()
    car, gap = case.vehicle, 2.0 * case.limits.clearance_m
    left = (("deep", case.slot.depth_m - car.width_m - gap, _ACROSS_M), ("long", case.slot.length_m - car.length_m - gap, _ALONG_M))
    return tuple(
        f"the slot is only as {word} as the car and its clearance: {100.0 * max(room_m, 0.0):.1f} cm are left, "
        "and small errors of driving do not fit"
        for word, room_m, least_m in left
        if -1e-9 <= room_m < least_m
    )


def arrived(case: ParkingCase, pose: Array) -> bool:
    """Whether a pose is the goal within the case's tolerance."""
    off = pose - case.goal
    near = float(np.hypot(off[0], off[1])) <= case.tolerance.position_m
    return near and abs(float(wrapped(off[2]))) <= case.tolerance.heading_rad
