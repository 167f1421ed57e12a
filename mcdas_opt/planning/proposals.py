"""The candidate manoeuvres of a situation, as proposals: what to aim at, and from which guess."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.variant import Variant
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.manoeuvres.kinds import best_of_kind, next_lane_m
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.comfortable_speed import comfortable_speed
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.expected_followers import expected_followers
from mcdas_opt.planning.gap import Gap
from mcdas_opt.planning.headway import ORDINARY_MPS2
from mcdas_opt.planning.lane_choice import known_acceleration_mps2, reaches_into
from mcdas_opt.planning.manoeuvre import Manoeuvre
from mcdas_opt.planning.required_lane import RequiredLane, next_ahead
from mcdas_opt.planning.sound_proposals import sound_proposals
from mcdas_opt.planning.withdrawal import reaches_out_of_its_lane
from mcdas_opt.reference.offset_path import OffsetPath, corrected

STOP_IN_LANE = "brake"
BRAKE_BEHIND = "brake-behind"
_HARDER = 1.15  # than what is needed by now: it is begun with some jerk
_SLOWER_MPS = 2.0  # than the front car, until the distance is there
_LEAST_ROOM_M = 1.0
_STEERABLE_MPS = 0.5
_ARRIVING_SHARE = 0.6  # of the time that is left to a destination: then its lane lets the host come there in time
_LEAST_SHARE = 0.1  # of a path's amplitude: a logistic curve has no end
_DUE_S = 8.0  # a lane that has to be reached so soon is gone on to without settling in the one between
_BODY_ROOM_M = 0.25  # from the body's flank to the road's edge, for the targets of steering


def keep_path(cycle: Cycle) -> OffsetPath:
    """The centre of the lane that holds the body centre, or beside it where the destination near ahead is there."""
    return OffsetPath(start_s_m=cycle.situation.host.s_m, start_d_m=cycle.kept_d_m, amplitude_m=0.0, a_per_m=-0.1, b=50.0)


def lateral_bound_mps2(situation: Situation, sigmoid: SigmoidSettings) -> float:
    """The lateral acceleration that the closed form may ask for: its setting, or its share of what the road gives."""
    return min(sigmoid.lateral_acceleration_mps2, sigmoid.lateral_friction_share * situation.road.friction * GRAVITY_MPS2)


def keep_lane(cycle: Cycle, mode: Mode, towards: Gap | None = None) -> Proposed:
    """Nothing threatens: keep the lane at the desired speed, or such that the host comes beside a gap in the next one, but no faster than
    now where nobody watches ahead; asked to park, stand until `park` takes over."""
    situation, path = cycle.situation, keep_path(cycle)
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
    return Proposed(name=STOP_IN_LANE, mode=Mode.BRAKE, side=Side.NONE, path=keep_path(cycle), speed_mps=0.0)


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
        gap_m = front.s_m - situation.host.s_m - 0.5 * (front.along_m + cycle.vehicle.length_m)
        room_m = max(gap_m - cycle.settings.headway.standstill_m, _LEAST_ROOM_M)
        needed = max(needed, max(host_mps - front_mps, 0.0) ** 2 / (2.0 * room_m))
        slowest = min(slowest, max(front_mps - max(braking, 0.0) * horizon_s - _SLOWER_MPS, 0.0))
        if braking > 0.0:
            needed = max(needed, host_mps**2 / (2.0 * (room_m + front_mps**2 / (2.0 * braking))))
    rate = min(max(_HARDER * needed, ORDINARY_MPS2), available_mps2(cycle.vehicle, situation.road.friction)[0])
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
    return reaches_into(replace(track, d_m=there_m), cycle.lane_centre_m, situation.road.lane_width_m)


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
    """Into the lane that is wanted, once that has been announced, as slowly as a person does it; None where none is due."""
    return _unhurried(cycle, cycle.observed.lane_choice.side) if cycle.observed.lane_choice.is_due else None


def change_to_required(cycle: Cycle, required: RequiredLane) -> Proposed | None:
    """The same because the lane has to be reached, sooner where it has to be soon; None where nobody watches that side, or the car
    stands."""
    situation = cycle.situation
    if _unwatched(situation, required.side) or situation.host.speed_mps < _STEERABLE_MPS:
        return None
    changing_s = cycle.settings.manners.changing_s
    within_s = required.left_s - 1.0 if required.end_m is not None else min(required.left_s - 1.0, _ARRIVING_SHARE * required.left_s)
    return _unhurried(cycle, required.side, min(changing_s, max(within_s, 0.5 * changing_s)))


def change_on(cycle: Cycle, required: RequiredLane, active: Manoeuvre) -> Proposed | None:
    """A lane change that is half done goes on into the lane beyond, because that has to be reached soon: along one path through where the
    host is, as it heads now. None where it is not so, or the car stands."""
    situation, sigmoid = cycle.situation, cycle.settings.sigmoid
    host, road = situation.host, situation.road
    if active.mode is not Mode.CRUISE or active.side is not required.side or required.left_s > _DUE_S or not active.half_done(situation):
        return None
    if _unwatched(situation, required.side) or host.speed_mps < _STEERABLE_MPS:
        return None
    beside = road.lane_of(host.d_m, host.s_m) + (1 if required.side is Side.LEFT else -1)
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
    beside = road.lane_of(host.d_m, host.s_m) + (1 if side is Side.LEFT else -1)
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


def basic_four(cycle: Cycle, active: Manoeuvre | None) -> tuple[Proposed, ...]:
    """Keep the lane by braking or accelerating, steer left, steer right; the active manoeuvre takes the place of its side."""
    situation, assessment = cycle.situation, cycle.assessment
    wanted, speed = situation.wanted_speed_mps, situation.host.speed_mps
    keep = keep_path(cycle)
    slower = min(wanted, speed)
    if assessment.front_speed_mps is not None:
        slower = min(slower, max(assessment.front_speed_mps, 0.0))
    faster = max(wanted, speed)
    if assessment.rear_speed_mps is not None:
        rear = assessment.rear_speed_mps
        faster = max(faster, rear if cycle.is_pressed else min(rear, cycle.limit_mps))
    faster = min(faster, 0.98 * cycle.vehicle.speed_max_mps)
    blind = "" if situation.coverage.sees(Sector.FRONT) else "nobody watches the front"
    brake = Proposed(name="brake", mode=Mode.BRAKE, side=Side.NONE, path=keep, speed_mps=slower, speeds_mps=_eased(cycle, slower))
    accelerate = Proposed(name="accelerate", mode=Mode.ACCELERATE, side=Side.NONE, path=keep, speed_mps=faster, refusal=blind)
    sides = (go_on(active) if active is not None and active.side is side else steer_out(cycle, side) for side in (Side.LEFT, Side.RIGHT))
    return (brake, accelerate, *sides)


def steer_out(cycle: Cycle, side: Side) -> Proposed:
    """Out to `side` along the corrected sigmoid, or along the one that the settings give."""
    situation, vehicle, sigmoid = cycle.situation, cycle.vehicle, cycle.settings.sigmoid
    host = situation.host
    target = next_lane_m(situation, vehicle, side)
    refusal = _unwatched(situation, side)
    if target is None:
        refusal, target = _why_no_lane(situation, side), host.d_m
    elif host.speed_mps < 0.5:
        refusal = "standing still"
    if sigmoid.given is not None:
        path = given_path(situation, vehicle, sigmoid.given, side)
        target = path.target_d_m
    else:
        path = _bent_path(cycle, target)
    return Proposed(
        name=side.value,
        mode=Mode.EVADE,
        side=side,
        path=path,
        speed_mps=situation.wanted_speed_mps,
        manoeuvre=Manoeuvre(side=side, path=path, target_d_m=target, speed_mps=situation.wanted_speed_mps),
        refusal=refusal,
    )


def _why_no_lane(situation: Situation, side: Side) -> str:
    """Why there is no lane to change into, nor a shoulder, on that side."""
    road, host = situation.road, situation.host
    lane = road.lane_of(host.d_m, host.s_m) + (1 if side is Side.LEFT else -1)
    if not -road.lanes_right <= lane <= road.lanes_left:
        return f"no lane and no shoulder to the {side}"
    described = next((one for one in road.lanes if one.lane == lane), None)
    if described is not None and (described.oncoming or described.shoulder):
        return f"the lane to the {side} is {'one of oncoming traffic' if described.oncoming else 'a shoulder'}"
    return f"the lane to the {side} does not go on for as long as changing into it takes"


def further(cycle: Cycle) -> tuple[Proposed, ...]:
    """What competes with the basic four, in this order."""
    return sound_proposals(FURTHER, keep_path(cycle), cycle)


def sampled(cycle: Cycle) -> tuple[Proposed, ...]:
    """The best few of different kind out of the sampled family: side, early or late, slower or faster, each with its own guess."""
    situation = cycle.situation
    host, proposals = situation.host, []
    for choice in best_of_kind(situation, cycle.vehicle, cycle.prediction, grid=cycle.settings.grid):
        name = f"{'keep' if choice.side is Side.NONE else choice.side.value}-{choice.pace}{'' if choice.early else '-late'}"
        if choice.side is Side.NONE:
            path, manoeuvre, mode = keep_path(cycle), None, Mode.BRAKE
        else:
            mode = Mode.EVADE
            path = corrected(
                start_s_m=host.s_m + host.speed_mps * choice.delay_s,
                start_d_m=host.d_m,
                target_d_m=choice.target_d_m,
                speed_mps=host.speed_mps,
                lateral_acceleration_mps2=choice.lateral_mps2,
                b=choice.softness,
            )
            manoeuvre = Manoeuvre(side=choice.side, path=path, target_d_m=choice.target_d_m, speed_mps=choice.end_speed_mps)
        refusal = _unwatched(situation, choice.side)
        if choice.side is Side.NONE and choice.pace == "faster" and not situation.coverage.sees(Sector.FRONT):
            refusal = "nobody watches the front"
        proposals.append(
            Proposed(
                name=name,
                mode=mode,
                side=choice.side,
                path=path,
                speed_mps=choice.end_speed_mps,
                manoeuvre=manoeuvre,
                refusal=refusal,
                guess=choice.states,
                is_delayed=not choice.early,
            )
        )
    return tuple(proposals)


def given_path(situation: Situation, vehicle: Vehicle, design: SigmoidDesign, side: Side) -> OffsetPath:
    """A designed sigmoid from where the host is: a and b as given, its reach counted from the middle of the host's lane."""
    host, road = situation.host, situation.road
    room = 0.5 * vehicle.width_m + _BODY_ROOM_M
    reach = design.reach_m if side is Side.LEFT else -design.reach_m
    centre = road.lane_centre_m(road.lane_of(host.d_m, host.s_m), host.s_m)
    target = float(
        np.clip(
            centre + reach, min(float(road.right_edge_at(host.s_m)) + room, centre), max(float(road.left_edge_at(host.s_m)) - room, centre)
        )
    )
    return OffsetPath(start_s_m=host.s_m, start_d_m=host.d_m, amplitude_m=target - host.d_m, a_per_m=design.a_per_m, b=design.b)


