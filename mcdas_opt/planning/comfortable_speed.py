"""How fast the host drives at which time while nothing threatens: towards its speed, and slowly enough for the bends ahead."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.headway import ORDINARY_MPS2
from mcdas_opt.reference.speed_profile import SpeedProfile, profile_ahead, speeds_along


class ComfortableSpeed(NamedTuple):
    """The speed to arrive at [m/s], and the speed at each node of the grid on the way there (None: that speed at once)."""

    goal_mps: float
    speeds_mps: Array | None


def comfortable_speed(cycle: Cycle, towards_mps: float, d_m: float) -> ComfortableSpeed:
    """Along the offset d: towards a speed, and no faster than the road's bends allow within the horizon."""
    times_s, profile = cycle.settings.grid.times_s, bends_ahead(cycle, d_m)
    eased = 0.0 < towards_mps < cycle.given.wanted_speed_mps  # down to the speed limit
    if profile is None and not eased:
        return ComfortableSpeed(towards_mps, None)
    host_mps = cycle.situation.host.speed_mps
    speeds = speeds_along(
        profile,
        host_mps,
        towards_mps,
        times_s,
        rising_mps2=np.inf if profile is None else ORDINARY_MPS2,
        falling_mps2=ORDINARY_MPS2 if eased else np.inf,
        late_mps2=cycle.settings.comfort.late_braking_mps2,
    )
    if profile is None:
        return ComfortableSpeed(towards_mps, speeds)
    way_m = np.concatenate([[0.0], np.cumsum(speeds[:-1] * (times_s[1:] - times_s[:-1]))])
    return ComfortableSpeed(min(towards_mps, float(profile.at(profile.start_s_m + way_m).min())), speeds)


def bends_ahead(cycle: Cycle, d_m: float) -> SpeedProfile | None:
    """What the road's bends allow along the offset d from where the host is."""
    situation = cycle.situation
    fastest = max(situation.host.speed_mps, situation.wanted_speed_mps)
    return profile_ahead(situation.road, situation.host.s_m, d_m, fastest, cycle.settings.comfort)
