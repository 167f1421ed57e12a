"""Whether the host may go over the line, a little way into the lane of oncoming traffic, to pass somebody at the side of its lane: nobody
else is there until it is back."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.situation.passing_room import is_person, most_mps

MOST_M, STILL_MOST_M = 0.65, 0.7  # of the host's body, over the line; the second for who was passed in the cycle before
_SOON_S, _LEAST_CLOSING_MPS = 5.0, 5.0  # it begins so long before the host is beside him
_BACK_M = 6.0  # beyond him, until the host is back in its lane
_GAINING_MPS2, _FASTER_MPS = 1.0, 3.0  # how the host comes past him; faster than he is by so much, at least
_SPARE_S, _STILL_SPARE_S, _STILL_SPARE_SHARE = 4.0, 0.3, 0.4  # until the next one is there; then so much, and of the time until beside him
_SPARE_M, _STILL_SPARE_M = 0.9, 0.6  # to who drives; half of it to who stands
_MOVING_MPS, _SIGMAS, _SETTLES_S = 1.0, 2.0, 0.5
_UNSEEN_S, _FASTEST_MPS = 1.0, 17.0  # who is not seen yet comes no sooner after the host is back, and at the speed limit, as far as this
_FAR_M, _NEAR_M, _STEP_M = 170.0, 60.0, 5.0  # a radar sees so far ahead, and beside (Delphi ESR: de Ponte Mueller 2017, Sensors 17(2):271)
_NARROW_RAD = math.radians(10.0)
_BEHIND_M = 40.0  # who overtakes the host from so far behind
_TIGHTEST_SHARE, _HARDLY_M = 1.2, 0.15  # of the way that the tightest steering takes; less aside takes none


class _Way(NamedTuple):
    """The host's way past somebody on a side: its edges, to the left of the lane's middle [m], and where [m] and when [s] it is back."""

    side: Side
    right_m: float
    left_m: float
    back_s_m: float
    back_s: float


def may_be_used(side: Side, track: Track, situation: Situation) -> bool:
    """Whether the lane on that side is one of oncoming traffic until beyond somebody, and seen."""
    road, lane, there_m = situation.road, situation.lane_beside(side), track.s_m + 0.5 * track.along_m + _BACK_M
    if not situation.sees_lane(side) or not any(one.lane == lane and one.oncoming for one in road.lanes):
        return False
    return min(road.lane_width_at(lane, situation.host.s_m), road.lane_width_at(lane, there_m)) >= 0.5 * road.lane_width_m


def is_free(track: Track, side: Side, inner_m: float, gap_m: float, situation: Situation, vehicle: Vehicle, *, again: bool) -> bool:
    """Whether the host may pass him over the line on that side of its lane, `gap_m` from his body, which begins `inner_m` from the lane's
    middle; more freely of who was passed in the cycle before, and in any case once it is beside him."""
    until_m = track.s_m - situation.host.s_m - 0.5 * (track.along_m + vehicle.length_m)
    if again and until_m < 0.0:
        return True
    closing_mps = max(situation.host.speed_mps - track.speed_s_mps, _LEAST_CLOSING_MPS)
    way = _way(track, side, inner_m, gap_m, situation, vehicle)
    if until_m > _SOON_S * closing_mps or (not again and until_m < _least_way_m(way, situation, vehicle)):
        return False
    if not again and _needed_sight_m(way, situation) > _sight_m(side, situation):
        return False
    spare_s = _STILL_SPARE_S + _STILL_SPARE_SHARE * until_m / closing_mps if again else _SPARE_S
    spare_m = _STILL_SPARE_M if again else _SPARE_M
    return not any(_is_in_the_way(one, way, spare_s, spare_m, situation, vehicle) for one in situation.tracks if one is not track)


def _way(track: Track, side: Side, inner_m: float, gap_m: float, situation: Situation, vehicle: Vehicle) -> _Way:
    host, its_mps, lengths_m = situation.host, max(track.speed_s_mps, 0.0), 0.5 * (track.along_m + vehicle.length_m)
    right_m, left_m = sorted((side.sign * (gap_m - inner_m), side.sign * (gap_m - inner_m + vehicle.width_m)))
    fastest = max(min(most_mps(track, gap_m), situation.wanted_speed_mps), its_mps + _FASTER_MPS)
    beside_m, passing_m = track.s_m - host.s_m - lengths_m, 2.0 * lengths_m + _BACK_M
    now_mps, passing_mps = max(host.speed_mps - its_mps, 0.0), fastest - its_mps
    if now_mps > passing_mps and beside_m > 0.0:  # it slows down until it is beside him
        back_s = 2.0 * beside_m / (now_mps + passing_mps) + passing_m / passing_mps
    else:
        back_s = _passing_s(max(beside_m + passing_m, 0.0), min(now_mps, passing_mps), passing_mps)
    way_m = max(beside_m + passing_m, 0.0)
    return _Way(side, right_m, left_m, host.s_m + way_m + its_mps * back_s, back_s)


def _needed_sight_m(way: _Way, situation: Situation) -> float:
    """How far ahead somebody at the speed limit would be who is there as the host is back."""
    fastest = min(situation.road.speed_limit_mps, _FASTEST_MPS)
    return way.back_s_m - situation.host.s_m + (way.back_s + _UNSEEN_S) * fastest


def _sight_m(side: Side, situation: Situation) -> float:
    """How far ahead the lane on that side is seen. What the host's sensors see is not known better than of one radar."""
    road, host, lane = situation.road, situation.host, situation.lane_beside(side)
    if road.is_straight:
        return _FAR_M
    along_m = np.arange(0.0, _FAR_M, _STEP_M)
    heading = np.cumsum(road.curvature_at(host.s_m + along_m)) * _STEP_M - host.heading_rad
    ahead_m, aside_m = np.cumsum(np.cos(heading)) * _STEP_M, np.cumsum(np.sin(heading)) * _STEP_M
    aside_m += road.lane_centre_m(lane, host.s_m) - host.d_m
    unseen = (np.abs(np.arctan2(aside_m, ahead_m)) > _NARROW_RAD) & (along_m > _NEAR_M)
    return float(along_m[np.argmax(unseen)]) if unseen.any() else _FAR_M


