"""Who is passed within the host's lane, or a little over its line: a car that stands half in it, people on foot or on bicycles at its side,
and who comes towards the host near it, as a car that is over the line."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.situation.over_the_line import MOST_M, STILL_MOST_M, is_free, may_be_used
from mcdas_opt.situation.passing_room import is_oncoming, may_be_passed, most_mps, room_asked, stands

INTRUSION_M = 0.2  # who reaches into the lane by less is in nobody's way
_OUTSIDE_M, _STILL_OUTSIDE_M = 0.0, -0.35  # beyond the lane's border: a car that stands wholly within it stands in a queue
_BORDER_M = 0.1  # from the host's body to the lane's other border
_ON_SHOULDER_M = 0.6  # so far beyond it for oncoming traffic, where the lane is the last one
_SETTLES_S = 1.0  # so long oncoming traffic goes on towards the host's lane
_AHEAD_S, _LEAST_MPS = 8.0, 5.0  # looked ahead, at that speed at least
_ASIDE_MPS, _HURRIED_ASIDE_MPS = 0.4, 1.0  # that the host goes aside by, and back; for oncoming traffic in its lane
_HURRIED_LEAST_S = 1.5  # a short way aside is not hurried
_WAITING_M = 7.0  # before him, beside the gap at standstill: from there the way leads past him
_FOLLOWED_MPS = 2.0  # who is faster is followed meanwhile
_CLEARLY = 2.5  # standard deviations


@dataclass(frozen=True, slots=True, kw_only=True)
class Passed:
    """One who is passed: at which side, the way until the host is beside him (negative: it is), how far apart the bodies are then [m]."""

    track: Track
    side: Side
    way_m: float
    gap_m: float

    @property
    def stands(self) -> bool:
        """Whether it is a car, which stands."""
        return stands(self.track)

    @property
    def speed_mps(self) -> float:
        """His own along the road; 0 of a car that stands."""
        return 0.0 if self.stands else self.track.speed_s_mps

    @property
    def most_mps(self) -> float:
        """How fast he is passed."""
        return most_mps(self.track, self.gap_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class PassedInLane:
    """Nearest first, and how far to the left of the lane's middle the host drives for them: now, and once it has gone aside [m]; whom it
    would pass next over the line, and waits behind until nobody comes."""

    bodies: tuple[Passed, ...] = ()
    offset_m: float = 0.0
    goal_m: float = 0.0
    aside_mps: float = _ASIDE_MPS
    waits_for: Track | None = None

    @property
    def moving_s(self) -> float:
        """How long the host goes aside, or back."""
        least_s = _HURRIED_LEAST_S if self.aside_mps > _ASIDE_MPS else 0.0
        return max(abs(self.goal_m - self.offset_m) / self.aside_mps, least_s)

    @property
    def waits_s_m(self) -> float:
        """Where the host waits with room to go round him [m]; infinite where it does not, or follows him."""
        one = self.waits_for
        return math.inf if one is None or one.speed_s_mps >= _FOLLOWED_MPS else one.s_m - 0.5 * one.along_m - _WAITING_M

    @property
    def goes_aside(self) -> bool:
        """Whether the host is on its way aside, not yet there."""
        return abs(self.goal_m) > abs(self.offset_m)

    @property
    def ids(self) -> frozenset[str]:
        return frozenset(one.track.id for one in self.bodies)


class _AtTheSide(NamedTuple):
    """Who is at a side of the lane: from its middle to him, the room between him and a host at the other border, the least that there must
    be (minus infinity of who is beside the lane) and how much is wanted [m]; whether the host waits behind him for oncoming traffic."""

    track: Track
    side: Side
    inner_m: float
    room_m: float
    least_m: float
    wanted_m: float
    waits: bool


def passed_in_lane(situation: Situation, vehicle: Vehicle, before: PassedInLane | None = None, elapsed_s: float = 0.0) -> PassedInLane:
    """Whoever is at a side of the host's lane, stands, goes along, or comes towards the host, and leaves the room that is asked for
    (`passing_room`); as far as one offset passes them all. The offset changes slowly from what it was `before`, so long ago, or from where
    the host is."""
    again = frozenset() if before is None else before.ids
    found, goal_m, waits_for = _found(situation, vehicle, again)
    if goal_m != 0.0:
        ids = {one.track.id for one in found}
        found += [one for one in _met(goal_m, situation, vehicle, again) if one.track.id not in ids]
    bodies = tuple(_past(one, goal_m, situation, vehicle) for one in found)
    hurries = any(is_oncoming(one.track) and one.least_m > -math.inf for one in found)
    aside_mps = _HURRIED_ASIDE_MPS if hurries else _ASIDE_MPS
    if before is None:
        host, road = situation.host, situation.road
        offset_m = min(max(host.d_m - road.lane_centre_m(situation.host_lane, host.s_m), min(goal_m, 0.0)), max(goal_m, 0.0))
    else:
        step_m = aside_mps * elapsed_s
        offset_m = min(max(goal_m, before.offset_m - step_m), before.offset_m + step_m)
    return PassedInLane(bodies=bodies, offset_m=offset_m, goal_m=goal_m, aside_mps=aside_mps, waits_for=waits_for)


def _found(situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> tuple[list[_AtTheSide], float, Track | None]:
    """Who is passed, nearest first, how far to the left of the lane's middle [m], and behind whom the host waits."""
    found: list[_AtTheSide] = []
    waits_for: Track | None = None
    right_m, left_m = -math.inf, math.inf  # how far to the left the host drives, at least and at most
    for one in _at_the_side(situation, vehicle, before):
        aside_m = min(one.wanted_m, one.room_m) + 0.5 * vehicle.width_m - one.inner_m
        if one.side is Side.RIGHT:
            least, most = max(right_m, aside_m), left_m
        else:
            least, most = right_m, min(left_m, -aside_m)
        if one.room_m < one.least_m or (least > most and one.least_m > -math.inf):
            waits_for = one.track if one.waits else None
            break
        if least <= most:
            right_m, left_m = least, most
        found.append(one)
    return found, min(max(0.0, right_m), left_m), waits_for


