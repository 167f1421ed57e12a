"""The speed ahead: how fast the road's bends let a car drive in comfort, and the braking on the way to each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.comfort import GRIP_SHARE, ComfortSettings
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.native.library import library

_STEP_M = 2.0
_AHEAD_S, _FARTHEST_M = 6.0, 10_000.0  # looked ahead so far beyond the way to a stop, and no farther than so
CLOSING_S = 3.5  # a small difference from the gap to keep decays with
_CLOSING_MPS2 = 1.2  # who closes in over a large one brakes by
STOPPING_MPS2 = 2.0  # before the end of a lane
_NEAREST_M = 0.1
BEHIND_MPS2, AS_HARD = 1.5, 1.25  # who follows brakes by at least so much, and so many times as hard as who is ahead
_STANDING_MPS, _STOPPING_S = 0.3, 2.5
_NEAR_M = _CLOSING_MPS2 * CLOSING_S**2  # as far as that is small
_NUMBERS = (AS_HARD, _STANDING_MPS, _STOPPING_S, _NEAREST_M, 2.0)
_NOWHERE = np.zeros(0)
_BEFORE_LIMIT_S = 0.5  # a lower limit is kept from so long before, since what is driven lags behind
_PATH_SHARE = 0.9  # of the lateral acceleration that is comfortable: a driven path bends more than the road, here and there
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


def profile_ahead(
    road: Road,
    s_m: float,
    d_m: float,
    fastest_mps: float,
    comfort: ComfortSettings,
    stops_m: float = math.inf,
    limits: Sequence[tuple[float, float]] = (),
    stopping_mps2: float = STOPPING_MPS2,
) -> SpeedProfile | None:
    """From s on along the offset d, for a car that drives no faster than `fastest_mps`: as fast as the lateral acceleration allows, and no
    faster than from where braking gently reaches every bend ahead in time, and each of the `limits` that hold from an s on [(m, m/s)], and
    stops within `stops_m` by braking with `stopping_mps2`; of each less on a slippery road. None where the road is straight, that is far,
    and no limit is lower."""
    comfort = comfort.on(road.grip_mps2)
    reach_m = min(fastest_mps * fastest_mps / (2.0 * comfort.bend_braking_mps2) + fastest_mps * _AHEAD_S, _FARTHEST_M)
    limits = [one for one in limits if one[0] < s_m + reach_m]
    if road.is_straight and stops_m > reach_m and all(limit >= fastest_mps for _, limit in limits):
        return None
    places = _STEP_M * np.arange(math.ceil(reach_m / _STEP_M) + 1, dtype=np.float64)
    gained = 2.0 * comfort.bend_braking_mps2 * places  # of the speed's square, on the way
    free = squares_in_bends(road, s_m + places, d_m, comfort.lateral_mps2)
    for (begins_m, limit_mps), (ends_m, _) in pairwise((*limits, (math.inf, 0.0))):
        here = (s_m + places >= begins_m - _BEFORE_LIMIT_S * limit_mps) & (s_m + places < ends_m)
        free[here] = np.minimum(free[here], limit_mps * limit_mps)
    squares = np.minimum.accumulate((free + gained)[::-1])[::-1] - gained
    if stops_m <= reach_m:
        stopping_mps2 = min(stopping_mps2, GRIP_SHARE * road.grip_mps2)
        squares = np.minimum(squares, 2.0 * stopping_mps2 * np.maximum(stops_m - places, 0.0))
    return SpeedProfile(s_m, _STEP_M, np.sqrt(squares))


def squares_in_bends(road: Road, s_m: Array, d_m: float, lateral_mps2: float) -> Array:
    """(n,) [m^2/s^2]: the squares of the speeds at which a path along the offset d asks for so much across at these places."""
    kappa = road.curvature_at(s_m)
    bend = np.maximum(np.abs(kappa / (1.0 - d_m * kappa)), _STRAIGHTEST_1PM)
    return np.asarray(_PATH_SHARE * lateral_mps2 / bend)


class FrontCar(NamedTuple):
    """Somebody ahead, at each of the times (n,): how far the car may go up to him, from where it is now [m], his speed [m/s], and the
    time gap to keep [s]."""

    room_m: Array
    speed_mps: Array
    time_gap_s: Array


def speeds_along(
    profile: SpeedProfile | None,
    speed_mps: float,
    towards_mps: float,
    times_s: Array,
    *,
    rising_mps2: float,
    falling_mps2: float,
    late_mps2: float,
    behind_mps2: float = BEHIND_MPS2,
    fronts: Sequence[FrontCar] = (),
) -> Array:
    """(n,): the speed at each of the times of a car at the profile's start that goes towards a speed, rising and falling no faster than
    that, follows who is ahead, braking by at least `behind_mps2` where it has to, and obeys the profile, braking by up to `late_mps2`
    where it comes too fast.

    In C where there is a compiler, with the same bits."""
    compiled = library()
    if compiled is not None:
        places, step_m = (_NOWHERE, 1.0) if profile is None else (profile.speed_mps, profile.step_m)
        closing = CLOSING_S, _CLOSING_MPS2, _NEAR_M
        own = np.array((speed_mps, towards_mps, rising_mps2, falling_mps2, late_mps2, step_m, *closing, behind_mps2, *_NUMBERS))
        cars, least, speeds_mps = np.array(fronts), np.empty(len(fronts)), np.empty(times_s.size)
        compiled.mcdas_speeds_along(times_s.size, times_s, places.size, places, len(fronts), cars, own, least, speeds_mps)
        return speeds_mps
    found = np.empty(times_s.size)
    found[0] = v = speed_mps
    s, times = 0.0, times_s.tolist()
    speeds, step = ([], 1.0) if profile is None else (profile.speed_mps.tolist(), profile.step_m)
    last, ahead = len(speeds) - 1, [tuple(row.tolist() for row in front) for front in fronts]
    behind = [max(behind_mps2, AS_HARD * (its[0] - its[1]) / (times[1] - times[0])) for _, its, _ in ahead]
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
        for (rooms, its_speeds, gaps), least in zip(ahead, behind, strict=True):
            room = rooms[k] - s
            most = its_speeds[k] + _closing_mps(room - gaps[k] * v)
            if its_speeds[k] < _STANDING_MPS:  # no time gap is kept from who stands
                most = max(most, room / _STOPPING_S)
            if most < aim:
                needed = max(v - its_speeds[k], 0.0) ** 2 / (2.0 * max(room, _NEAREST_M))
                aim = max(most, min(aim, v - min(max(needed, least), late_mps2) * h))
        found[k] = v = max(aim, 0.0)
    return found


def _closing_mps(room_m: float) -> float:
    """The speed to close with over so much room: in proportion to little of it, else such that gentle braking ends it."""
    if room_m <= _NEAR_M:
        return room_m / CLOSING_S
    return math.sqrt(2.0 * _CLOSING_MPS2 * (room_m - 0.5 * _NEAR_M))
