"""The ways out of a situation, as records: what to aim at, and from which guess."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.reference.offset_path import OffsetPath, corrected

BODY_ROOM_M = 0.25  # from the body's flank to the road's edge, for the targets of steering


@dataclass(frozen=True, slots=True, kw_only=True)
class Manoeuvre:
    """A steering manoeuvre under way: its side, its path, where it ends. Lives in `Plan.reference` from cycle to cycle."""

    side: Side
    path: OffsetPath
    target_d_m: float

    def finished(self, situation: Situation) -> bool:
        """Past the path's end, or settled on its target."""
        host = situation.host
        past = host.s_m > self.path.start_s_m + self.path.length_m + host.speed_mps * 0.5
        settled = abs(host.d_m - self.target_d_m) < 0.25 and abs(host.heading_rad) < 0.03
        return past or settled

    def half_done(self, situation: Situation) -> bool:
        """The body centre is in the lane that it ends in."""
        return situation.road.lane_of(situation.host.d_m) == situation.road.lane_of(self.target_d_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """One candidate: keep the lane towards a speed, or steer along a path. `refusal` says why it is not even tried."""

    name: str
    mode: Mode
    side: Side
    path: OffsetPath
    speed_mps: float
    manoeuvre: Manoeuvre | None = None
    refusal: str = ""


def keep_path(situation: Situation) -> OffsetPath:
    """The centre of the lane that holds the body centre."""
    road, host = situation.road, situation.host
    centre = road.lane_centre_m(road.lane_of(host.d_m))
    return OffsetPath(start_s_m=host.s_m, start_d_m=centre, amplitude_m=0.0, a_per_m=-0.1, b=50.0)


def lateral_bound_mps2(situation: Situation, sigmoid: SigmoidSettings) -> float:
    """The lateral acceleration that the closed form may ask for: its setting, or its share of what the road gives."""
    return min(sigmoid.lateral_acceleration_mps2, sigmoid.lateral_friction_share * situation.road.friction * GRAVITY_MPS2)


def steering_target_m(situation: Situation, vehicle: Vehicle, side: Side) -> float | None:
    """d of the next lane's centre, else of the shoulder's when the car fits on it; None when there is neither."""
    road, host = situation.road, situation.host
    sign = 1 if side is Side.LEFT else -1
    lane = road.lane_of(host.d_m) + sign
    if road.has_lane(lane):
        return road.lane_centre_m(lane)
    shoulder = road.shoulder_left_m if side is Side.LEFT else road.shoulder_right_m
    edge = road.left_edge_m if side is Side.LEFT else road.right_edge_m
    if shoulder >= vehicle.width_m + 2.0 * BODY_ROOM_M:
        return edge - sign * 0.5 * shoulder
    return None


def steering_way(
    situation: Situation, assessment: Assessment, vehicle: Vehicle, sigmoid: SigmoidSettings, side: Side, *, lateral_mps2: float, name: str
) -> Way:
    """Out to `side` along the corrected sigmoid, bent by the front vehicle's offset where the road allows it."""
    host, road = situation.host, situation.road
    target = steering_target_m(situation, vehicle, side)
    sector = Sector.LEFT if side is Side.LEFT else Sector.RIGHT
    refusal = ""
    if target is None:
        refusal, target = f"no lane and no shoulder to the {side}", host.d_m
    elif not situation.coverage.sees(sector):
        refusal = f"nobody watches the {side}"
    elif host.speed_mps < 0.5:
        refusal = "standing still"
    bend, bend_s = 0.0, host.s_m
    front = next((t for t in situation.tracks if t.id == assessment.front_id), None)
    if front is not None:
        room = 0.5 * vehicle.width_m + BODY_ROOM_M
        low, high = road.right_edge_m + room, road.left_edge_m - room
        half_lane_room = max(0.5 * road.lane_width_m - room, 0.0)
        bend = float(np.clip(assessment.offset_m, -half_lane_room, half_lane_room))
        bend = float(np.clip(target + bend, min(low, target), max(high, target)) - target)
        bend_s = front.s_m + front.speed_s_mps * 2.5
    path = corrected(
        start_s_m=host.s_m,
        start_d_m=host.d_m,
        target_d_m=target,
        speed_mps=host.speed_mps,
        lateral_acceleration_mps2=lateral_mps2,
        b=sigmoid.b,
        speed_floor_mps=sigmoid.speed_floor_mps,
        bend_m=bend,
        bend_s_m=bend_s,
        bend_width_m=12.0,
    )
    return Way(
        name=name,
        mode=Mode.EVADE,
        side=side,
        path=path,
        speed_mps=situation.wanted_speed_mps,
        manoeuvre=Manoeuvre(side=side, path=path, target_d_m=target),
        refusal=refusal,
    )


def ways_out(
    situation: Situation, assessment: Assessment, vehicle: Vehicle, sigmoid: SigmoidSettings, going: Manoeuvre | None
) -> tuple[Way, ...]:
    """Keep the lane by braking or accelerating, steer left, steer right; a manoeuvre under way takes the place of its side."""
    wanted, speed = situation.wanted_speed_mps, situation.host.speed_mps
    keep = keep_path(situation)
    slower = min(wanted, speed)
    if assessment.front_speed_mps is not None:
        slower = min(slower, max(assessment.front_speed_mps, 0.0))
    faster = max(wanted, speed)
    if assessment.rear_speed_mps is not None:
        faster = max(faster, assessment.rear_speed_mps)
    faster = min(faster, 0.98 * vehicle.speed_max_mps)
    blind = "" if situation.coverage.sees(Sector.FRONT) else "nobody watches the front"
    ways = [
        Way(name="brake", mode=Mode.BRAKE, side=Side.NONE, path=keep, speed_mps=slower),
        Way(name="accelerate", mode=Mode.ACCELERATE, side=Side.NONE, path=keep, speed_mps=faster, refusal=blind),
    ]
    bound = lateral_bound_mps2(situation, sigmoid)
    for side in (Side.LEFT, Side.RIGHT):
        if going is not None and going.side is side:
            ways.append(continued(situation, going))
        else:
            ways.append(steering_way(situation, assessment, vehicle, sigmoid, side, lateral_mps2=bound, name=side.value))
    return tuple(ways)


def harder_ways(situation: Situation, assessment: Assessment, vehicle: Vehicle, sigmoid: SigmoidSettings) -> tuple[Way, ...]:
    """Both sides with most of the road's grip, tried when nothing gentler passes."""
    bound = 0.85 * situation.road.friction * GRAVITY_MPS2
    return tuple(
        steering_way(situation, assessment, vehicle, sigmoid, side, lateral_mps2=bound, name=f"{side.value}-hard")
        for side in (Side.LEFT, Side.RIGHT)
    )


def continued(situation: Situation, going: Manoeuvre) -> Way:
    """A manoeuvre once begun goes on along its own path."""
    return Way(
        name=going.side.value,
        mode=Mode.EVADE,
        side=going.side,
        path=going.path,
        speed_mps=situation.wanted_speed_mps,
        manoeuvre=going,
    )


def keeping_way(situation: Situation, mode: Mode) -> Way:
    """Nothing threatens: keep the lane at the desired speed."""
    return Way(name="keep", mode=mode, side=Side.NONE, path=keep_path(situation), speed_mps=situation.wanted_speed_mps)
