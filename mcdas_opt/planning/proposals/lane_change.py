"""Changing lanes: begun because it is wanted or required, gone on with, or gone on into the lane beyond."""

from __future__ import annotations

import math
from dataclasses import replace

from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.manoeuvres.kinds import STEERABLE_MPS
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.lanes.required_lane import RequiredLane, next_ahead
from mcdas_opt.planning.lanes.withdrawal import reaches_out_of_its_lane
from mcdas_opt.planning.proposals.comfortable_speed import comfortable_speed
from mcdas_opt.planning.proposals.unwatched import unwatched
from mcdas_opt.reference.offset_path import OffsetPath

_ARRIVING_SHARE = 0.6  # of the time that is left to a destination: then its lane lets the host come there in time
_LEAST_SHARE = 0.1  # of a path's amplitude: a logistic curve has no end
_DUE_S = 8.0  # a lane that has to be reached so soon is gone on to without settling in the one between


def go_on(active: Manoeuvre) -> Proposed:
    """A manoeuvre once begun goes on along its own path."""
    return Proposed(
        name=active.side.value,
        mode=Mode.EVADE,
        side=active.side,
        path=active.path,
        speed_mps=active.speed_mps,
        manoeuvre=active,
    )


def go_on_unpressed(cycle: Cycle, active: Manoeuvre) -> Proposed:
    """The same where nothing threatens any more: slowly enough for the bends ahead, and for the headway in the lane that is changed to; at
    the speed that the destination asks for by now, where there is one, but no slower past somebody. Once it is in both lanes, followers
    in them are expected to brake as if it kept its lane: there is no way back that asks less of anybody."""
    situation, towards_mps, evades = cycle.situation, active.speed_mps, active.mode is not Mode.CRUISE
    follows = None if evades else next_ahead(situation, active.target_d_m)
    if situation.destination is not None:
        towards_mps = max(situation.wanted_speed_mps, active.speed_mps if evades else 0.0)
    towards_mps = 0.0 if cycle.slows_blindly else towards_mps
    goal, speeds = comfortable_speed(cycle, towards_mps, active.target_d_m, follows, evades=evades)
    return replace(
        go_on(active),
        mode=active.mode,
        speed_mps=goal,
        speeds_mps=speeds,
        is_comfortable=True,
        relies_on_followers=reaches_out_of_its_lane(situation, cycle.vehicle),
    )


def change_lanes(cycle: Cycle) -> Proposed | None:
    """Into the lane that is wanted, once that has been announced, as slowly as a person does it; None where none is due, or somebody is
    passed at that side."""
    choice = cycle.observed.lane_choice
    if not choice.is_due or any(one.side is choice.side for one in cycle.passed_in_lane.bodies):
        return None
    return _unhurried(cycle, choice.side)


def change_to_required(cycle: Cycle, required: RequiredLane) -> Proposed | None:
    """The same because the lane has to be reached, sooner where it has to be soon; None where nobody watches that side, or the car
    stands in a lane that leads on."""
    situation = cycle.situation
    stands = situation.host.speed_mps < STEERABLE_MPS
    if unwatched(situation, required.side) or (stands and not required.own_lane_ends):
        return None
    changing_s = cycle.settings.manners.changing_s
    within_s = required.left_s - 1.0 if required.own_lane_ends else min(required.left_s - 1.0, _ARRIVING_SHARE * required.left_s)
    return _unhurried(cycle, required.side, min(changing_s, max(within_s, 0.5 * changing_s)))


def change_on(cycle: Cycle, required: RequiredLane, active: Manoeuvre) -> Proposed | None:
    """A lane change that is half done goes on into the lane beyond, because that has to be reached soon: along one path through where the
    host is, as it heads now. None where it is not so, or the car stands."""
    situation, sigmoid = cycle.situation, cycle.settings.sigmoid
    host, road = situation.host, situation.road
    if active.mode is not Mode.CRUISE or active.side is not required.side or required.left_s > _DUE_S or not active.half_done(situation):
        return None
    if unwatched(situation, required.side) or host.speed_mps < STEERABLE_MPS:
        return None
    beside = situation.lane_beside(required.side)
    target, begun_d_m = road.lane_centre_m(beside, host.s_m), active.path.start_d_m
    amplitude = target - begun_d_m
    share = min(max((host.d_m - begun_d_m) / amplitude, _LEAST_SHARE), 1.0 - _LEAST_SHARE)
    slope = math.tan(host.heading_rad) / (amplitude * share * (1.0 - share))
    way_m = 2.0 * max(host.speed_mps, sigmoid.speed_floor_mps) * cycle.settings.manners.changing_s
    steepness = min(max(slope, 2.0 * math.log(sigmoid.b) / way_m), 4.0 * math.log(sigmoid.b) / way_m)
    path = OffsetPath(
        start_s_m=host.s_m - (math.log(sigmoid.b) + math.log(share / (1.0 - share))) / steepness,
        start_d_m=begun_d_m,
        amplitude_m=amplitude,
        a_per_m=-steepness,
        b=sigmoid.b,
    )
    further = Manoeuvre(side=required.side, path=path, target_d_m=target, speed_mps=situation.wanted_speed_mps, mode=Mode.CRUISE)
    return go_on_unpressed(cycle, further)


def _unhurried(cycle: Cycle, side: Side, changing_s: float | None = None) -> Proposed:
    situation, sigmoid = cycle.situation, cycle.settings.sigmoid
    host, road = situation.host, situation.road
    way_m = max(host.speed_mps, sigmoid.speed_floor_mps) * (changing_s or cycle.settings.manners.changing_s)
    beside = situation.lane_beside(side)
    target = road.lane_centre_m(beside, host.s_m if road.has_lane(beside, host.s_m) else host.s_m + way_m)
    path = OffsetPath(
        start_s_m=host.s_m,
        start_d_m=host.d_m,
        amplitude_m=target - host.d_m,
        a_per_m=-2.0 * math.log(sigmoid.b) / way_m,
        b=sigmoid.b,
    )
    wanted = situation.wanted_speed_mps
    return go_on_unpressed(cycle, Manoeuvre(side=side, path=path, target_d_m=target, speed_mps=wanted, mode=Mode.CRUISE))