def _at_the_side(situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> Iterator[_AtTheSide]:
    """Who is passed if there is room, nearest first."""
    for track in sorted(_ahead(situation, vehicle, before), key=attrgetter("s_m")):
        side, inner_m, half = _place(track, situation)
        other, again = Side.RIGHT if side is Side.LEFT else Side.LEFT, track.id in before
        free_m = _free_m(other, situation, track.s_m) if is_oncoming(track) else half - _BORDER_M
        asked, is_in_lane = room_asked(track, situation, again=again), inner_m <= half - INTRUSION_M
        if stands(track):
            outside_m = _STILL_OUTSIDE_M if again else _OUTSIDE_M
            if not is_in_lane or inner_m + track.across_m < half + outside_m:
                continue
        elif inner_m >= 0.5 * vehicle.width_m + asked.near_m:
            continue
        room_m, waits = free_m + inner_m - vehicle.width_m, False
        if is_in_lane and not is_oncoming(track):
            room_m, waits = _over_the_line(track, other, inner_m, room_m, situation, vehicle, again=again)
        yield _AtTheSide(
            track=track,
            side=side,
            inner_m=inner_m,
            room_m=room_m,
            least_m=asked.least_m if is_in_lane else -math.inf,
            wanted_m=asked.wanted_m,
            waits=waits,
        )


def _over_the_line(
    track: Track, side: Side, inner_m: float, room_m: float, situation: Situation, vehicle: Vehicle, *, again: bool
) -> tuple[float, bool]:
    """The room beside him [m], over the line at that side where that helps and it is free; whether the host waits for that."""
    least_m = room_asked(track, situation, again=again).least_m
    gap_m = min(room_asked(track, situation, again=False).least_m, room_m + _BORDER_M + (STILL_MOST_M if again else MOST_M))
    if gap_m <= room_m or gap_m < least_m or not may_be_used(side, track, situation):
        return room_m, False
    if is_free(track, side, inner_m, gap_m, situation, vehicle, again=again):
        return gap_m, False
    return room_m, room_m < least_m


def _met(goal_m: float, situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> Iterator[_AtTheSide]:
    """Oncoming traffic in its own lane to which the host, gone aside for somebody else, comes near."""
    for track in _ahead(situation, vehicle, before):
        if is_oncoming(track):
            side, inner_m, _ = _place(track, situation)
            asked, room_m = room_asked(track, situation, again=track.id in before), inner_m - side.sign * goal_m - 0.5 * vehicle.width_m
            if side.sign * goal_m > 0.0 and asked.least_m <= room_m < asked.near_m:
                yield _AtTheSide(track, side, inner_m, room_m, -math.inf, room_m, waits=False)


def _place(track: Track, situation: Situation) -> tuple[Side, float, float]:
    """The side at which somebody is, how far from the lane's middle his body begins, and how wide half of the lane is there [m]."""
    road, lane = situation.road, situation.host_lane
    away_m = track.d_m - road.lane_centre_m(lane, track.s_m)
    side, inner_m = Side.LEFT if away_m > 0.0 else Side.RIGHT, abs(away_m) - 0.5 * track.across_m
    return side, inner_m - _drift_m(track, side), 0.5 * road.lane_width_at(lane, track.s_m)


def _drift_m(track: Track, side: Side) -> float:
    """How far oncoming traffic at that side still comes towards the lane, where it clearly does; and who brakes, until he stands."""
    towards_mps = -side.sign * track.speed_d_mps
    if not is_oncoming(track):
        return 0.5 * max(towards_mps, 0.0) * track.stopping_s
    return towards_mps * _SETTLES_S if towards_mps > _CLEARLY * math.sqrt(max(float(track.covariance[3, 3]), 0.0)) else 0.0


def _free_m(side: Side, situation: Situation, s_m: float) -> float:
    """From the lane's middle to where the host may drive on that side [m]: on the shoulder too, where the lane is the last one."""
    road, lane = situation.road, situation.host_lane
    centre, half = road.lane_centre_m(lane, s_m), 0.5 * road.lane_width_at(lane, s_m)
    if -road.lanes_right <= lane + side.sign <= road.lanes_left:
        return half - _BORDER_M
    edge = road.left_edge_at(s_m) if side is Side.LEFT else road.right_edge_at(s_m)
    return min(max(abs(float(edge) - centre), half), half + _ON_SHOULDER_M) - _BORDER_M


def _ahead(situation: Situation, vehicle: Vehicle, before: frozenset[str]) -> Iterator[Track]:
    """Who may be passed, as far as the host and he come in some seconds."""
    host = situation.host
    for track in situation.tracks:
        coming_mps = 0.0 if stands(track) else max(-track.speed_s_mps, 0.0)
        far_m, lengths_m = _AHEAD_S * max(host.speed_mps + coming_mps, _LEAST_MPS), 0.5 * (track.along_m + vehicle.length_m)
        if -lengths_m <= track.s_m - host.s_m <= far_m + lengths_m and may_be_passed(track, again=track.id in before):
            yield track


def _past(one: _AtTheSide, aside_m: float, situation: Situation, vehicle: Vehicle) -> Passed:
    return Passed(
        track=one.track,
        side=one.side,
        way_m=one.track.s_m - situation.host.s_m - 0.5 * (one.track.along_m + vehicle.length_m),
        gap_m=one.inner_m - one.side.sign * aside_m - 0.5 * vehicle.width_m,
    )
