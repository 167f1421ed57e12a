"""Which gap in the lane beside takes the host to its destination's lane, and how to come beside it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from mcdas_opt.domain.settings import LEAST_SHARE, HeadwaySettings, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.front.headway import ORDINARY_MPS2
from mcdas_opt.planning.lanes.gap import (
    BESIDE_SHARE,
    GAINING_MPS2,
    HARDLY_MPS,
    LOSING_MPS2,
    SLOWER_MPS,
    Gap,
    fastest_past_mps,
    short_m,
)
from mcdas_opt.planning.lanes.neighbours import CROSSING_S, follower_gap_m, known_acceleration_mps2
from mcdas_opt.planning.lanes.required_lane import RequiredLane, beside

_YIELDING_S, _LAST_S = 8.0, 3.0  # before a destination less than the whole headway is accepted, and the least that ever is
_ARRIVING_S = 3.0  # so much sooner for a destination: by its time the change is over
_RESPONSE_S = 0.5  # until the host brakes for who is ahead in the next lane


def gets_past_somebody(required: RequiredLane | None, gap: Gap | None) -> bool:
    """Whether that gap in the destination's lane is gone into once the host has got past somebody."""
    return required is not None and not required.own_lane_ends and gap is not None and not gap.is_open and not gap.is_slower


def arriving_gaps(situation: Situation, vehicle: Vehicle, settings: Settings, required: RequiredLane, limit_mps: float) -> Iterator[Gap]:
    """The gaps that can be gone into in time, each with how soon."""
    host, there = situation.host, beside(situation, required.side)
    share = LEAST_SHARE + (1.0 - LEAST_SHARE) * _accepted_share(required.left_s - _ARRIVING_S)
    time_gap_s = settings.headway.time_gap_s * share
    too_early, too_late = [], []  # for each of them: how far the host is short of being ahead, or behind
    for track in there:
        v = track.speed_s_mps
        soon_mps = max(v + max(known_acceleration_mps2(track), 0.0), 0.0)
        asked_m = follower_gap_m(soon_mps, host.speed_mps, time_gap_s, settings.manners.follower_braking_mps2)
        too_early.append(short_m(host.s_m - track.s_m, host.speed_mps - v, track, vehicle, asked_m))
        too_late.append(_short_behind_m(track, host.speed_mps, track.s_m - host.s_m, vehicle, settings.headway, share))
    for k in range(len(there) + 1):
        behind = max(range(k), key=too_early.__getitem__, default=None)
        ahead = max(range(k, len(there)), key=too_late.__getitem__, default=None)
        early, late = -math.inf if behind is None else too_early[behind], -math.inf if ahead is None else too_late[ahead]
        gap = Gap(None if behind is None else there[behind], None if ahead is None else there[ahead])
        if early <= 0.0 and late <= 0.0:
            yield gap
        elif early <= 0.0 and gap.ahead is not None and _is_in_time_behind(gap.ahead, situation, time_gap_s):
            most = min(SLOWER_MPS, gap.ahead.speed_s_mps)
            wait_s = _gained_after_s(late, gap.ahead.speed_s_mps - host.speed_mps, most, LOSING_MPS2)
            if wait_s + CROSSING_S <= required.left_s:
                yield gap._replace(wait_s=wait_s, is_slower=True)
        elif gap.behind is not None and late <= 0.0:
            fastest = fastest_past_mps(gap.behind, early, situation, vehicle, limit_mps)
            wait_s = _gained_after_s(early, host.speed_mps - gap.behind.speed_s_mps, fastest - gap.behind.speed_s_mps, GAINING_MPS2)
            if wait_s + CROSSING_S <= required.left_s:
                yield gap._replace(wait_s=wait_s, fastest_mps=fastest)


def _accepted_share(left_s: float) -> float:
    return min(max((left_s - _LAST_S) / (_YIELDING_S - _LAST_S), 0.0), 1.0)


def _is_in_time_behind(ahead: Track, situation: Situation, time_gap_s: float) -> bool:
    """Whether who follows somebody is at the destination before its time is over, where it has one."""
    destination = situation.destination
    if destination is None or destination.s_m is None or destination.time_s is None:
        return True
    v, left_s = max(ahead.speed_s_mps, 0.0), destination.time_s[1] - situation.time_s
    return ahead.s_m + v * (left_s - time_gap_s) - ahead.length_m >= destination.s_m[0]


def _short_behind_m(track: Track, speed_mps: float, ahead_m: float, vehicle: Vehicle, headway: HeadwaySettings, share: float) -> float:
    """By how much the distance to somebody ahead, whose speed the host takes on by ordinary braking, is less than that share of the
    headway then."""
    lengths, closing_mps = 0.5 * (track.length_m + vehicle.length_m), max(speed_mps - track.speed_s_mps, 0.0)
    closes_m = closing_mps * (_RESPONSE_S + closing_mps / (2.0 * ORDINARY_MPS2))
    opens_m = max(track.speed_s_mps - speed_mps, 0.0) * CROSSING_S
    asked_m = headway.gap_m(min(speed_mps, track.speed_s_mps), share)
    return lengths + max(asked_m + closes_m - opens_m, BESIDE_SHARE * asked_m) - ahead_m


def _gained_after_s(way_m: float, now_mps: float, most_mps: float, gain_mps2: float) -> float:
    """When somebody has gained that way on another who begins with one relative speed, and goes over to another; infinite: never."""
    if most_mps < HARDLY_MPS:
        return math.inf
    if now_mps >= most_mps:
        return way_m / most_mps
    rising_s = (most_mps - now_mps) / gain_mps2
    while_rising_m = 0.5 * (now_mps + most_mps) * rising_s
    if while_rising_m < way_m:
        return rising_s + (way_m - while_rising_m) / most_mps
    return (-now_mps + math.sqrt(now_mps * now_mps + 2.0 * gain_mps2 * way_m)) / gain_mps2
