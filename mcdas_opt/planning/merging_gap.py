"""Which gap in the lane beside the host goes into before its own lane ends, and how it comes beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from operator import itemgetter

from mcdas_opt.domain.settings import HeadwaySettings, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.gap import (
    BESIDE_SHARE,
    CROSSING_S,
    FASTER_MPS,
    GAINING_MPS2,
    HARDLY_M,
    LEAST_SHARE,
    LOSING_MPS2,
    SLOWER_MPS,
    Gap,
    fastest_past_mps,
    gained_after_s,
    short_m,
)
from mcdas_opt.planning.headway import ORDINARY_MPS2
from mcdas_opt.planning.lane_choice import follower_gap_m, known_acceleration_mps2
from mcdas_opt.planning.required_lane import AHEAD_M, AHEAD_S, RequiredLane, beside

_MERGING_S = 14.0  # before a lane's end speed is adapted to a gap; until then one that comes by itself is taken
_UNBRAKED_S, _BRAKING_S = 5.0, 2.0  # before braking for a lane's end begins less than the whole headway is accepted, and the least
_MATCHED_MPS = 1.0  # by so much a host is faster by the time that it is in the gap
_AHEAD_SHARE = 0.6  # of what is free in a gap, ahead of the host


def adapting_from_s(situation: Situation, required: RequiredLane) -> float:
    """From when on before the lane's end speed is adapted to a gap: a host that is faster than those in the lane begins sooner."""
    return _MERGING_S + _slowing_down_s(situation, required)


def _slowing_down_s(situation: Situation, required: RequiredLane) -> float:
    """How long a host whose lane ends needs to be as slow as who is next ahead in the lane to be reached."""
    host = situation.host
    front = next((track for track in beside(situation, required.side) if track.s_m > host.s_m), None)
    return 0.0 if front is None else max(host.speed_mps - front.speed_s_mps, 0.0) / LOSING_MPS2


def merging_gaps(situation: Situation, vehicle: Vehicle, settings: Settings, required: RequiredLane, limit_mps: float) -> Iterator[Gap]:
    """The gaps that can be gone into before the lane ends, each with how soon."""
    host, there = situation.host, beside(situation, required.side)
    share = _accepted_share(situation, required)
    time_gap_s = settings.headway.time_gap_s * (LEAST_SHARE + (1.0 - LEAST_SHARE) * share)
    braking = (1.0 - share) * settings.manners.follower_braking_mps2
    too_early, too_late = [], []  # for each of them: how far the host is short of being ahead, or behind
    for track in there:
        v = track.speed_s_mps
        soon_mps = max(v + known_acceleration_mps2(track), 0.0)  # who brakes makes room
        host_mps = min(max(host.speed_mps, v), host.speed_mps + _MATCHED_MPS)
        asked_m = follower_gap_m(soon_mps, host_mps, time_gap_s, braking)
        too_early.append(short_m(host.s_m - track.s_m, host_mps - v, track, vehicle, asked_m))
        asked_m = follower_gap_m(host.speed_mps, v, time_gap_s)
        too_late.append(short_m(track.s_m - host.s_m, v - host.speed_mps, track, vehicle, asked_m))
    early_then, late_then = _short_then(there, situation, vehicle, settings)
    overruns_m = [_overrun_m(host.speed_mps - track.speed_s_mps) for track in there]
    for k in range(len(there) + 1):
        is_there_now = max(too_early[:k], default=-math.inf) <= 0.0 and max(too_late[k:], default=-math.inf) <= 0.0
        early, behind = max(zip(early_then[:k], there[:k], strict=True), key=itemgetter(0), default=(-math.inf, None))
        late, ahead = max(zip(late_then[k:], there[k:], strict=True), key=itemgetter(0), default=(-math.inf, None))
        too_far_m = max((late_m + overrun_m for late_m, overrun_m in zip(late_then[k:], overruns_m[k:], strict=True)), default=-math.inf)
        if is_there_now:
            yield Gap(behind, ahead)
        elif early <= 0.0 and ahead is not None:
            most = min(SLOWER_MPS, ahead.speed_s_mps)
            wait_s = gained_after_s(late if late > 0.0 else HARDLY_M, ahead.speed_s_mps - host.speed_mps, most, LOSING_MPS2)
            yield Gap(behind, ahead, wait_s, is_slower=True)
        elif behind is not None and too_far_m <= 0.0:
            way_m = early if early > 0.0 else HARDLY_M
            fastest = fastest_past_mps(behind, early, situation, vehicle, limit_mps)
            wait_s = gained_after_s(way_m, host.speed_mps - behind.speed_s_mps, fastest - behind.speed_s_mps, GAINING_MPS2)
            if wait_s + CROSSING_S <= required.left_s and _can_still_stop(wait_s, fastest, situation, required):
                yield Gap(behind, ahead, wait_s, fastest_mps=fastest)


