"""How fast the host drives at which time while nothing threatens: towards its speed, and slowly enough for the bends ahead."""

from __future__ import annotations

import math
from dataclasses import replace
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.comfort import GRIP_SHARE, ComfortSettings
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.front.headway import ORDINARY_MPS2, asked_time_gap_s
from mcdas_opt.planning.lanes.gap import SLOWER_MPS
from mcdas_opt.planning.lanes.merging_gap import least_time_gap_s, matched_time_gap_s, merging_time_gap_s
from mcdas_opt.planning.lanes.neighbours import known_acceleration_mps2, reaches_into_lane_at
from mcdas_opt.planning.proposals.yielding import yielding
from mcdas_opt.reference.arrival import comes_late
from mcdas_opt.reference.speed_profile import (
    AS_HARD,
    BEHIND_MPS2,
    CLOSING_S,
    STOPPING_MPS2,
    FrontCar,
    SpeedProfile,
    profile_ahead,
    speeds_along,
)
from mcdas_opt.situation.attentive_followers import line_ahead_m, waits_at_a_line
from mcdas_opt.situation.passed_in_lane import Passed
from mcdas_opt.tracking.prediction import CHANGE_MPS, CHANGE_SIGMAS

_HURRIED_MPS2, _HURRIED_SHARE = 3.0, 0.35  # across in bends, where the destination is missed otherwise, and of what the road gives
_HURRIED_BRAKING_MPS2 = 2.5  # before them, then
_LEVELS = 5  # of hurry
_STANDING_MPS = 0.4
_PASSING_MPS2, _LEAST_WAY_M = 0.8, 1.0  # slowing down for who stands at the lane's side is begun when it takes so much
_ASIDE_MPS2 = 1.5  # gaining speed while the host goes aside for somebody
_SLOWER_MPS = 1.0  # than a front car that brakes
_CLOSED_UP_M = 1.5  # beyond the gap at standstill: nobody drives on for so little
_BEFORE_A_LINE_M = 1.0  # beside the gap at standstill
_FADING_S, _BRAKING_FADES_S = 1.0, 2.0


class ComfortableSpeed(NamedTuple):
    """The speed to arrive at [m/s], and the speed at each node of the grid on the way there."""

    goal_mps: float
    speeds_mps: Array


def comfortable_speed(
    cycle: Cycle, towards_mps: float, d_m: float, follows: Track | None = None, *, evades: bool = False
) -> ComfortableSpeed:
    """Along the offset d: gently towards a speed, behind somebody who is let ahead, and no faster than the road's bends, the lane's end and
    what is known of the road ahead allow within the horizon. Who stands behind a front car that stands stays where it is. Who `evades`
    follows nobody in the lane that it leaves: not to meet him is left to the optimiser."""
    times_s, comfort, profile = cycle.settings.grid.times_s, cycle.settings.comfort, bends_ahead(cycle, d_m, _stops_within_m(cycle, d_m))
    host_mps = cycle.situation.host.speed_mps
    towards_mps = 0.0 if _stands(cycle) else towards_mps
    grip_mps2, late = cycle.situation.road.grip_mps2, comfort.late_braking_mps2
    rising = comfort.rising_mps2(host_mps, grip_mps2)
    if cycle.passed_in_lane.goes_aside:
        rising = min(rising, _ASIDE_MPS2)
    if cycle.hurries_to_merge:
        rising, late = min(rising / comfort.share, GRIP_SHARE * grip_mps2), max(late, comfort.limits(host_mps).braking_mps2)
    speeds = speeds_along(
        profile,
        host_mps,
        towards_mps,
        times_s,
        rising_mps2=rising,
        falling_mps2=ORDINARY_MPS2,
        late_mps2=late,
        behind_mps2=comfort.late_braking_mps2 if cycle.front_gap.is_won_back else BEHIND_MPS2,
        fronts=_fronts(cycle, (d_m,) if evades else (cycle.lane_centre_m, d_m)) + ([] if follows is None else [_let_ahead(cycle, follows)]),
    )
    if not evades:
        speeds = np.minimum(speeds, _behind_who_brakes(cycle))
    for one in yielding(cycle, d_m):
        speeds = np.minimum(speeds, one.speeds_mps)
    for passed in cycle.passed_in_lane.bodies:
        speeds = np.minimum(speeds, _past(passed, host_mps, times_s, comfort))
    if profile is None:
        return ComfortableSpeed(towards_mps, speeds)
    way_m = np.zeros(times_s.size)
    np.cumsum(speeds[:-1] * (times_s[1:] - times_s[:-1]), out=way_m[1:])
    return ComfortableSpeed(min(towards_mps, float(profile.at(profile.start_s_m + way_m).min())), speeds)


