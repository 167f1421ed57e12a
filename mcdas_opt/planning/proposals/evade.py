"""The four basic candidates against a threat: braking, accelerating, and steering out along a sigmoid to either side."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.manoeuvres.kinds import STEERABLE_MPS, next_lane_m
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.front.headway import ORDINARY_MPS2
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.proposals.keep_lane import BRAKE, keep_path
from mcdas_opt.planning.proposals.lane_change import go_on
from mcdas_opt.planning.proposals.unwatched import begins_unwatched
from mcdas_opt.reference.offset_path import OffsetPath, corrected

_BODY_ROOM_M = 0.25  # from the body's flank to the road's edge, for the targets of steering


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
    brake = Proposed(name=BRAKE, mode=Mode.BRAKE, side=Side.NONE, path=keep, speed_mps=slower, speeds_mps=_eased(cycle, slower))
    accelerate = Proposed(name="accelerate", mode=Mode.ACCELERATE, side=Side.NONE, path=keep, speed_mps=faster, refusal=blind)
    sides = (go_on(active) if active is not None and active.side is side else steer_out(cycle, side) for side in (Side.LEFT, Side.RIGHT))
    return (brake, accelerate, *sides)


def steer_out(cycle: Cycle, side: Side) -> Proposed:
    """Out to `side` along the corrected sigmoid, or along the one that the settings give."""
    situation, vehicle, sigmoid = cycle.situation, cycle.vehicle, cycle.settings.sigmoid
    host = situation.host
    target = next_lane_m(situation, vehicle, side)
    refusal = begins_unwatched(cycle, side)
    if target is None:
        refusal, target = _why_no_lane(situation, side), host.d_m
    elif host.speed_mps < STEERABLE_MPS:
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
    road, lane = situation.road, situation.lane_beside(side)
    if not -road.lanes_right <= lane <= road.lanes_left:
        return f"no lane and no shoulder to the {side}"
    described = next((one for one in road.lanes if one.lane == lane), None)
    if described is not None and (described.oncoming or described.shoulder):
        return f"the lane to the {side} is {'one of oncoming traffic' if described.oncoming else 'a shoulder'}"
    return f"the lane to the {side} does not go on for as long as changing into it takes"


def given_path(situation: Situation, vehicle: Vehicle, design: SigmoidDesign, side: Side) -> OffsetPath:
    """A designed sigmoid from where the host is: a and b as given, its reach counted from the middle of the host's lane."""
    host, road = situation.host, situation.road
    room = 0.5 * vehicle.width_m + _BODY_ROOM_M
    reach = side.sign * design.reach_m
    centre = road.lane_centre_m(situation.host_lane, host.s_m)
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
    front = situation.track(cycle.assessment.front_id)
    if front is not None:
        room = 0.5 * cycle.vehicle.width_m + _BODY_ROOM_M
        low, high = float(road.right_edge_at(host.s_m)) + room, float(road.left_edge_at(host.s_m)) - room
        half_lane_room = max(0.5 * road.lane_width_at(situation.host_lane, host.s_m) - room, 0.0)
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


def lateral_bound_mps2(situation: Situation, sigmoid: SigmoidSettings) -> float:
    """The lateral acceleration that the closed form may ask for: its setting, or its share of what the road gives."""
    return min(sigmoid.lateral_acceleration_mps2, sigmoid.lateral_friction_share * situation.road.friction * GRAVITY_MPS2)


def _eased(cycle: Cycle, slower_mps: float) -> Array | None:
    """Falling as is ordinary where that is enough; elsewhere as hard as it may be."""
    if not cycle.front_braking.is_gentle:
        return None
    return np.maximum(slower_mps, cycle.situation.host.speed_mps - ORDINARY_MPS2 * cycle.settings.grid.times_s)