def _end_m(required: RequiredLane) -> float:
    return math.inf if required.end_m is None else required.end_m


def _accepted_share(situation: Situation, required: RequiredLane) -> float:
    """Of what is asked for beyond the least before a lane's end: none of it by the time that ordinary braking for the end begins."""
    host = situation.host
    room_m = _end_m(required) - host.s_m - host.speed_mps**2 / (2.0 * ORDINARY_MPS2)
    before_s = room_m / max(host.speed_mps, AHEAD_M / AHEAD_S)
    return min(max((before_s - _BRAKING_S) / (_UNBRAKED_S - _BRAKING_S), 0.0), 1.0)


def _overrun_m(closing_mps: float) -> float:
    """How much nearer a host comes to somebody until it is as slow as he is."""
    return max(closing_mps, 0.0) ** 2 / (2.0 * LOSING_MPS2)


def _short_then(there: list[Track], situation: Situation, vehicle: Vehicle, settings: Settings) -> tuple[list[float], list[float]]:
    """By how much the host is short of being ahead, or behind, of each, if it were as fast as he is: with the least headway to who is
    ahead, and such that who is behind, who sees it coming, makes room by gentle braking."""
    time_gap_s, braking = LEAST_SHARE * settings.headway.time_gap_s, settings.manners.follower_braking_mps2
    early, late = [], []
    for track in there:
        v, lengths = max(track.speed_s_mps, 0.0), 0.5 * (track.length_m + vehicle.length_m)
        ahead_m = situation.host.s_m - track.s_m
        early.append(lengths + BESIDE_SHARE * follower_gap_m(v, v, time_gap_s, braking) - ahead_m)
        late.append(lengths + follower_gap_m(v, v, time_gap_s) + ahead_m)
    return early, late


def _can_still_stop(wait_s: float, fastest_mps: float, situation: Situation, required: RequiredLane) -> bool:
    """Whether a host that gains a gap for so long stops before its lane ends by gentle braking, should the gap be gone."""
    host = situation.host
    gained_mps = max(min(fastest_mps, host.speed_mps + GAINING_MPS2 * wait_s), host.speed_mps)
    way_m = 0.5 * (host.speed_mps + gained_mps) * wait_s
    return way_m + gained_mps**2 / (2.0 * LOSING_MPS2) <= _end_m(required) - host.s_m


def merging_time_gap_s(gap: Gap, speed_mps: float, vehicle: Vehicle, headway: HeadwaySettings) -> float:
    """The time gap [s] behind who is ahead in a gap before a lane's end that leaves whoever is behind his share of it."""
    if gap.ahead is None or gap.behind is None:
        return headway.time_gap_s
    free_m = gap.ahead.s_m - gap.behind.s_m - 0.5 * (gap.ahead.length_m + gap.behind.length_m) - vehicle.length_m
    time_gap_s = (_AHEAD_SHARE * free_m - headway.standstill_m) / max(speed_mps, FASTER_MPS)
    return min(max(time_gap_s, LEAST_SHARE * headway.time_gap_s), headway.time_gap_s)
