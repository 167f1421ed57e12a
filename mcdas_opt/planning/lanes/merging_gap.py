"""Which gap in the lane beside the host goes into before its own lane ends, and how it comes beside it.

A gap counts if the host fits into it once it is as fast as those that it is between. Whether it goes into it now is asked of the speeds as
they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from mcdas_opt.domain.settings import LEAST_SHARE, HeadwaySettings, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.front.headway import ORDINARY_MPS2
from mcdas_opt.planning.lanes.gap import (
    BESIDE_SHARE,
    FASTER_MPS,
    GAINING_MPS2,
    HARDLY_MPS,
    LOSING_MPS2,
    SLOWER_MPS,
    Gap,
    fastest_past_mps,
    short_m,
)
from mcdas_opt.planning.lanes.neighbours import CROSSING_S, follower_gap_m, gained_in_crossing_mps, known_acceleration_mps2
from mcdas_opt.planning.lanes.required_lane import AHEAD_M, AHEAD_S, RequiredLane, beside

_MERGING_S = 14.0  # before a lane's end speed is adapted to a gap; until then one that comes by itself is taken
_UNBRAKED_S, _BRAKING_S = 5.0, 2.0  # before braking for a lane's end begins less than the whole headway is accepted, and the least
_ACCEPTED_SHARE = 0.85  # of the headway that is asked for, then: who accepts it all the same makes nobody brake harder than manners allow
_LEAST_GAP_S = 0.55  # that a follower has in any case
_MATCHED_MPS = 1.0  # by so much a host is faster by the time that it is in the gap
_AHEAD_SHARE = 0.6  # of what is free in a gap, ahead of the host
_HARDLY_S = 0.01  # the least wait for a gap that is not there now
_HURRYING_MPS2 = 2.5  # with what a host that hurries becomes as fast as those beside, about
_SPARE_M = 4.0  # that a gap is longer than the host needs, for which it speeds up


class Window(NamedTuple):
    """Where the host's centre fits between two who drive on [m], and their speeds [m/s]; `mps` is the host's own once it is there."""

    low_m: float
    low_mps: float
    high_m: float
    high_mps: float
    mps: float

    def at(self, t_s: float) -> tuple[float, float]:
        """(low, high) [m] by then; where low is above high it does not fit."""
        return self.low_m + self.low_mps * t_s, self.high_m + self.high_mps * t_s


def hurries(situation: Situation, required: RequiredLane | None) -> bool:
    """Whether the host is notably slower than who is next ahead, or next behind, in the lane to which it has to change before its own
    ends."""
    if required is None or required.end_m is None:
        return False
    return any(one.speed_s_mps > situation.host.speed_mps + FASTER_MPS for one in _next_beside(situation, required))


def _next_beside(situation: Situation, required: RequiredLane) -> list[Track]:
    """Who is next behind, and next ahead, in that lane, as far as there is somebody."""
    there, s_m = beside(situation, required.side), situation.host.s_m
    return [track for track in there if track.s_m <= s_m][-1:] + [track for track in there if track.s_m > s_m][:1]


def is_time_to_adapt(situation: Situation, required: RequiredLane) -> bool:
    """Whether speed is adapted to a gap by now: sooner by the way that it takes to be as fast as those in the lane."""
    host = situation.host
    if required.own_lane_is_undrivable:
        return True
    front = next((track for track in beside(situation, required.side) if track.s_m > host.s_m), None)
    mps = host.speed_mps if front is None else max(front.speed_s_mps, AHEAD_M / AHEAD_S)
    way_m = _MERGING_S * mps + 0.5 * (host.speed_mps + mps) * _matching_s(host.speed_mps, mps)
    return _end_m(required) - host.s_m <= way_m


def _matching_s(host_mps: float, mps: float, gaining_mps2: float = GAINING_MPS2) -> float:
    """How long it takes to be as fast as that."""
    return (host_mps - mps) / LOSING_MPS2 if host_mps > mps else (mps - host_mps) / gaining_mps2


def merging_gaps(situation: Situation, vehicle: Vehicle, settings: Settings, required: RequiredLane, limit_mps: float) -> Iterator[Gap]:
    """The gaps that can be gone into before the lane ends, each with how soon."""
    there, hurried = beside(situation, required.side), hurries(situation, required)
    too_early, too_late = _short_now(there, situation, vehicle, settings, required, hurried=hurried)
    for k in range(len(there) + 1):
        gap = Gap(there[k - 1] if k > 0 else None, there[k] if k < len(there) else None)
        if max(too_early[:k], default=-math.inf) <= 0.0 and max(too_late[k:], default=-math.inf) <= 0.0:
            yield gap
        else:
            found = _later(gap, _window(gap, situation, vehicle, settings), situation, vehicle, required, limit_mps, hurried=hurried)
            if found is not None:
                yield found


def _short_now(
    there: list[Track], situation: Situation, vehicle: Vehicle, settings: Settings, required: RequiredLane, *, hurried: bool
) -> tuple[list[float], list[float]]:
    """By how much [m] the host is short of being ahead, or behind, of each, at the speeds as they are; one that is `hurried` gains speed
    while it crosses."""
    host, share = situation.host, _asked_share(situation, required)
    time_gap_s = settings.headway.time_gap_s * (LEAST_SHARE + (1.0 - LEAST_SHARE) * share)
    braking, accepted = (1.0 - share) * settings.manners.follower_braking_mps2, _ACCEPTED_SHARE + (1.0 - _ACCEPTED_SHARE) * share
    too_early, too_late = [], []
    for track in there:
        v = track.speed_s_mps
        soon_mps = max(v + known_acceleration_mps2(track), 0.0)  # who brakes makes room
        gained_mps = gained_in_crossing_mps(v, situation, settings) if hurried else _MATCHED_MPS
        host_mps = min(max(host.speed_mps, v), host.speed_mps + gained_mps)
        asked_m = max(accepted * follower_gap_m(soon_mps, host_mps, time_gap_s, braking), _LEAST_GAP_S * soon_mps)
        mean_mps = 0.5 * (host.speed_mps + host_mps) if hurried else host_mps
        too_early.append(short_m(host.s_m - track.s_m, mean_mps - v, track, vehicle, asked_m))
        asked_m = accepted * follower_gap_m(host.speed_mps, v, time_gap_s)
        too_late.append(short_m(track.s_m - host.s_m, v - host.speed_mps, track, vehicle, asked_m))
    return too_early, too_late


def _window(gap: Gap, situation: Situation, vehicle: Vehicle, settings: Settings) -> Window:
    """Where the host fits into a gap once it is as fast as who is ahead there, with the least that is accepted before a lane's end; where
    nobody is ahead, and it goes on gaining, beside who is behind."""
    time_gap_s, braking = LEAST_SHARE * settings.headway.time_gap_s, settings.manners.follower_braking_mps2
    low_m, low_mps, high_m, high_mps = -math.inf, 0.0, math.inf, 0.0
    if gap.behind is not None:
        low_mps = max(gap.behind.speed_s_mps, 0.0)
        asked_m = follower_gap_m(low_mps, low_mps, time_gap_s, braking)
        asked_m = BESIDE_SHARE * asked_m if gap.ahead is None else max(_ACCEPTED_SHARE * asked_m, _LEAST_GAP_S * low_mps)
        low_m = gap.behind.s_m + 0.5 * (gap.behind.length_m + vehicle.length_m) + asked_m
    mps = max(situation.host.speed_mps, low_mps)
    if gap.ahead is not None:
        mps = high_mps = max(gap.ahead.speed_s_mps, 0.0)
        asked_m = _ACCEPTED_SHARE * follower_gap_m(high_mps, high_mps, time_gap_s)
        high_m = gap.ahead.s_m - 0.5 * (gap.ahead.length_m + vehicle.length_m) - asked_m
    return Window(low_m, low_mps, high_m, high_mps, mps)


def _later(
    gap: Gap, window: Window, situation: Situation, vehicle: Vehicle, required: RequiredLane, limit_mps: float, *, hurried: bool
) -> Gap | None:
    """The gap with when the host is in it, as fast as those there: by speeding up or slowing down at once, by slowing down below their
    speed, or by driving on past who is to be behind. None where it does not fit by then, or not before the end."""
    host, mps = situation.host, window.mps
    matching_s = _matching_s(host.speed_mps, mps, _HURRYING_MPS2 if hurried else GAINING_MPS2)
    place_m = host.s_m + 0.5 * (host.speed_mps + mps) * matching_s
    low_m, high_m = window.at(matching_s)
    if low_m > high_m:
        return None
    if place_m < low_m:
        return _past(gap, window, low_m - place_m, situation, vehicle, required, limit_mps)
    wait_s = matching_s
    if place_m > high_m:
        wait_s += _shifted_s(place_m - high_m, 0.0, min(SLOWER_MPS, mps), LOSING_MPS2, GAINING_MPS2)
        low_m, high_m = window.at(wait_s)
        if low_m > high_m:
            return None
    wait_s, fastest = max(wait_s, _HARDLY_S), min(mps, limit_mps)
    if gap.ahead is None and not _can_still_stop(wait_s, fastest, situation, required):
        return None
    return gap._replace(wait_s=wait_s, is_slower=gap.ahead is not None, fastest_mps=fastest)


def _past(
    gap: Gap, window: Window, way_m: float, situation: Situation, vehicle: Vehicle, required: RequiredLane, limit_mps: float
) -> Gap | None:
    """The same for a gap that the host would not be far enough for, by so much way: it drives on at its speed, or speeds up where the gap
    is longer than it needs. None where it could not stop gently any more should the gap be gone."""
    host = situation.host
    if gap.behind is None:
        return None
    is_tight = window.high_m - window.low_m < _SPARE_M
    fastest = 0.0 if is_tight else fastest_past_mps(gap.behind, way_m, situation, vehicle, limit_mps)
    now_mps = host.speed_mps - window.mps
    wait_s = _shifted_s(way_m, now_mps, fastest - window.mps, GAINING_MPS2, LOSING_MPS2)
    if wait_s + CROSSING_S > required.left_s or not _can_still_stop(wait_s, fastest, situation, required):
        return None
    low_m, high_m = window.at(wait_s)
    return None if low_m > high_m else gap._replace(wait_s=wait_s, fastest_mps=fastest)


def _shifted_s(way_m: float, now_mps: float, most_mps: float, rising_mps2: float, falling_mps2: float) -> float:
    """How long it takes to come farther by that way, beside somebody, than by going over to his speed at once: at a relative speed that
    rises from what it is now to that at most, and falls to nothing again. Infinite: never."""
    begun, per_square = max(now_mps, 0.0), 0.5 / rising_mps2 + 0.5 / falling_mps2
    peak = min(max(most_mps, begun), math.sqrt(begun * begun + way_m / per_square))
    if peak < HARDLY_MPS:
        return math.inf
    held_s = max(way_m - (peak * peak - begun * begun) * per_square, 0.0) / peak
    return (peak - now_mps) / rising_mps2 + held_s + peak / falling_mps2


def _end_m(required: RequiredLane) -> float:
    return math.inf if required.end_m is None else required.end_m


def _asked_share(situation: Situation, required: RequiredLane) -> float:
    """Of what is asked for beyond the least before a lane's end: none of it by the time that ordinary braking for the end begins, or that
    the way to it is what it takes to be as fast as those beside, nor in a lane that is none to drive in."""
    host = situation.host
    if required.own_lane_is_undrivable:
        return 0.0
    faster_mps = max((track.speed_s_mps for track in _next_beside(situation, required)), default=0.0)
    matching_m = (faster_mps**2 - host.speed_mps**2) / (2.0 * _HURRYING_MPS2)
    room_m = _end_m(required) - host.s_m - max(host.speed_mps**2 / (2.0 * ORDINARY_MPS2), matching_m)
    before_s = room_m / max(host.speed_mps, AHEAD_M / AHEAD_S)
    return min(max((before_s - _BRAKING_S) / (_UNBRAKED_S - _BRAKING_S), 0.0), 1.0)


def _can_still_stop(wait_s: float, fastest_mps: float, situation: Situation, required: RequiredLane) -> bool:
    """Whether a host that gains a gap for so long stops before its lane ends by gentle braking, should the gap be gone."""
    host = situation.host
    gained_mps = max(min(fastest_mps, host.speed_mps + GAINING_MPS2 * wait_s), host.speed_mps)
    way_m = 0.5 * (host.speed_mps + gained_mps) * wait_s
    return way_m + gained_mps**2 / (2.0 * LOSING_MPS2) <= _end_m(required) - host.s_m


def least_time_gap_s(headway: HeadwaySettings) -> float:
    """The least [s] behind who is ahead that is accepted before a lane's end."""
    return _ACCEPTED_SHARE * LEAST_SHARE * headway.time_gap_s


def merging_time_gap_s(gap: Gap, speed_mps: float, vehicle: Vehicle, headway: HeadwaySettings) -> float:
    """The time gap [s] behind who is ahead in a gap before a lane's end that leaves whoever is behind his share of it."""
    if gap.ahead is None or gap.behind is None:
        return headway.time_gap_s
    free_m = gap.ahead.s_m - gap.behind.s_m - 0.5 * (gap.ahead.length_m + gap.behind.length_m) - vehicle.length_m
    time_gap_s = (_AHEAD_SHARE * free_m - headway.standstill_m) / max(speed_mps, FASTER_MPS)
    return min(max(time_gap_s, LEAST_SHARE * headway.time_gap_s), headway.time_gap_s)


def matched_time_gap_s(room_m: float, host_mps: float, ahead_mps: float) -> float:
    """The time gap [s] that a host has behind somebody once it is as fast as he is, with so much room to him beyond the gap at standstill
    now."""
    closes_m = 0.5 * (host_mps - ahead_mps) * _matching_s(host_mps, ahead_mps)
    return (room_m - closes_m) / max(ahead_mps, FASTER_MPS)
