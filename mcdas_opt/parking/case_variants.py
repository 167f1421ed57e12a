"""A case changed into a related one: driven backwards, with a longer slot, with a shorter one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import positive
from mcdas_opt.errors import ParameterError


def turned_round(case: ParkingCase) -> ParkingCase:
    """The case driven backwards in time: start and goal change places, and so do the speed limits of the two gears."""
    limits = replace(case.limits, forward_mps=case.limits.reverse_mps, reverse_mps=case.limits.forward_mps)
    return replace(case, start=case.goal, goal=case.start, limits=limits, start_steering_rad=0.0)


def lengthened(case: ParkingCase, more_m: float) -> ParkingCase:
    """The case with its slot longer. The start keeps its place beside the front car, the goal its place in the middle of the slot."""
    assert case.slot is not None
    slot = replace(case.slot, length_m=case.slot.length_m + more_m)
    shift = np.array([0.5 * more_m, 0.0, 0.0])
    return replace(
        case, slot=slot, obstacles=(*slot.obstacles, *case.obstacles[4:]), goal=case.goal + shift, start=case.start + 2.0 * shift
    )


def shorter_slot(case: ParkingCase, by_m: float) -> ParkingCase:
    """The case with the rear car of its slot `by_m` further forward, and the goal in the middle of what is left.

    Raises `ParameterError` where the case has no slot.
    """
    if case.slot is None:
        raise ParameterError("case", case.name, "must have a slot to be made shorter")
    positive("by_m", by_m, "m")
    moved = np.array(case.obstacles[0])
    moved[np.isclose(moved[:, 0], moved[:, 0].max()), 0] += by_m
    goal = case.goal + np.array([0.5 * by_m, 0.0, 0.0])
    return replace(case, obstacles=(moved, *case.obstacles[1:]), goal=goal, slot=None)
