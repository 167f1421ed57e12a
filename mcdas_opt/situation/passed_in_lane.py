"""Who is passed within the host's lane: a car that stands half in it, and people on foot or on two wheels at its side."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import BodyKind, Side

_INTRUSION_M = 0.2  # who reaches into the lane by less is in nobody's way
_STANDING_MPS, _STILL_STANDING_MPS = 0.4, 0.8  # the second of who was passed in the cycle before, here and below
_OUTSIDE_M, _STILL_OUTSIDE_M = 0.0, -0.2  # beyond the lane's border: who stands wholly within it stands in a queue
_LEAST_M, _STILL_LEAST_M = 0.5, 0.4  # between the bodies
_WANTED_M = 1.0
_BORDER_M = 0.1  # from the host's body to the lane's other border
_MPS_PER_M = 10.0  # of the distance between the bodies
_SLOWEST_MPS = 3.0
_AHEAD_S, _LEAST_MPS = 8.0, 5.0  # looked ahead, at that speed at least
_ASIDE_MPS = 0.4  # that the host goes aside by, and back
_PERSONS = (BodyKind.PEDESTRIAN, BodyKind.BICYCLE)
_PERSON_LEAST_M = 1.0  # between the bodies, of a person in the lane
_PERSON_CLOSE_M, _ONCOMING_CLOSE_M = 0.7, 0.4  # the same where there is no lane beside; and of one who comes towards the host then
_FOLLOWED_MPS = 2.0  # who goes along so fast may as well be followed
_PERSON_STILL_M = 0.1  # less of each, of who was passed in the cycle before
_PERSON_WANTED_M, _PERSON_NEAR_M = 1.5, 2.5  # who is farther beside the host than the second is in nobody's way
_PERSON_MPS_PER_M2 = 7.0  # 1.4 m at 50 km/h and 2.0 m at 100: the German traffic code (StVO, section 5 (4)) asks for 1.5 and 2
_ALONG_MPS, _STILL_ALONG_MPS = 0.4, 0.6  # a person who moves across the lane faster is on his way into it


@dataclass(frozen=True, slots=True, kw_only=True)
class Passed:
    """One who is passed: the way until the host is beside him [m] (negative: it is), the distance between the bodies then [m]."""

    track: Track
    way_m: float
    gap_m: float

    @property
    def speed_mps(self) -> float:
        """His own along the road; a car's is 0, which stands."""
        return self.track.speed_s_mps if is_person(self.track) else 0.0

    @property
    def most_mps(self) -> float:
        """How fast he is passed."""
        if is_person(self.track):
            return max(self.speed_mps, 0.0) + max(_SLOWEST_MPS, _PERSON_MPS_PER_M2 * max(self.gap_m, 0.0) ** 2)
        return max(_SLOWEST_MPS, _MPS_PER_M * self.gap_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class PassedInLane:
    """Nearest first, and how far to the left of the lane's middle the host drives for them: now, and once it has gone aside [m]."""

    bodies: tuple[Passed, ...] = ()
    offset_m: float = 0.0
    goal_m: float = 0.0

    @property
    def moving_s(self) -> float:
        """How long the host goes aside, or back."""
        return abs(self.goal_m - self.offset_m) / _ASIDE_MPS

    @property
    def ids(self) -> frozenset[str]:
        return frozenset(one.track.id for one in self.bodies)


class _AtTheSide(NamedTuple):
    """Who is at a side of the lane: from its middle to him, the room between him and a host at the other border, the least that there must
    be and how much is wanted [m]."""

    track: Track
    side: Side
    inner_m: float
    room_m: float
    least_m: float
    wanted_m: float


def is_person(track: Track) -> bool:
    """Whether it is somebody without a car around him."""
    return track.kind in _PERSONS


def passing_gap_m(speed_mps: Array, its_mps: Array) -> Array:
    """The distance between the bodies that a speed asks for beside a person who goes along at his."""
    faster = np.maximum(speed_mps - np.maximum(its_mps, 0.0), 0.0)
    return np.asarray(np.sqrt(faster / _PERSON_MPS_PER_M2))


def passed_in_lane(situation: Situation, vehicle: Vehicle, before: PassedInLane | None = None, elapsed_s: float = 0.0) -> PassedInLane:
    """Cars in the host's lane that stand, reach beyond its border, and leave room for the host and half a metre between the bodies; people
    who stand or go along at its side, within it where they leave a little more, or beside it. As far as one offset passes them all. The
    offset changes slowly from what it was `before`, so long ago, or from where the host is."""
    found, goal_m = _found(situation, vehicle, frozenset() if before is None else before.ids)
    bodies = tuple(_past(one, goal_m, situation, vehicle) for one in found)
    if before is None:
        host, road = situation.host, situation.road
        offset_m = min(max(host.d_m - road.lane_centre_m(situation.host_lane, host.s_m), min(goal_m, 0.0)), max(goal_m, 0.0))
    else:
        step_m = _ASIDE_MPS * elapsed_s
        offset_m = min(max(goal_m, before.offset_m - step_m), before.offset_m + step_m)
    return PassedInLane(bodies=bodies, offset_m=offset_m, goal_m=goal_m)


def _found(situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> tuple[list[_AtTheSide], float]:
    """Who is passed, nearest first, and how far to the left of the lane's middle [m]."""
    found: list[_AtTheSide] = []
    right_m, left_m = -math.inf, math.inf  # how far to the left the host drives, at least and at most
    for one in _at_the_side(situation, vehicle, before):
        aside_m = min(one.wanted_m, one.room_m) + 0.5 * vehicle.width_m - one.inner_m
        if one.side is Side.RIGHT:
            least, most = max(right_m, aside_m), left_m
        else:
            least, most = right_m, min(left_m, -aside_m)
        if one.room_m < one.least_m or (least > most and one.least_m > -math.inf):
            break
        if least <= most:
            right_m, left_m = least, most
        found.append(one)
    return found, min(max(0.0, right_m), left_m)


def _at_the_side(situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> Iterator[_AtTheSide]:
    """Who is passed if there is room, nearest first."""
    road, lane = situation.road, situation.host_lane
    for track in sorted(_ahead(situation, vehicle, before), key=attrgetter("s_m")):
        half, away_m = 0.5 * road.lane_width_at(lane, track.s_m), track.d_m - road.lane_centre_m(lane, track.s_m)
        inner_m, outer_m = abs(away_m) - 0.5 * track.across_m, abs(away_m) + 0.5 * track.across_m
        side, again = Side.LEFT if away_m > 0.0 else Side.RIGHT, track.id in before
        room_m, is_in_lane = half + inner_m - _BORDER_M - vehicle.width_m, inner_m <= half - _INTRUSION_M
        if is_person(track):
            least_m = _least_m(track, situation) - (_PERSON_STILL_M if again else 0.0) if is_in_lane else -math.inf
            if inner_m < 0.5 * vehicle.width_m + _PERSON_NEAR_M:
                wanted_m = max(_PERSON_WANTED_M, math.sqrt(situation.host.speed_mps / _PERSON_MPS_PER_M2))
                yield _AtTheSide(track, side, inner_m, room_m, least_m, wanted_m)
        elif is_in_lane and outer_m >= half + (_STILL_OUTSIDE_M if again else _OUTSIDE_M):
            yield _AtTheSide(track, side, inner_m, room_m, _STILL_LEAST_M if again else _LEAST_M, _WANTED_M)


def _least_m(person: Track, situation: Situation) -> float:
    """Where there is no lane beside to pass in, people in the lane are passed closely, and slowly, if they can hardly be followed; who
    comes towards the host cannot be at all."""
    road, lane, s_m = situation.road, situation.host_lane, situation.host.s_m
    if person.speed_s_mps > _FOLLOWED_MPS or any(road.has_lane(one, s_m) and not road.is_for_others(one) for one in (lane - 1, lane + 1)):
        return _PERSON_LEAST_M
    return _ONCOMING_CLOSE_M if person.speed_s_mps < -_ALONG_MPS else _PERSON_CLOSE_M


def _ahead(situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> Iterable[Track]:
    """Cars that stand, and people who do not move across the lane."""
    host = situation.host
    far_m = _AHEAD_S * max(host.speed_mps, _LEAST_MPS)
    for track in situation.tracks:
        again, lengths_m = track.id in before, 0.5 * (track.along_m + vehicle.length_m)
        if not -lengths_m <= track.s_m - host.s_m <= far_m + lengths_m:
            continue
        if is_person(track):
            stays = abs(track.speed_d_mps) <= (_STILL_ALONG_MPS if again else _ALONG_MPS)
        else:
            stays = math.hypot(track.speed_s_mps, track.speed_d_mps) <= (_STILL_STANDING_MPS if again else _STANDING_MPS)
        if stays and track.kind is not BodyKind.MOTORCYCLE:
            yield track


def _past(one: _AtTheSide, aside_m: float, situation: Situation, vehicle: Vehicle) -> Passed:
    return Passed(
        track=one.track,
        way_m=one.track.s_m - situation.host.s_m - 0.5 * (one.track.along_m + vehicle.length_m),
        gap_m=one.inner_m - one.side.sign * aside_m - 0.5 * vehicle.width_m,
    )
