"""Which lane has to be reached: one that leads on, or the destination's; which gap in it, and how to come beside that."""

from __future__ import annotations

import math
from collections.abc import Iterator
from operator import itemgetter
from typing import NamedTuple

from mcdas_opt.domain.settings import HeadwaySettings, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.headway import ORDINARY_MPS2
from mcdas_opt.planning.lane_choice import follower_gap_m, known_acceleration_mps2, reaches_into

AHEAD_S, AHEAD_M = 20.0, 60.0  # a lane that ends within so much driving, and at least so far ahead, is left
_FARTHER_M = 30.0  # a lane must lead on by so much farther to be worth a change
# before a destination, and before a lane's end, speed is adapted to a gap; until then one that comes by itself is taken
_ADAPTING_S, _MERGING_S = 12.0, 14.0
_YIELDING_S, _LAST_S = 8.0, 3.0  # before a destination less than the whole headway is accepted, and the least that ever is
_UNBRAKED_S, _BRAKING_S = 5.0, 2.0  # the same, before braking for a lane's end begins
_ARRIVING_S = 3.0  # so much sooner for a destination: by its time the change is over
LEAST_SHARE = 0.65  # of the time gap that is asked for; then 0.8 s where that is 1.2 s
_CROSSING_S = 2.5  # from now until the body is in the new lane
_BESIDE_SHARE = 0.7  # of the gap that is asked for once there, already now
_GAINING_MPS2, _LOSING_MPS2 = 1.0, 1.5  # to get ahead of somebody, or behind
_SLOWER_MPS = 6.0  # at most, than who is let ahead
_FASTER_MPS = 3.0  # than who is passed, where the host wants to be no faster itself
_MATCHED_MPS = 1.0  # by so much a host is faster by the time that it is in the gap
_AHEAD_SHARE = 0.6  # of what is free in a gap, ahead of the host
_HARDLY_MPS, _HARDLY_M = 0.3, 0.1
_RESPONSE_S = 0.5  # until the host brakes for who is ahead in the next lane
_OWN_GAP_S = 0.5  # to who is ahead in the own lane, while one gets past somebody in the next


class RequiredLane(NamedTuple):
    """The side to change to, the time [s] until the lane there has to be reached, and where the own lane ends (None: it does not)."""

    side: Side
    left_s: float
    end_m: float | None = None


class Gap(NamedTuple):
    """Between two in the required lane (None: nobody), or before or behind all: how soon it can be gone into [s], 0: now; whether the host
    has to be slower for it until then, and the speed [m/s] that it may need for it."""

    behind: Track | None
    ahead: Track | None
    wait_s: float = 0.0
    is_slower: bool = False
    fastest_mps: float = 0.0


def gets_past_somebody(required: RequiredLane | None, gap: Gap | None) -> bool:
    """Whether that gap in the destination's lane is gone into once the host has got past somebody."""
    return required is not None and required.end_m is None and gap is not None and gap.wait_s > 0.0 and not gap.is_slower


def required_lane(situation: Situation, vehicle: Vehicle) -> RequiredLane | None:
    """The side with a lane that leads on where the host's own ends soon, else the side of the destination's lane; None where the own lane
    leads on and is the one to be in, or where nothing leads on farther."""
    road, host = situation.road, situation.host
    lane = road.lane_of(host.d_m, host.s_m)
    return _to_lead_on(situation, vehicle, lane) or _to_the_destination(situation, lane)


def _to_the_destination(situation: Situation, lane: int) -> RequiredLane | None:
    road, host, destination = situation.road, situation.host, situation.destination
    if destination is None or destination.lane is None or destination.lane == lane:
        return None
    side, beside = (Side.LEFT, lane + 1) if destination.lane > lane else (Side.RIGHT, lane - 1)
    if not road.goes_on(beside, host.s_m, host.speed_mps):
        return None
    left_s = _ADAPTING_S if destination.s_m is None else (destination.s_m[1] - host.s_m) / max(host.speed_mps, AHEAD_M / AHEAD_S)
    until_s = math.inf if destination.time_s is None else max(destination.time_s[1] - situation.time_s, 0.0)
    return RequiredLane(side, min(left_s, until_s, _ADAPTING_S))