def _passing_s(way_m: float, now_mps: float, fastest_mps: float) -> float:
    """How long so much way takes, at a speed that rises from what it is to that at most."""
    rising_m = (fastest_mps**2 - now_mps**2) / (2.0 * _GAINING_MPS2)
    if way_m < rising_m:
        return (math.sqrt(now_mps**2 + 2.0 * _GAINING_MPS2 * way_m) - now_mps) / _GAINING_MPS2
    return (fastest_mps - now_mps) / _GAINING_MPS2 + (way_m - rising_m) / fastest_mps


def _least_way_m(way: _Way, situation: Situation, vehicle: Vehicle) -> float:
    """How long before him the host has to go aside, steering to one side and back."""
    host, road = situation.host, situation.road
    aside_m = abs(0.5 * (way.right_m + way.left_m) + road.lane_centre_m(situation.host_lane, host.s_m) - host.d_m)
    return _TIGHTEST_SHARE * math.sqrt(4.0 * max(aside_m - _HARDLY_M, 0.0) * vehicle.wheelbase_m / math.tan(vehicle.steering_max_rad))


def _is_in_the_way(one: Track, way: _Way, spare_s: float, spare_m: float, situation: Situation, vehicle: Vehicle) -> bool:
    """Whether somebody else is there, or will be: who comes towards the host, who crosses, who drives or stands where it comes back, and
    who overtakes it."""
    host, road, lane = situation.host, situation.road, situation.host_lane
    now_m, drives = one.d_m - road.lane_centre_m(lane, one.s_m), abs(one.speed_s_mps) > _MOVING_MPS
    if drives and road.lane_of(one.d_m, one.s_m) == lane + way.side.sign:  # far away it is not known better
        middle_m = road.lane_centre_m(lane + way.side.sign, one.s_m) - road.lane_centre_m(lane, one.s_m)
        now_m = min(now_m, middle_m, key=abs)
    later_m = now_m + one.speed_d_mps * (way.back_s if one.crosses or is_person(one) else _SETTLES_S)
    spare_m = spare_m if drives else 0.5 * spare_m
    reach_m = 0.5 * one.across_m + spare_m + _SIGMAS * math.sqrt(max(float(one.covariance[2, 2]), 0.0))
    if min(now_m, later_m) - reach_m > way.left_m or max(now_m, later_m) + reach_m < way.right_m:
        return False
    lengths_m = 0.5 * (one.along_m + vehicle.length_m)
    if one.s_m >= host.s_m:
        return one.s_m + one.speed_s_mps * (way.back_s + spare_s) - lengths_m < way.back_s_m
    is_in_lane = abs(now_m) < 0.5 * road.lane_width_at(lane, one.s_m)
    return not is_in_lane and (one.s_m > host.s_m - lengths_m or (one.speed_s_mps > _MOVING_MPS and one.s_m > host.s_m - _BEHIND_M))