def _behind_who_brakes(cycle: Cycle) -> Array | float:
    """How fast at most [m/s] behind a front car that asks for more than the gentlest braking: braking a little harder than it takes, as far
    as is comfortable, to no less than his own speed."""
    front = cycle.situation.track(cycle.assessment.front_id)
    if front is None or cycle.front_braking.stopping_mps2 <= BEHIND_MPS2 or _leaves(front, cycle.lane_centre_m, cycle):
        return math.inf
    times_s, host_mps = cycle.settings.grid.times_s, cycle.situation.host.speed_mps
    rate = min(AS_HARD * cycle.front_braking.stopping_mps2, cycle.settings.comfort.limits(host_mps).braking_mps2)
    its_mps = np.maximum(front.speed_s_mps + min(front.acceleration_s_mps2, 0.0) * times_s - _SLOWER_MPS, 0.0)
    return np.asarray(np.maximum(host_mps - rate * times_s, np.minimum(its_mps, host_mps)))


def _past(passed: Passed, host_mps: float, times_s: Array, comfort: ComfortSettings) -> Array | float:
    """How fast at most [m/s] towards somebody at the lane's side: as slow beside him as the distance between the bodies asks."""
    most, its_mps = passed.most_mps, passed.speed_mps
    needed = (max(host_mps - its_mps, 0.0) ** 2 - (most - its_mps) ** 2) / (2.0 * max(passed.way_m, _LEAST_WAY_M))
    if needed < _PASSING_MPS2:
        return math.inf
    hardest = comfort.limits(host_mps).braking_mps2 if not passed.stands else ORDINARY_MPS2
    return np.asarray(np.maximum(host_mps - min(AS_HARD * needed, hardest) * times_s, most))


def _fronts(cycle: Cycle, lanes_m: tuple[float, ...]) -> list[FrontCar]:
    """Who is next ahead in lanes around these centres, and does not leave them; and whoever must not be passed on the wrong side of the
    last of them."""
    host, road, vehicle, times_s = cycle.situation.host, cycle.situation.road, cycle.vehicle, cycle.settings.grid.times_s
    manners, passed, found = cycle.settings.manners, cycle.passed_in_lane.ids, []
    ahead = [
        (track, track.s_m - host.s_m - 0.5 * (track.along_m + vehicle.length_m))
        for track in cycle.situation.tracks
        if not track.crosses and track.id not in passed
    ]
    for centre in dict.fromkeys(lanes_m):
        there = [
            one
            for one in ahead
            if one[0].s_m > host.s_m and reaches_into_lane_at(centre, one[0], road) and not _leaves(one[0], centre, cycle)
        ]
        if there:
            front, room_m = min(there, key=itemgetter(1))
            speeds, way = _going_on(front, times_s)
            gaps = asked_time_gap_s(room_m + way, speeds, host.speed_mps, times_s, cycle.front_gap.headway)
            found.append(FrontCar(room_m + way - cycle.front_gap.headway.standstill_m, speeds, gaps))
    if manners.passes_inside and not _leaves_an_ending_lane(cycle):
        lane, sign = road.lane_of(lanes_m[-1], host.s_m), manners.inside.sign
        inner = lanes_m[-1] + sign * 0.5 * (road.lane_width_at(lane, host.s_m) + road.lane_width_at(lane + sign, host.s_m))
        for track, room_m in ahead:
            if room_m > 0.0 and track.speed_s_mps > manners.queue_mps and reaches_into_lane_at(inner, track, road):
                speeds, way = _going_on(track, times_s)
                found.append(FrontCar(room_m + way, speeds, np.zeros_like(times_s)))
    return found


