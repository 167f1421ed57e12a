"""Which lane has to be reached: one that leads on where the own one ends, or the destination's."""

from __future__ import annotations

import math
from typing import NamedTuple

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.lanes.neighbours import in_lane

AHEAD_S, AHEAD_M = 20.0, 60.0  # a lane that ends within so much driving, and at least so far ahead, is left
ADAPTING_S = 12.0  # before a destination speed is adapted to a gap; until then one that comes by itself is taken
_MOST_CHANGES = 3  # to the lane that leads on
_FARTHER_M = 30.0  # a lane must lead on by so much farther to be worth a change


class RequiredLane(NamedTuple):
    """The side to change to, the time [s] until the lane there has to be reached, and where the own lane ends [m] (None: nowhere; where it
    is closed or too narrow already: at the host). A lane that is none to drive in, as one of oncoming traffic, has no end, and is left as
    soon as can be."""

    side: Side
    left_s: float
    end_m: float | None = None
    own_lane_is_undrivable: bool = False

    @property
    def own_lane_ends(self) -> bool:
        return self.end_m is not None or self.own_lane_is_undrivable


def required_lane(situation: Situation, vehicle: Vehicle) -> RequiredLane | None:
    """The side with a lane that leads on where the host's own ends soon, else the side of the destination's lane; None where the own lane
    leads on and is the one to be in, or where nothing leads on farther."""
    lane = situation.host_lane
    return _to_lead_on(situation, vehicle, lane) or _to_the_destination(situation, lane)


def _to_the_destination(situation: Situation, lane: int) -> RequiredLane | None:
    road, host, destination = situation.road, situation.host, situation.destination
    if destination is None or destination.lane is None or destination.lane == lane:
        return None
    side, next_lane = (Side.LEFT, lane + 1) if destination.lane > lane else (Side.RIGHT, lane - 1)
    if not road.goes_on(next_lane, host.s_m, host.speed_mps):
        return None
    left_s = ADAPTING_S if destination.s_m is None else (destination.s_m[1] - host.s_m) / max(host.speed_mps, AHEAD_M / AHEAD_S)
    until_s = math.inf if destination.time_s is None else max(destination.time_s[1] - situation.time_s, 0.0)
    return RequiredLane(side, min(left_s, until_s, ADAPTING_S))


def _to_lead_on(situation: Situation, vehicle: Vehicle, lane: int) -> RequiredLane | None:
    """Towards the lane that leads on farthest; where others lie between, the sooner, the more changes it takes."""
    road, host = situation.road, situation.host
    if not road.lanes:
        return None
    end = road.lane_ends_m(lane, host.s_m, vehicle.width_m)
    soon_m = max(AHEAD_S * host.speed_mps, AHEAD_M)
    if end > host.s_m + _MOST_CHANGES * soon_m:
        return None
    best, changes, farthest = Side.NONE, 1, max(end, host.s_m) + _FARTHER_M
    for side in (Side.LEFT, Side.RIGHT):
        for k in range(1, _MOST_CHANGES + 1):
            next_lane = lane + k * side.sign
            if not road.goes_on(next_lane, host.s_m, host.speed_mps):
                break
            reached = road.lane_ends_m(next_lane, host.s_m, vehicle.width_m)
            if reached > farthest or (best is not Side.NONE and reached == farthest and k < changes):
                best, changes, farthest = side, k, reached
    if best is Side.NONE or end > host.s_m + changes * soon_m:
        return None
    if road.is_for_others(lane):
        return RequiredLane(best, ADAPTING_S, own_lane_is_undrivable=True)
    end = max(end, host.s_m)
    return RequiredLane(best, (end - host.s_m) / (changes * max(host.speed_mps, AHEAD_M / AHEAD_S)), end)


def beside(situation: Situation, side: Side) -> list[Track]:
    """Whose body reaches into the next lane on that side, from behind to ahead."""
    return _from_behind(situation.lane_beside(side), situation)


def next_ahead(situation: Situation, d_m: float) -> Track | None:
    """Who is next ahead of the host in the lane that is there."""
    road, host = situation.road, situation.host
    return next((track for track in _from_behind(road.lane_of(d_m, host.s_m), situation) if track.s_m > host.s_m), None)


def _from_behind(lane: int, situation: Situation) -> list[Track]:
    """Whose body reaches into a lane, from behind to ahead."""
    return sorted(in_lane(lane, situation), key=lambda one: one.s_m)
