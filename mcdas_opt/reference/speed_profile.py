"""The speed ahead: how fast the road's bends let a car drive in comfort, and the braking on the way to each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.comfort import ComfortSettings
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array

_STEP_M = 2.0
_AHEAD_S = 6.0  # looked ahead so far beyond the way to a stop
_STRAIGHTEST_1PM = 1e-6  # what bends less is straight


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """The most that is comfortable at places along the road: `speed_mps` (n,) every `step_m` from `start_s_m` on, infinite where nothing
    bends. Held at both ends."""

    start_s_m: float
    step_m: float
    speed_mps: Array

    def at(self, s_m: Array) -> Array:
        """(...): at these places."""
        squares = np.interp((s_m - self.start_s_m) / self.step_m, np.arange(self.speed_mps.size), self.speed_mps**2)
        return np.asarray(np.sqrt(squares))


def profile_ahead(road: Road, s_m: float, d_m: float, fastest_mps: float, comfort: ComfortSettings) -> SpeedProfile | None:
    """From s on along the offset d, for a car that drives no faster than `fastest_mps`: as fast as the lateral acceleration allows, and no
    faster than from where braking gently reaches every bend ahead in time. None where the road is straight."""
    if road.is_straight:
        return None
    reach_m = fastest_mps * fastest_mps / (2.0 * comfort.bend_braking_mps2) + fastest_mps * _AHEAD_S
    places = _STEP_M * np.arange(math.ceil(reach_m / _STEP_M) + 1)
    kappa = road.curvature_at(s_m + places)
    bend = np.maximum(np.abs(kappa / (1.0 - d_m * kappa)), _STRAIGHTEST_1PM)
    gained = 2.0 * comfort.bend_braking_mps2 * places  # of the speed's square, on the way
    squares = np.minimum.accumulate((comfort.lateral_mps2 / bend + gained)[::-1])[::-1] - gained
    return SpeedProfile(s_m, _STEP_M, np.sqrt(squares))


def speeds_along(
    profile: SpeedProfile | None,
    speed_mps: float,
    towards_mps: float,
    times_s: Array,
    *,
    rising_mps2: float,
    falling_mps2: float,
    late_mps2: float,
) -> Array:
    """(n,): the speed at each of the times of a car at the profile's start that goes towards a speed, rising and falling no faster than
    that, and obeys the profile, braking by `late_mps2` where it comes too fast."""
    found = np.empty(times_s.size)
    found[0] = v = speed_mps
    s, times = 0.0, times_s.tolist()
    speeds, step = ([], 1.0) if profile is None else (profile.speed_mps.tolist(), profile.step_m)
    last = len(speeds) - 1
    for k in range(1, found.size):
        h = times[k] - times[k - 1]
        s += v * h
        aim = min(towards_mps, v + rising_mps2 * h) if towards_mps > v else max(towards_mps, v - falling_mps2 * h)
        if last >= 0:
            i = min(int(s / step), last - 1)
            share = min(s / step - i, 1.0)
            most = math.sqrt(speeds[i] ** 2 + share * (speeds[i + 1] ** 2 - speeds[i] ** 2))
            if most < aim:
                aim = max(most, min(aim, v - late_mps2 * h))
        found[k] = v = max(aim, 0.0)
    return found
