"""When a manoeuvre that has begun is given up."""

from __future__ import annotations

import math

from mcdas_opt.domain.settings import LEAST_SHARE, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.planning.lanes.lane_choice import presses
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.lanes.neighbours import CROSSING_S, follower_gap_m, gained_in_crossing_mps, neighbours_in
from mcdas_opt.planning.lanes.required_lane import RequiredLane
from mcdas_opt.situation.passed_in_lane import INTRUSION_M

_UNHURRIED_MPS = 3.0  # who is slower stops within its length, and need not steer out


def is_withdrawn(active: Manoeuvre, situation: Situation, vehicle: Vehicle, settings: Settings, required: RequiredLane | None) -> bool:
    """Whether a lane change that nothing presses is given up, the body being in its lane still: nobody watches the next one any more, or
    somebody has come so near in it that he, or the host, would have to brake harder than manners allow; where the lane has to be reached,
    or the host steers out of what threatens no more, than is comfortable. And whether steering out is given up by a host that drives so
    slowly in its lane that it may as well stop."""
    if active.mode is Mode.CRUISE and active.half_done(situation):
        return False
    if reaches_out_of_its_lane(situation, vehicle):
        return False
    if active.mode is Mode.CRUISE and not situation.sees_lane(active.side):
        return True
    host, time_gap_s, evades = situation.host, settings.headway.time_gap_s, active.mode is not Mode.CRUISE
    if evades and host.speed_mps < _UNHURRIED_MPS:
        return _off_centre_m(situation) < abs(host.d_m - active.target_d_m)
    if evades and active.half_done(situation):
        return False
    if required is not None and required.own_lane_ends and required.side is active.side and _may_speed_up(active.side, situation, vehicle):
        return _presses_a_host_that_speeds_up(active.side, situation, vehicle, settings)
    if evades or (required is not None and required.side is active.side):
        most = settings.comfort.limits(host.speed_mps).braking_mps2
        return presses(active.side, situation, vehicle, LEAST_SHARE * time_gap_s, most)
    return presses(active.side, situation, vehicle, time_gap_s, settings.manners.follower_braking_mps2)


def _may_speed_up(side: Side, situation: Situation, vehicle: Vehicle) -> bool:
    """Whether the next lane lets the host become as fast as those behind in it: whoever is ahead there is no slower than they are."""
    there = neighbours_in(situation.lane_beside(side), situation, vehicle)
    ahead_mps = min((one.speed_mps for one in there if one.is_ahead), default=math.inf)
    return ahead_mps >= max((one.speed_mps for one in there if not one.is_ahead), default=0.0)


def _presses_a_host_that_speeds_up(side: Side, situation: Situation, vehicle: Vehicle, settings: Settings) -> bool:
    """Whether somebody in the next lane, or the host behind him, would have to brake harder than is comfortable, though the host speeds
    up to be as fast as they are."""
    host_mps, time_gap_s = situation.host.speed_mps, LEAST_SHARE * settings.headway.time_gap_s
    most = settings.comfort.limits(host_mps).braking_mps2
    for one in neighbours_in(situation.lane_beside(side), situation, vehicle):
        if one.is_ahead:
            short = follower_gap_m(host_mps, one.speed_mps, time_gap_s, most) - one.gap_m
        else:
            v = one.speed_mps
            soon_mps = min(max(host_mps, v), host_mps + gained_in_crossing_mps(v, situation, settings))
            closes_m = max(v - 0.5 * (host_mps + soon_mps), 0.0) * CROSSING_S
            short = follower_gap_m(v, soon_mps, time_gap_s, most) + closes_m - one.gap_m
        if short > 0.0:
            return True
    return False


def reaches_out_of_its_lane(situation: Situation, vehicle: Vehicle) -> bool:
    """Whether the host's body is in the next lane, too."""
    host, road = situation.host, situation.road
    width_m = road.lane_width_at(situation.host_lane, host.s_m)
    return _off_centre_m(situation) > 0.5 * (width_m - vehicle.width_m) + INTRUSION_M


def _off_centre_m(situation: Situation) -> float:
    host, road = situation.host, situation.road
    return abs(host.d_m - road.lane_centre_m(situation.host_lane, host.s_m))
