"""Who stands at the side of the host's lane and leaves room to pass him within it, as a car parked half in the lane does."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

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
_PERSONS = (BodyKind.PEDESTRIAN, BodyKind.BICYCLE, BodyKind.MOTORCYCLE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Passed:
    """One who is passed: the way until the host is beside him [m] (negative: it is), the distance between the bodies then [m]."""

    track: Track
    way_m: float
    gap_m: float

    @property
    def most_mps(self) -> float:
        """How fast he is passed."""
        return max(_SLOWEST_MPS, _MPS_PER_M * self.gap_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class PassedInLane:
    """Nearest first, and how far to the left of the lane's middle the host drives for them: now, and once it has gone aside [m]."""

    cars: tuple[Passed, ...] = ()
    offset_m: float = 0.0
    goal_m: float = 0.0

    @property
    def moving_s(self) -> float:
        """How long the host goes aside, or back."""
        return abs(self.goal_m - self.offset_m) / _ASIDE_MPS

    @property
    def ids(self) -> frozenset[str]:
        return frozenset(one.track.id for one in self.cars)


class _AtTheSide(NamedTuple):
    """Who stands at a side of the lane: from its middle to him, and the room between him and a host at the other border [m]."""

    track: Track
    side: Side
    inner_m: float
    room_m: float


def passed_in_lane(situation: Situation, vehicle: Vehicle, before: PassedInLane | None = None, elapsed_s: float = 0.0) -> PassedInLane:
    """Those in the host's lane who stand, no person among them, reach beyond its border, and leave room for the host and half a metre
    between the bodies; as far as one offset passes them all. The offset changes slowly from what it was `before`, so long ago, or from
    where the host is."""
    found, goal_m = _found(situation, vehicle, frozenset() if before is None else before.ids)
    cars = tuple(_past(one, goal_m, situation, vehicle) for one in found)
    if before is None:
        host, road = situation.host, situation.road
        offset_m = min(max(host.d_m - road.lane_centre_m(situation.host_lane, host.s_m), min(goal_m, 0.0)), max(goal_m, 0.0))
    else:
        step_m = _ASIDE_MPS * elapsed_s
        offset_m = min(max(goal_m, before.offset_m - step_m), before.offset_m + step_m)
    return PassedInLane(cars=cars, offset_m=offset_m, goal_m=goal_m)


def _found(situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> tuple[list[_AtTheSide], float]:
    """Who is passed, nearest first, and how far to the left of the lane's middle [m]."""
    found: list[_AtTheSide] = []
    right_m, left_m = -math.inf, math.inf  # how far to the left the host drives, at least and at most
    for one in _at_the_side(situation, vehicle, before):
        aside_m = min(_WANTED_M, one.room_m) + 0.5 * vehicle.width_m - one.inner_m
        if one.side is Side.RIGHT:
            least, most = max(right_m, aside_m), left_m
        else:
            least, most = right_m, min(left_m, -aside_m)
        if one.room_m < (_STILL_LEAST_M if one.track.id in before else _LEAST_M) or least > most:
            break
        right_m, left_m = least, most
        found.append(one)
    return found, min(max(0.0, right_m), left_m)


def _at_the_side(situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> Iterator[_AtTheSide]:
    """Who stands in the lane and beyond its border, nearest first."""
    road, lane = situation.road, situation.host_lane
    for track in sorted(_standing_ahead(situation, vehicle, before), key=attrgetter("s_m")):
        half, away_m = 0.5 * road.lane_width_at(lane, track.s_m), track.d_m - road.lane_centre_m(lane, track.s_m)
        inner_m, outer_m = abs(away_m) - 0.5 * track.across_m, abs(away_m) + 0.5 * track.across_m
        outside_m = _STILL_OUTSIDE_M if track.id in before else _OUTSIDE_M
        if inner_m <= half - _INTRUSION_M and outer_m >= half + outside_m:
            side = Side.LEFT if away_m > 0.0 else Side.RIGHT
            yield _AtTheSide(track, side, inner_m, half + inner_m - _BORDER_M - vehicle.width_m)


def _standing_ahead(situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> Iterable[Track]:
    host = situation.host
    far_m = _AHEAD_S * max(host.speed_mps, _LEAST_MPS)
    for track in situation.tracks:
        standing_mps = _STILL_STANDING_MPS if track.id in before else _STANDING_MPS
        lengths_m = 0.5 * (track.along_m + vehicle.length_m)
        is_near = -lengths_m <= track.s_m - host.s_m <= far_m + lengths_m
        if is_near and math.hypot(track.speed_s_mps, track.speed_d_mps) <= standing_mps and track.kind not in _PERSONS:
            yield track


def _past(one: _AtTheSide, aside_m: float, situation: Situation, vehicle: Vehicle) -> Passed:
    return Passed(
        track=one.track,
        way_m=one.track.s_m - situation.host.s_m - 0.5 * (one.track.along_m + vehicle.length_m),
        gap_m=one.inner_m - one.side.sign * aside_m - 0.5 * vehicle.width_m,
    )