def _leaves_an_ending_lane(cycle: Cycle) -> bool:
    """Whether the host's lane ends and the inner one leads on: on its way out of it, it may pass whoever is there."""
    required = cycle.required_lane
    return required is not None and required.own_lane_ends and required.side is cycle.settings.manners.inside


def _leaves(track: Track, centre_m: float, cycle: Cycle) -> bool:
    """Whether it clearly moves out of the lane around that centre, and is out of it once that has faded: not to meet it until then is left
    to the optimiser."""
    fastest = max(CHANGE_MPS, CHANGE_SIGMAS * math.sqrt(max(float(track.covariance[3, 3]), 0.0)))
    if abs(track.speed_d_mps) < fastest or track.speed_d_mps * (track.d_m - centre_m) <= 0.0:
        return False
    settled_m = track.d_m + track.speed_d_mps * cycle.settings.prediction.lateral_fade_s
    return not reaches_into_lane_at(centre_m, track.moved_to(track.s_m, settled_m), cycle.situation.road)


def _let_ahead(cycle: Cycle, track: Track) -> FrontCar:
    """Somebody in another lane, behind whom a gap is opened at once; before a lane's end one that leaves room for who follows him, by a
    host that is not much slower than they are."""
    host, headway, times_s, gap = cycle.situation.host, cycle.settings.headway, cycle.settings.grid.times_s, cycle.gap
    speeds, way = _going_on(track, times_s)
    room_m = track.s_m - host.s_m - 0.5 * (track.length_m + cycle.vehicle.length_m) - headway.standstill_m
    time_gap_s = headway.time_gap_s
    if gap is not None and gap.ahead is track and cycle.required_lane is not None and cycle.required_lane.own_lane_ends:
        shared_s = merging_time_gap_s(gap, host.speed_mps, cycle.vehicle, headway)
        matched_s = matched_time_gap_s(room_m, host.speed_mps, max(track.speed_s_mps, 0.0))
        time_gap_s = matched_s if least_time_gap_s(headway) <= matched_s < shared_s else shared_s
        room_m = max(room_m, time_gap_s * host.speed_mps - CLOSING_S * SLOWER_MPS)
    return FrontCar(room_m + way, speeds, np.full_like(times_s, time_gap_s))


def _going_on(track: Track, times_s: Array) -> tuple[Array, Array]:
    """(speeds [m/s], way [m]) of somebody whose acceleration, as far as it is known, fades."""
    known = known_acceleration_mps2(track)
    fading_s = _BRAKING_FADES_S if known < 0.0 else _FADING_S
    speeds = np.maximum(track.speed_s_mps + known * fading_s * -np.expm1(-times_s / fading_s), 0.0)
    way = np.zeros(times_s.size)
    np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * (times_s[1:] - times_s[:-1]), out=way[1:])
    return speeds, way


def _stands(cycle: Cycle) -> bool:
    """Whether the host stands, and stays: behind somebody who stands, or at its stop line."""
    assessment, front_mps, host_mps = cycle.assessment, cycle.assessment.front_speed_mps, cycle.situation.host.speed_mps
    if host_mps >= _STANDING_MPS:
        return False
    closed_up_m = cycle.settings.headway.standstill_m + _CLOSED_UP_M
    at_the_line = waits_at_a_line(cycle.situation, cycle.vehicle) and _end_ahead_m(cycle, cycle.situation.host.d_m) < _CLOSED_UP_M
    return at_the_line or (front_mps is not None and abs(front_mps) < _STANDING_MPS and assessment.front_gap_m < closed_up_m)


