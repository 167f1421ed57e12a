"""Legs that a program left behind at next to no length, taken out of its answer: the car stands there and steers."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.parking.path import sampled


def standing_instead(case: ParkingCase, driven: ParkingTrajectory, shorter_than_m: float) -> ParkingTrajectory | None:
    """The manoeuvre without its legs shorter than that [m]; None where it has none, or no others.

    In their place the car stands as long as steering takes; after the last leg that is left there is nothing. Every pose that follows is
    moved by what is not driven: the judge says whether that can be.
    """
    legs = driven.legs
    short = [leg for leg in legs if abs(leg.length_m) < shorter_than_m]
    if not short or len(short) == len(legs):
        return None
    t = np.unique(np.concatenate([driven.t_s, [leg.from_s for leg in short], [leg.until_s for leg in short]]))
    if legs[-1] in short:
        t = t[t <= max(leg.until_s for leg in legs if leg not in short)]
    v, delta = np.interp(t, driven.t_s, driven.speed_mps), np.interp(t, driven.t_s, driven.steering_rad)
    dt = np.diff(t)
    turning_s = np.abs(np.diff(delta)) / case.vehicle.steering_rate_max_radps
    for leg in short:
        v[(t >= leg.from_s) & (t <= leg.until_s)] = 0.0
        inside = (t[:-1] >= leg.from_s) & (t[1:] <= leg.until_s)
        dt[inside] = turning_s[inside]
    return sampled(case, np.concatenate([[0.0], np.cumsum(dt)]), v, delta)
