"""Into which slot a closed form's path fits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mcdas_opt.parking.case_file import slot_case
from mcdas_opt.parking.closed_form import CLOSED_FORMS
from mcdas_opt.parking.world import World
from mcdas_opt.verification.parking_judge import judge_parking

_LITERAL_OFFSET_M = 3.7  # sideways, of the paper's manoeuvre (Table 5)


def shortest_slot(name: str) -> float | None:
    """The shortest slot [m] of the contract's form, to 1 cm, that a closed form's path fits into; None when not even one of 20 m does.

    Only the swept body counts here, integrated where the form can be driven, as published for the literal one. The street is left wide
    open, the start is free and the goal is as far back as the clearance lets it, so that nothing but the slot decides.
    """

    def fits(length: float) -> bool:
        case = slot_case(length)
        back = case.vehicle.rear_overhang_m + case.limits.clearance_m + (0.03 if name == "closed-form" else 0.002)  # it ends askew
        goal = np.array([back, case.goal[1], 0.0])
        case = replace(case, obstacles=case.obstacles[:3], names=case.names[:3], goal=goal)
        if name == "closed-form":
            case = replace(case, start=np.array([case.start[0], goal[1] + _LITERAL_OFFSET_M, 0.0]))
        trajectory = CLOSED_FORMS[name](case)
        if name == "closed-form":
            reversing = trajectory.speed_mps < 0.0
            return float(World.of(case).clearance(trajectory.poses[reversing]).min()) >= case.limits.clearance_m
        return judge_parking(case, trajectory).verdict.passed

    low, high = 4.6, 20.0
    if not fits(high):
        return None
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high
