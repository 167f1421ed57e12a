"""Keeping the lane: as is comfortable, braking behind the front car, or to a stop."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.track import Track
from mcdas_opt.domain.variant import Variant
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.front.front_braking import stopping_mps2
from mcdas_opt.planning.front.headway import ORDINARY_MPS2
from mcdas_opt.planning.lanes.gap import Gap
from mcdas_opt.planning.lanes.neighbours import known_acceleration_mps2, reaches_into_lane_at
from mcdas_opt.planning.proposals.comfortable_speed import comfortable_speed
from mcdas_opt.planning.proposals.expected_followers import expected_followers
from mcdas_opt.reference.offset_path import OffsetPath
from mcdas_opt.situation.roles import gap_m

BRAKE = "brake"  # of whatever brakes in the lane, however hard: the basic candidate too
BRAKE_BEHIND = "brake-behind"
HARDER = 1.15  # than what is needed by now: it is begun with some jerk
_SLOWER_MPS = 2.0  # than the front car, until the distance is there
_LEAST_ROOM_M = 1.0
_SLOWEST_MPS = 3.0  # a way aside is as long as at this speed, at least
_AT_ONCE_M = 0.2  # from the middle of the lane, that is returned from at once
_TURNING_MPS2 = 2.5  # across, by who heads away from it
_LEAST_SHARE = 0.05  # of a path's amplitude: a logistic curve has no end


def keep_path(cycle: Cycle) -> OffsetPath:
    """The centre of the lane that holds the body centre, or beside it where the destination near ahead is there, or somebody is passed:
    gradually."""
    host, passed = cycle.situation.host, cycle.passed_in_lane
    path = OffsetPath(start_s_m=host.s_m, start_d_m=cycle.kept_d_m, amplitude_m=0.0, a_per_m=-0.1, b=50.0)
    if passed.goal_m == passed.offset_m:
        return path
    way_m = passed.moving_s * max(host.speed_mps, _SLOWEST_MPS)
    return replace(path, amplitude_m=passed.goal_m - passed.offset_m, a_per_m=-2.0 * math.log(path.b) / way_m)


def _gradually(path: OffsetPath, cycle: Cycle) -> OffsetPath:
    """The same from a host that is far from it, as where a lane change is given up between the lanes: approached along a sigmoid through
    where the host is, as it heads, or through where it comes to if it heads away, and as slowly as lanes are changed."""
    host, b = cycle.situation.host, path.b
    off_m, across_mps = host.d_m - path.start_d_m, host.speed_mps * math.sin(host.heading_rad)
    if off_m * across_mps > 0.0:
        off_m += across_mps * abs(across_mps) / (2.0 * _TURNING_MPS2)
    beyond_m = math.copysign(max(abs(off_m) - _AT_ONCE_M, 0.0), off_m)
    if beyond_m == 0.0 or path.amplitude_m != 0.0:
        return path
    steepness = 2.0 * math.log(b) / (cycle.settings.manners.changing_s * max(host.speed_mps, _SLOWEST_MPS))
    share = min(max(-math.tan(host.heading_rad) / (beyond_m * steepness), _LEAST_SHARE), 1.0 - _LEAST_SHARE)
    amplitude = -beyond_m / (1.0 - share)
    return replace(
        path,
        start_s_m=host.s_m - (math.log(b) + math.log(share / (1.0 - share))) / steepness,
        start_d_m=path.start_d_m - amplitude,
        amplitude_m=amplitude,
        a_per_m=-steepness,
    )


def keep_lane(cycle: Cycle, mode: Mode, towards: Gap | None = None) -> Proposed:
    """Nothing threatens: keep the lane at the desired speed, or such that the host comes beside a gap in the next one, but to a stop where
    nobody watches ahead; asked to park, stand until `park` takes over."""
    situation, path = cycle.situation, _gradually(keep_path(cycle), cycle)
    wanted = situation.wanted_speed_mps if towards is None else min(max(situation.wanted_speed_mps, towards.fastest_mps), cycle.limit_mps)
    wanted = wanted if situation.coverage.front else min(wanted, situation.host.speed_mps)
    wanted = 0.0 if mode is Mode.PARK else wanted
    goal, speeds = comfortable_speed(cycle, wanted, path.target_d_m, towards.ahead if towards is not None and towards.is_slower else None)
    return Proposed(
        name="keep",
        mode=mode,
        side=Side.NONE,
        path=path,
        speed_mps=goal,
        speeds_mps=speeds,
        is_comfortable=True,
        relies_on_followers=True,
        keeps_room_behind=cycle.attentive_follower is None and not (cycle.front_gap.is_too_near and expected_followers(cycle)),
    )


def stop_in_lane(cycle: Cycle) -> Proposed:
    """Behind somebody who brakes as hard as the road allows: as hard as he."""
    return Proposed(name=BRAKE, mode=Mode.BRAKE, side=Side.NONE, path=keep_path(cycle), speed_mps=0.0)


def brake_behind(cycle: Cycle) -> Proposed | None:
    """Behind the front car and whoever comes in ahead, and harder than is comfortable: a little more than it takes to stop behind them
    where they brake, or to be slower than they are; None without anybody."""
    situation, horizon_s = cycle.situation, float(cycle.settings.grid.times_s[-1])
    fronts = [track for track in situation.tracks if track.id == cycle.assessment.front_id or _comes_in(track, cycle)]
    if not fronts:
        return None
    host_mps, needed, slowest = situation.host.speed_mps, 0.0, math.inf
    for front in fronts:
        front_mps, braking = max(front.speed_s_mps, 0.0), -known_acceleration_mps2(front)
        room_m = max(gap_m(front, situation.host, cycle.vehicle) - cycle.settings.headway.standstill_m, _LEAST_ROOM_M)
        needed = max(needed, stopping_mps2(host_mps, front_mps, braking, room_m))
        slowest = min(slowest, max(front_mps - max(braking, 0.0) * horizon_s - _SLOWER_MPS, 0.0))
    rate = min(max(HARDER * needed, ORDINARY_MPS2), available_mps2(cycle.vehicle, situation.road.friction)[0])
    speeds = np.maximum(host_mps - rate * cycle.settings.grid.times_s, min(slowest, host_mps))
    return Proposed(
        name=BRAKE_BEHIND,
        mode=Mode.BRAKE,
        side=Side.NONE,
        path=keep_path(cycle),
        speed_mps=float(speeds[-1]),
        speeds_mps=speeds,
        relies_on_followers=True,
        keeps_room_behind=not expected_followers(cycle),
    )


def _comes_in(track: Track, cycle: Cycle) -> bool:
    """Whether somebody ahead is predicted to change into the host's lane."""
    situation, changing = cycle.situation, Variant.CHANGING.of(track.id)
    body = next((one for one in cycle.prediction.bodies if one.id == changing), None)
    if body is None or track.s_m <= situation.host.s_m:
        return False
    there_m = float(body.at(cycle.settings.grid.times_s[-1:]).d_m[0])
    return reaches_into_lane_at(cycle.lane_centre_m, track.moved_to(track.s_m, there_m), situation.road)