def _to_lead_on(situation: Situation, vehicle: Vehicle, lane: int) -> RequiredLane | None:
    road, host = situation.road, situation.host
    if not road.lanes:
        return None
    end = road.lane_ends_m(lane, host.s_m, vehicle.width_m)
    if end > host.s_m + max(AHEAD_S * host.speed_mps, AHEAD_M):
        return None
    best, farthest = Side.NONE, max(end, host.s_m) + _FARTHER_M
    for side, beside in ((Side.LEFT, lane + 1), (Side.RIGHT, lane - 1)):
        if not road.goes_on(beside, host.s_m, host.speed_mps):
            continue
        reached = road.lane_ends_m(beside, host.s_m, vehicle.width_m)
        if reached > farthest:
            best, farthest = side, reached
    if best is Side.NONE:
        return None
    return RequiredLane(best, max(end - host.s_m, 0.0) / max(host.speed_mps, AHEAD_M / AHEAD_S), end)


def best_gap(situation: Situation, vehicle: Vehicle, settings: Settings, required: RequiredLane, limit_mps: float) -> Gap | None:
    """The gap that can be gone into soonest, before the lane has to be reached where the host has to be faster for it; None where there is
    none. While there is time only one that is there now counts; a host that is faster than those in the lane begins sooner."""
    found = _gaps(situation, vehicle, settings, required, limit_mps)
    begins_s = _ADAPTING_S if required.end_m is None else _MERGING_S + _slowing_down_s(situation, required)
    if required.left_s > begins_s:
        found = (gap for gap in found if gap.wait_s == 0.0)
    return min(found, key=lambda gap: gap.wait_s, default=None)


def _slowing_down_s(situation: Situation, required: RequiredLane) -> float:
    """How long a host whose lane ends needs to be as slow as who is next ahead in the lane to be reached."""
    host, road = situation.host, situation.road
    beside = road.lane_of(host.d_m, host.s_m) + (1 if required.side is Side.LEFT else -1)
    front = next((track for track in _in_lane(situation, beside) if track.s_m > host.s_m), None)
    return 0.0 if front is None else max(host.speed_mps - front.speed_s_mps, 0.0) / _LOSING_MPS2


def _gaps(situation: Situation, vehicle: Vehicle, settings: Settings, required: RequiredLane, limit_mps: float) -> Iterator[Gap]:
    road, host = situation.road, situation.host
    own = road.lane_of(host.d_m, host.s_m)
    there = _in_lane(situation, own + (1 if required.side is Side.LEFT else -1))
    leader = next_ahead(situation, road.lane_centre_m(own, host.s_m))
    is_arriving = required.end_m is None
    left_s = required.left_s - (_ARRIVING_S if is_arriving else 0.0)
    share = _arriving_share(left_s) if is_arriving else _leading_on_share(situation, required)
    time_gap_s = settings.headway.time_gap_s * (LEAST_SHARE + (1.0 - LEAST_SHARE) * share)
    braking = (1.0 if is_arriving else 1.0 - share) * settings.manners.follower_braking_mps2
    too_early, too_late = [], []  # for each of them: how far the host is short of being ahead, or behind
    for track in there:
        v, known = track.speed_s_mps, known_acceleration_mps2(track)
        soon_mps = max(v + (max(known, 0.0) if is_arriving else known), 0.0)  # before a lane's end who brakes makes room
        host_mps = host.speed_mps if is_arriving else min(max(host.speed_mps, v), host.speed_mps + _MATCHED_MPS)
        asked_m = follower_gap_m(soon_mps, host_mps, time_gap_s, braking)
        too_early.append(_short_m(host.s_m - track.s_m, host_mps - v, track, vehicle, asked_m))
        if is_arriving:
            too_late.append(_short_behind_m(track, host.speed_mps, track.s_m - host.s_m, vehicle, settings.headway, time_gap_s))
        else:
            asked_m = follower_gap_m(host.speed_mps, v, time_gap_s)
            too_late.append(_short_m(track.s_m - host.s_m, v - host.speed_mps, track, vehicle, asked_m))
    early_then, late_then = (too_early, too_late) if is_arriving else _short_then(there, situation, vehicle, settings)
    overruns_m = [0.0 if is_arriving else _overrun_m(host.speed_mps - track.speed_s_mps) for track in there]
    for k in range(len(there) + 1):
        is_there_now = max(too_early[:k], default=-math.inf) <= 0.0 and max(too_late[k:], default=-math.inf) <= 0.0
        early, behind = max(zip(early_then[:k], there[:k], strict=True), key=itemgetter(0), default=(-math.inf, None))
        late, ahead = max(zip(late_then[k:], there[k:], strict=True), key=itemgetter(0), default=(-math.inf, None))
        too_far_m = max((late_m + overrun_m for late_m, overrun_m in zip(late_then[k:], overruns_m[k:], strict=True)), default=-math.inf)
        if is_there_now:
            yield Gap(behind, ahead)
        elif early <= 0.0 and ahead is not None and _is_in_time_behind(ahead, situation, time_gap_s):
            most = min(_SLOWER_MPS, ahead.speed_s_mps)
            wait_s = _gained_after_s(late if late > 0.0 else _HARDLY_M, ahead.speed_s_mps - host.speed_mps, most, _LOSING_MPS2)
            if not is_arriving or wait_s + _CROSSING_S <= required.left_s:
                yield Gap(behind, ahead, wait_s, is_slower=True)
        elif behind is not None and too_far_m <= 0.0:
            fastest = min(max(situation.wanted_speed_mps, behind.speed_s_mps + _FASTER_MPS), limit_mps)
            if leader is not None:
                room_m = leader.s_m - host.s_m - 0.5 * (leader.length_m + vehicle.length_m) - _OWN_GAP_S * host.speed_mps
                fastest = fastest if early <= room_m else min(fastest, leader.speed_s_mps)
            way_m = early if early > 0.0 else _HARDLY_M
            wait_s = _gained_after_s(way_m, host.speed_mps - behind.speed_s_mps, fastest - behind.speed_s_mps, _GAINING_MPS2)
            if wait_s + _CROSSING_S <= required.left_s and _can_still_stop(wait_s, fastest, situation, required):
                yield Gap(behind, ahead, wait_s, fastest_mps=fastest)


