"""Which lane has to be reached: one that leads on, or the destination's; and whether there is room in it."""

from __future__ import annotations

import math
from typing import NamedTuple

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side

AHEAD_S, AHEAD_M = 12.0, 60.0  # a lane that ends within so much driving, and at least so far ahead, is left
_FARTHER_M = 30.0  # a lane must lead on by so much farther to be worth a change
_STANDING_M = 2.0  # bumper to bumper in the new lane, and besides
_EASY_GAP_S, _LEAST_GAP_S = 0.8, 0.3  # of the one behind's speed: while there is time, and where the lane is about to end
_CROSSING_S = 2.5  # from now until the body is in the new lane
_OTHER_SPEED_MPS = 2.0  # faster or slower than who is in the way
_HARDLY_MPS = 0.5


class RequiredLane(NamedTuple):
    """The side to change to, and the time gap [s] that is asked for there: less as the lane comes to its end."""

    side: Side
    time_gap_s: float


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
    return RequiredLane(side, _EASY_GAP_S)


def _to_lead_on(situation: Situation, vehicle: Vehicle, lane: int) -> RequiredLane | None:
    road, host = situation.road, situation.host
    if not road.lanes:
        return None
    end = road.lane_ends_m(lane, host.s_m, vehicle.width_m)
    seen_m = max(AHEAD_S * host.speed_mps, AHEAD_M)
    if end > host.s_m + seen_m:
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
    left = min(max((end - host.s_m) / seen_m, 0.0), 1.0)
    return RequiredLane(best, _LEAST_GAP_S + (_EASY_GAP_S - _LEAST_GAP_S) * left)


def in_the_way(situation: Situation, vehicle: Vehicle, choice: RequiredLane) -> Track | None:
    """Who would be too near in the next lane once the host is there, both keeping their speeds; the nearest of them."""
    road, host = situation.road, situation.host
    lane = road.lane_of(host.d_m, host.s_m) + (1 if choice.side is Side.LEFT else -1)
    nearest, least = None, math.inf
    for track in situation.tracks:
        if road.lane_of(track.d_m, track.s_m) != lane:
            continue
        lengths = 0.5 * (track.length_m + vehicle.length_m)
        relative = track.speed_s_mps - host.speed_mps
        now, then = track.s_m - host.s_m, track.s_m - host.s_m + relative * _CROSSING_S
        gap = min(abs(now), abs(then)) - lengths if now * then > 0.0 else -lengths
        following = host.speed_mps if now > 0.0 else track.speed_s_mps
        if gap < _STANDING_M + choice.time_gap_s * max(following, 0.0) and gap < least:
            nearest, least = track, gap
    return nearest


def speed_to_make_room_mps(
    situation: Situation, vehicle: Vehicle, choice: RequiredLane, blocking: Track, follower_mps: float | None
) -> float:
    """Faster, to get before somebody behind where there is room before him; else slower, to let him get ahead, but hardly slower than
    whoever follows the host closely."""
    road, host = situation.road, situation.host
    lane = road.lane_of(blocking.d_m, blocking.s_m)
    ahead = [one for one in situation.tracks if one.s_m > blocking.s_m and road.lane_of(one.d_m, one.s_m) == lane]
    leader = min(ahead, key=lambda one: one.s_m, default=None)
    needed = vehicle.length_m + 2.0 * (_STANDING_M + choice.time_gap_s * max(blocking.speed_s_mps, 0.0))
    room = math.inf if leader is None else leader.s_m - blocking.s_m - 0.5 * (leader.length_m + blocking.length_m)
    if blocking.s_m <= host.s_m and room >= needed:
        return max(situation.wanted_speed_mps, max(blocking.speed_s_mps, host.speed_mps) + _OTHER_SPEED_MPS)
    slower = max(blocking.speed_s_mps - _OTHER_SPEED_MPS, 0.0)
    return slower if follower_mps is None else max(slower, follower_mps - _HARDLY_MPS)
