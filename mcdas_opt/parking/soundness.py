"""When an answer counts: the judge passes it, and none of the judge's tolerance on clearance is used."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.angles import wrapped
from mcdas_opt.verification.parking_judge import Judgement

_SHORT_M = 5e-5  # of the asked clearance: what rounding may take


def is_sound(judgement: Judgement, clearance_m: float) -> bool:
    """Whether the judge passes the trajectory with all of the asked clearance."""
    least = judgement.min_clearance_m
    return judgement.verdict.passed and (least is None or least >= clearance_m - _SHORT_M)


def arrived(case: ParkingCase, pose: Array) -> bool:
    """Whether a pose is the goal within the case's tolerance."""
    off = pose - case.goal
    near = float(np.hypot(off[0], off[1])) <= case.tolerance.position_m
    return near and abs(float(wrapped(off[2]))) <= case.tolerance.heading_rad