def _arriving_share(left_s: float) -> float:
    return min(max((left_s - _LAST_S) / (_YIELDING_S - _LAST_S), 0.0), 1.0)


def _leading_on_share(situation: Situation, required: RequiredLane) -> float:
    """Of what is asked for beyond the least before a lane's end: none of it by the time that ordinary braking for the end begins."""
    host = situation.host
    room_m = (required.end_m or 0.0) - host.s_m - host.speed_mps**2 / (2.0 * ORDINARY_MPS2)
    before_s = room_m / max(host.speed_mps, AHEAD_M / AHEAD_S)
    return min(max((before_s - _BRAKING_S) / (_UNBRAKED_S - _BRAKING_S), 0.0), 1.0)


def _overrun_m(closing_mps: float) -> float:
    """How much nearer a host comes to somebody until it is as slow as he is."""
    return max(closing_mps, 0.0) ** 2 / (2.0 * _LOSING_MPS2)


def _short_then(there: list[Track], situation: Situation, vehicle: Vehicle, settings: Settings) -> tuple[list[float], list[float]]:
    """By how much the host is short of being ahead, or behind, of each, if it were as fast as he is: with the least headway to who is
    ahead, and such that who is behind, who sees it coming, makes room by gentle braking."""
    time_gap_s, braking = LEAST_SHARE * settings.headway.time_gap_s, settings.manners.follower_braking_mps2
    early, late = [], []
    for track in there:
        v, lengths = max(track.speed_s_mps, 0.0), 0.5 * (track.length_m + vehicle.length_m)
        ahead_m = situation.host.s_m - track.s_m
        early.append(lengths + _BESIDE_SHARE * follower_gap_m(v, v, time_gap_s, braking) - ahead_m)
        late.append(lengths + follower_gap_m(v, v, time_gap_s) + ahead_m)
    return early, late


def _can_still_stop(wait_s: float, fastest_mps: float, situation: Situation, required: RequiredLane) -> bool:
    """Whether a host that gains a gap for so long stops before its lane ends by gentle braking, should the gap be gone."""
    if required.end_m is None:
        return True
    host = situation.host
    gained_mps = max(min(fastest_mps, host.speed_mps + _GAINING_MPS2 * wait_s), host.speed_mps)
    way_m = 0.5 * (host.speed_mps + gained_mps) * wait_s
    return way_m + gained_mps**2 / (2.0 * _LOSING_MPS2) <= required.end_m - host.s_m


