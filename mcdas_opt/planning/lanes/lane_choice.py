"""Which lane one wants to be in while nothing presses: past who is slower, and back again; announced before it is done."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request, Side
from mcdas_opt.planning.lanes.neighbours import Neighbour, demanded_braking_mps2, follower_gap_m, neighbours_in

_ANTICIPATION_S = 10.0  # how far ahead somebody slower counts ...
_FREE_S = 20.0  # ... and in a lane that one goes back to
_CLOSING_MPS2 = 1.2  # gentle braking
_STILL_MPS = 0.7  # less of an advantage is enough of a wish that is there already
_SLOWEST_MPS = 3.0  # slower than this nobody changes lanes
_STRAIGHT_RAD = 0.03
_LOOKS = 20  # along the way of a change


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneChoice:
    """The side that is wanted, and for how long it has been [s]. `own_lane` is the lane that the drive began in."""

    own_lane: int | None = None
    side: Side = Side.NONE
    age_s: float = 0.0
    is_announced: bool = False
    is_due: bool = False

    @property
    def resting(self) -> LaneChoice:
        """The same drive's, with nothing wanted."""
        return LaneChoice(own_lane=self.own_lane)


def lane_choice(
    situation: Situation, vehicle: Vehicle, settings: Settings, before: LaneChoice | None = None, elapsed_s: float = 0.0
) -> LaneChoice:
    """What is wanted now, given what was wanted `elapsed_s` ago. A wish that ends for a moment begins anew."""
    manners = settings.manners
    own_lane = None if before is None else before.own_lane
    if own_lane is None:
        own_lane = situation.host_lane
    side = _wanted(situation, vehicle, settings, own_lane, Side.NONE if before is None else before.side)
    if side is Side.NONE:
        return LaneChoice(own_lane=own_lane)
    age_s = before.age_s + elapsed_s if before is not None and before.side is side else 0.0
    begins_s = manners.lingering_s if side is manners.drives_on else 0.0
    announced_s = round(age_s - begins_s, 6)
    due = announced_s >= manners.announced_s
    return LaneChoice(own_lane=own_lane, side=side, age_s=age_s, is_announced=announced_s >= 0.0, is_due=due)


def _wanted(situation: Situation, vehicle: Vehicle, settings: Settings, own_lane: int, before: Side) -> Side:
    """Whose side was wanted `before` is wanted still at a little less advantage: speeds are measured with noise."""
    host, manners = situation.host, settings.manners
    if situation.destination is not None and situation.destination.lane is not None:
        return Side.NONE  # it is said which lane
    if not manners.changes_lanes or situation.request is not Request.DRIVE or host.speed_mps < _SLOWEST_MPS:
        return Side.NONE
    lane = situation.host_lane
    if abs(host.heading_rad) > _STRAIGHT_RAD or _bends(situation, settings):
        return Side.NONE
    here = neighbours_in(lane, situation, vehicle)
    own = _expected_mps(here, situation, settings, _ANTICIPATION_S)
    sides = (manners.inside,) if manners.passes_inside else (manners.inside, manners.drives_on)
    for side in sides:
        there = neighbours_in_open_lane(lane, side, situation, vehicle, settings)
        least_mps = manners.advantage_mps - (_STILL_MPS if side is before else 0.0)
        if there is not None and _expected_mps(there, situation, settings, _ANTICIPATION_S) >= own + least_mps:
            return side
    inside_of_own = (lane > own_lane) if manners.inside is Side.LEFT else (lane < own_lane)
    if not (manners.returns and inside_of_own) and not manners.keeps_outer_lane:
        return Side.NONE
    outer = neighbours_in_open_lane(lane, manners.drives_on, situation, vehicle, settings)
    free = outer is not None and _expected_mps(outer, situation, settings, _FREE_S) >= own - manners.loss_mps
    return manners.drives_on if free else Side.NONE


def _bends(situation: Situation, settings: Settings) -> bool:
    """Whether the road asks for more than half of the lateral acceleration that is comfortable on the way that a lane change takes."""
    host, road = situation.host, situation.road
    if road.is_straight:
        return False
    way_m = host.speed_mps * (settings.manners.announced_s + settings.manners.changing_s)
    sharpest = float(np.abs(road.curvature_at(host.s_m + np.linspace(0.0, way_m, _LOOKS))).max())
    return sharpest * host.speed_mps**2 > 0.5 * settings.comfort.lateral_mps2


def neighbours_in_open_lane(lane: int, side: Side, situation: Situation, vehicle: Vehicle, settings: Settings) -> list[Neighbour] | None:
    """Who is in the next lane, if anybody, where that is open: watched, and with the headway that is asked for ahead and behind; None where
    it is not open."""
    road, host = situation.road, situation.host
    other = lane + side.sign
    seen = situation.sees_lane(side) and situation.coverage.front
    if not (seen and road.leads_on(other, host.s_m, host.speed_mps, vehicle.width_m)):
        return None
    there = neighbours_in(other, situation, vehicle)
    if any(one.gap_m < _asked_m(one, host.speed_mps, settings) for one in there):
        return None
    braking = demanded_braking_mps2(there, host.speed_mps, settings.headway.standstill_m)
    return there if braking <= settings.manners.follower_braking_mps2 else None


def _asked_m(one: Neighbour, host_mps: float, settings: Settings) -> float:
    """The headway of whoever follows, and what gentle braking closes, or the follower has come up by half-way through the change."""
    headway = settings.headway
    if one.is_ahead:
        closing = max(host_mps - one.speed_mps, 0.0)
        return headway.gap_m(host_mps) + closing * closing / (2.0 * _CLOSING_MPS2)
    follower_mps = max(one.speed_mps, one.soon_mps, 0.0)
    closes_m = 0.5 * settings.manners.changing_s * max(follower_mps - host_mps, 0.0)
    safe_m = follower_gap_m(follower_mps, host_mps, headway.time_gap_s, settings.manners.follower_braking_mps2)
    return max(headway.gap_m(follower_mps) + closes_m, safe_m)


def presses(side: Side, situation: Situation, vehicle: Vehicle, time_gap_s: float, braking_mps2: float) -> bool:
    """Whether somebody in the next lane on that side, or the host behind him, would have to brake by more if the host were there."""
    v = situation.host.speed_mps
    for one in neighbours_in(situation.lane_beside(side), situation, vehicle):
        speeds = (v, one.speed_mps) if one.is_ahead else (max(one.speed_mps, one.soon_mps), v)
        if one.gap_m < follower_gap_m(*speeds, time_gap_s, braking_mps2):
            return True
    return False


def _expected_mps(there: Iterable[Neighbour], situation: Situation, settings: Settings, within_s: float) -> float:
    """The speed that a lane lets the host drive: the desired one, or what comes up to who is ahead in that time."""
    kept_m = settings.headway.gap_m(situation.host.speed_mps)
    ahead = (one.speed_mps + max(one.gap_m - kept_m, 0.0) / within_s for one in there if one.is_ahead)
    return min(situation.wanted_speed_mps, *ahead, math.inf)