def bends_ahead(cycle: Cycle, d_m: float, stops_m: float = math.inf) -> SpeedProfile | None:
    """What the road's bends, and lower speed limits ahead, allow along the offset d from where the host is, which stops within so much way:
    in comfort, and as much less comfort as brings the host to its destination in time."""
    situation, comfort = cycle.situation, cycle.settings.comfort
    fastest, limits = max(situation.host.speed_mps, situation.wanted_speed_mps), _limits_ahead(cycle, d_m)
    stopping = comfort.late_braking_mps2 if cycle.hurries_to_merge else STOPPING_MPS2
    found = profile_ahead(situation.road, situation.host.s_m, d_m, fastest, comfort, stops_m, limits, stopping)
    if found is None or not _comes_late(found, cycle):
        return found
    given = _HURRIED_SHARE * GRAVITY_MPS2 * situation.road.friction
    most = max(min(_HURRIED_MPS2, given), comfort.lateral_mps2)
    braking = max(min(_HURRIED_BRAKING_MPS2, comfort.late_braking_mps2, given), comfort.bend_braking_mps2)
    for share in np.linspace(0.0, 1.0, _LEVELS)[1:].tolist():
        hurried = replace(
            comfort,
            lateral_mps2=comfort.lateral_mps2 + share * (most - comfort.lateral_mps2),
            bend_braking_mps2=comfort.bend_braking_mps2 + share * (braking - comfort.bend_braking_mps2),
        )
        found = profile_ahead(situation.road, situation.host.s_m, d_m, fastest, hurried, stops_m, limits)
        if found is None or not _comes_late(found, cycle):
            break
    return found


def _limits_ahead(cycle: Cycle, d_m: float) -> list[tuple[float, float]]:
    """Of the lane at the offset d: from where on, and how fast one may be there at most."""
    road, s_m = cycle.situation.road, cycle.situation.host.s_m
    if not road.lanes:
        return []
    return [(s, (1.0 + cycle.settings.speed_limit_excess) * mps) for s, mps in road.limits_from(road.lane_of(d_m, s_m), s_m)[1:]]


def _comes_late(profile: SpeedProfile, cycle: Cycle) -> bool:
    situation, comfort = cycle.situation, cycle.settings.comfort
    rising_mps2 = comfort.rising_mps2(situation.host.speed_mps, situation.road.grip_mps2)
    return comes_late(situation.destination, situation.host, situation.time_s, profile, situation.wanted_speed_mps, rising_mps2)


def _stops_within_m(cycle: Cycle, d_m: float) -> float:
    """The way to where its lane ends, or is not known to be free where nobody watches ahead."""
    blind, host = cycle.observed.blind_ahead, cycle.situation.host
    if blind is None or not blind.slows:
        return _end_ahead_m(cycle, d_m)
    free_m = blind.free_to_m - host.s_m - 0.5 * cycle.vehicle.length_m - cycle.settings.headway.standstill_m
    return min(_end_ahead_m(cycle, d_m), max(free_m, 0.0))


def _end_ahead_m(cycle: Cycle, d_m: float) -> float:
    """The way to where a host along the offset d stops before its lane ends, which one that is none to drive in does nowhere, or before
    the line at which it has to wait, or behind somebody whom it passes once nobody comes."""
    host, road, vehicle = cycle.situation.host, cycle.situation.road, cycle.vehicle
    line_m = line_ahead_m(cycle.situation, vehicle)
    front_m, lane = host.s_m + 0.5 * vehicle.length_m, road.lane_of(d_m, host.s_m)
    end = math.inf if road.is_for_others(lane) else road.lane_ends_m(lane, host.s_m, vehicle.width_m)
    if line_m is not None:
        end = min(end, line_m - _BEFORE_A_LINE_M)
    if lane == cycle.situation.host_lane:
        end = min(end, cycle.passed_in_lane.waits_s_m)
    return max(end - front_m - cycle.settings.headway.standstill_m, 0.0)