def merging_time_gap_s(gap: Gap, speed_mps: float, vehicle: Vehicle, headway: HeadwaySettings) -> float:
    """The time gap [s] behind who is ahead in a gap before a lane's end that leaves whoever is behind his share of it."""
    if gap.ahead is None or gap.behind is None:
        return headway.time_gap_s
    free_m = gap.ahead.s_m - gap.behind.s_m - 0.5 * (gap.ahead.length_m + gap.behind.length_m) - vehicle.length_m
    time_gap_s = (_AHEAD_SHARE * free_m - headway.standstill_m) / max(speed_mps, _FASTER_MPS)
    return min(max(time_gap_s, LEAST_SHARE * headway.time_gap_s), headway.time_gap_s)


def _is_in_time_behind(ahead: Track, situation: Situation, time_gap_s: float) -> bool:
    """Whether who follows somebody is at the destination before its time is over, where it has one."""
    destination = situation.destination
    if destination is None or destination.s_m is None or destination.time_s is None:
        return True
    v, left_s = max(ahead.speed_s_mps, 0.0), destination.time_s[1] - situation.time_s
    return ahead.s_m + v * (left_s - time_gap_s) - ahead.length_m >= destination.s_m[0]


def next_ahead(situation: Situation, d_m: float) -> Track | None:
    """Who is next ahead of the host in the lane that is there."""
    road, host = situation.road, situation.host
    return next((track for track in _in_lane(situation, road.lane_of(d_m, host.s_m)) if track.s_m > host.s_m), None)


def _in_lane(situation: Situation, lane: int) -> list[Track]:
    """Whose body reaches into a lane, from behind to ahead."""
    road = situation.road
    there = (one for one in situation.tracks if reaches_into(one, road.lane_centre_m(lane, one.s_m), road.lane_width_at(lane, one.s_m)))
    return sorted(there, key=lambda one: one.s_m)


def _short_m(ahead_m: float, opening_mps: float, track: Track, vehicle: Vehicle, asked_m: float) -> float:
    """By how much a distance between two middles, which opens at that speed, is less than what is asked for from bumper to bumper once the
    host is in the lane, and half of that now."""
    lengths = 0.5 * (track.length_m + vehicle.length_m)
    return max(lengths + asked_m - ahead_m - opening_mps * _CROSSING_S, lengths + _BESIDE_SHARE * asked_m - ahead_m)


def _short_behind_m(track: Track, speed_mps: float, ahead_m: float, vehicle: Vehicle, headway: HeadwaySettings, time_gap_s: float) -> float:
    """By how much the distance to somebody ahead, whose speed the host takes on by ordinary braking, is less than that headway then."""
    lengths, closing_mps = 0.5 * (track.length_m + vehicle.length_m), max(speed_mps - track.speed_s_mps, 0.0)
    closes_m = closing_mps * (_RESPONSE_S + closing_mps / (2.0 * ORDINARY_MPS2))
    opens_m = max(track.speed_s_mps - speed_mps, 0.0) * _CROSSING_S
    asked_m = headway.standstill_m + min(speed_mps, max(track.speed_s_mps, 0.0)) * time_gap_s
    return lengths + max(asked_m + closes_m - opens_m, _BESIDE_SHARE * asked_m) - ahead_m


def _gained_after_s(way_m: float, now_mps: float, most_mps: float, gain_mps2: float) -> float:
    """When somebody has gained that way on another who begins with one relative speed, and goes over to another; infinite: never."""
    if most_mps < _HARDLY_MPS:
        return math.inf
    if now_mps >= most_mps:
        return way_m / most_mps
    rising_s = (most_mps - now_mps) / gain_mps2
    while_rising_m = 0.5 * (now_mps + most_mps) * rising_s
    if while_rising_m < way_m:
        return rising_s + (way_m - while_rising_m) / most_mps
    return (-now_mps + math.sqrt(now_mps * now_mps + 2.0 * gain_mps2 * way_m)) / gain_mps2