def _bent_path(cycle: Cycle, target_d_m: float) -> OffsetPath:
    """The corrected sigmoid to its target, bent by the front vehicle's offset where the road allows it."""
    situation, sigmoid = cycle.situation, cycle.settings.sigmoid
    host, road = situation.host, situation.road
    bend, bend_s = 0.0, host.s_m
    front = next((t for t in situation.tracks if t.id == cycle.assessment.front_id), None)
    if front is not None:
        room = 0.5 * cycle.vehicle.width_m + _BODY_ROOM_M
        low, high = float(road.right_edge_at(host.s_m)) + room, float(road.left_edge_at(host.s_m)) - room
        half_lane_room = max(0.5 * road.lane_width_at(road.lane_of(host.d_m, host.s_m), host.s_m) - room, 0.0)
        bend = min(max(cycle.assessment.offset_m, -half_lane_room), half_lane_room)
        bend = min(max(target_d_m + bend, min(low, target_d_m)), max(high, target_d_m)) - target_d_m
        bend_s = front.s_m + front.speed_s_mps * 2.5
    return corrected(
        start_s_m=host.s_m,
        start_d_m=host.d_m,
        target_d_m=target_d_m,
        speed_mps=host.speed_mps,
        lateral_acceleration_mps2=lateral_bound_mps2(situation, sigmoid),
        b=sigmoid.b,
        speed_floor_mps=sigmoid.speed_floor_mps,
        bend_m=bend,
        bend_s_m=bend_s,
        bend_width_m=12.0,
    )


def _eased(cycle: Cycle, slower_mps: float) -> Array | None:
    """Falling as is ordinary where that is enough; elsewhere as hard as it may be."""
    if not cycle.front_braking.is_gentle:
        return None
    return np.maximum(slower_mps, cycle.situation.host.speed_mps - ORDINARY_MPS2 * cycle.settings.grid.times_s)


def _unwatched(situation: Situation, side: Side) -> str:
    """Why a side that nobody watches is refused; empty for one that is watched."""
    sector = {Side.LEFT: Sector.LEFT, Side.RIGHT: Sector.RIGHT}.get(side)
    return "" if sector is None or situation.coverage.sees(sector) else f"nobody watches the {side}"


FURTHER: tuple[Callable[[Cycle], Iterable[Proposed]], ...] = (sampled,)
