"""The ways out of a situation, as records: what to aim at, and from which guess."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.manoeuvres.kinds import best_of_kind, next_lane_m
from mcdas_opt.reference.offset_path import OffsetPath, corrected

_most, _least = np.maximum.reduce, np.minimum.reduce
_MARKING_M = 0.15  # a body that crosses the marking by less still keeps its lane
_LEANING_M = 0.1  # a smaller offset of the front vehicle leans to neither side
_ORDINARY_MPS2, _STANDING_GAP_M = 2.0, 2.0  # braking towards the front car, where that is enough
BODY_ROOM_M = 0.25  # from the body's flank to the road's edge, for the targets of steering


@dataclass(frozen=True, slots=True, kw_only=True)
class Manoeuvre:
    """A steering manoeuvre under way: its side, its path, where it ends. Lives in `Plan.reference` from cycle to cycle."""

    side: Side
    path: OffsetPath
    target_d_m: float
    speed_mps: float

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
    """One candidate: keep the lane towards a speed, or steer along a path. `refusal` says why it is not even tried.

    `guess` (N + 1, 6) are states to begin from; None: those of the path. `waits`: it begins later. `easing_mps2`: its speed falls towards
    `speed_mps` no faster; infinite: that is asked for at once.
    """

    name: str
    mode: Mode
    side: Side
    path: OffsetPath
    speed_mps: float
    manoeuvre: Manoeuvre | None = None
    refusal: str = ""
    guess: Array | None = field(default=None, compare=False)
    waits: bool = False
    easing_mps2: float = math.inf


def shorter_side(assessment: Assessment) -> Side:
    """The side that asks for less lateral movement past the front vehicle (eq 22-23); none when that is straight ahead."""
    if assessment.front_id is None or abs(assessment.offset_m) <= _LEANING_M:
        return Side.NONE
    return Side.RIGHT if assessment.offset_m > 0.0 else Side.LEFT


def keep_path(situation: Situation) -> OffsetPath:
    """The centre of the lane that holds the body centre."""
    road, host = situation.road, situation.host
    centre = road.lane_centre_m(road.lane_of(host.d_m))
    return OffsetPath(start_s_m=host.s_m, start_d_m=centre, amplitude_m=0.0, a_per_m=-0.1, b=50.0)


def lateral_bound_mps2(situation: Situation, sigmoid: SigmoidSettings) -> float:
    """The lateral acceleration that the closed form may ask for: its setting, or its share of what the road gives."""
    return min(sigmoid.lateral_acceleration_mps2, sigmoid.lateral_friction_share * situation.road.friction * GRAVITY_MPS2)


def _bent_path(
    situation: Situation, assessment: Assessment, vehicle: Vehicle, sigmoid: SigmoidSettings, target: float, lateral_mps2: float
) -> OffsetPath:
    """The corrected sigmoid to `target`, bent by the front vehicle's offset where the road allows it."""
    host, road = situation.host, situation.road
    bend, bend_s = 0.0, host.s_m
    front = next((t for t in situation.tracks if t.id == assessment.front_id), None)
    if front is not None:
        room = 0.5 * vehicle.width_m + BODY_ROOM_M
        low, high = road.right_edge_m + room, road.left_edge_m - room
        half_lane_room = max(0.5 * road.lane_width_m - room, 0.0)
        bend = float(np.clip(assessment.offset_m, -half_lane_room, half_lane_room))
        bend = float(np.clip(target + bend, min(low, target), max(high, target)) - target)
        bend_s = front.s_m + front.speed_s_mps * 2.5
    return corrected(
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


def given_path(situation: Situation, vehicle: Vehicle, design: SigmoidDesign, side: Side) -> OffsetPath:
    """A designed sigmoid from where the host is: a and b as given, its reach counted from the middle of the host's lane."""
    host, road = situation.host, situation.road
    room = 0.5 * vehicle.width_m + BODY_ROOM_M
    reach = design.reach_m if side is Side.LEFT else -design.reach_m
    centre = road.lane_centre_m(road.lane_of(host.d_m))
    target = float(np.clip(centre + reach, min(road.right_edge_m + room, centre), max(road.left_edge_m - room, centre)))
    return OffsetPath(start_s_m=host.s_m, start_d_m=host.d_m, amplitude_m=target - host.d_m, a_per_m=design.a_per_m, b=design.b)


def steering_way(
    situation: Situation, assessment: Assessment, vehicle: Vehicle, sigmoid: SigmoidSettings, side: Side, *, lateral_mps2: float, name: str
) -> Way:
    """Out to `side` along the corrected sigmoid, or along the one that the settings give."""
    host = situation.host
    target = next_lane_m(situation, vehicle, side)
    refusal = _unwatched(situation, side)
    if target is None:
        refusal, target = f"no lane and no shoulder to the {side}", host.d_m
    elif host.speed_mps < 0.5:
        refusal = "standing still"
    if sigmoid.given is not None:
        path = given_path(situation, vehicle, sigmoid.given, side)
        target = path.target_d_m
    else:
        path = _bent_path(situation, assessment, vehicle, sigmoid, target, lateral_mps2)
    return Way(
        name=name,
        mode=Mode.EVADE,
        side=side,
        path=path,
        speed_mps=situation.wanted_speed_mps,
        manoeuvre=Manoeuvre(side=side, path=path, target_d_m=target, speed_mps=situation.wanted_speed_mps),
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
        Way(name="brake", mode=Mode.BRAKE, side=Side.NONE, path=keep, speed_mps=slower, easing_mps2=_easing_mps2(situation, assessment)),
        Way(name="accelerate", mode=Mode.ACCELERATE, side=Side.NONE, path=keep, speed_mps=faster, refusal=blind),
    ]
    bound = lateral_bound_mps2(situation, sigmoid)
    for side in (Side.LEFT, Side.RIGHT):
        if going is not None and going.side is side:
            ways.append(continued(situation, going))
        else:
            ways.append(steering_way(situation, assessment, vehicle, sigmoid, side, lateral_mps2=bound, name=side.value))
    return tuple(ways)


def _easing_mps2(situation: Situation, assessment: Assessment) -> float:
    """As is ordinary where braking is enough, half of that would do in the room that there is, and the front car itself brakes no harder;
    elsewhere as hard as it may be."""
    front = next((track for track in situation.tracks if track.id == assessment.front_id), None)
    if assessment.mode is not Mode.BRAKE or front is None or front.acceleration_s_mps2 < -_ORDINARY_MPS2:
        return math.inf
    closing, room = situation.host.speed_mps - front.speed_s_mps, assessment.front_gap_m - _STANDING_GAP_M
    return _ORDINARY_MPS2 if max(closing, 0.0) ** 2 <= _ORDINARY_MPS2 * room else math.inf


def spread_ways(situation: Situation, vehicle: Vehicle, prediction: Prediction, grid: TimeGrid) -> tuple[Way, ...]:
    """The best few of different kind out of the sampled family: side, early or late, slower or faster, each with its own guess."""
    host, ways = situation.host, []
    for choice in best_of_kind(situation, vehicle, prediction, grid=grid):
        name = f"{'keep' if choice.side is Side.NONE else choice.side.value}-{choice.pace}{'' if choice.early else '-late'}"
        if choice.side is Side.NONE:
            path, manoeuvre, mode = keep_path(situation), None, Mode.BRAKE
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
        ways.append(
            Way(
                name=name,
                mode=mode,
                side=choice.side,
                path=path,
                speed_mps=choice.end_speed_mps,
                manoeuvre=manoeuvre,
                refusal=refusal,
                guess=choice.states,
                waits=not choice.early,
            )
        )
    return tuple(ways)


def _unwatched(situation: Situation, side: Side) -> str:
    """Why a side that nobody watches is refused; empty for one that is watched."""
    sector = {Side.LEFT: Sector.LEFT, Side.RIGHT: Sector.RIGHT}.get(side)
    return "" if sector is None or situation.coverage.sees(sector) else f"nobody watches the {side}"


def continued(situation: Situation, going: Manoeuvre) -> Way:
    """A manoeuvre once begun goes on along its own path."""
    return Way(
        name=going.side.value,
        mode=Mode.EVADE,
        side=going.side,
        path=going.path,
        speed_mps=going.speed_mps,
        manoeuvre=going,
    )


def keeping_way(situation: Situation, mode: Mode) -> Way:
    """Nothing threatens: keep the lane at the desired speed; asked to park, stand until `park` takes over."""
    speed = 0.0 if mode is Mode.PARK else situation.wanted_speed_mps
    return Way(name="keep", mode=mode, side=Side.NONE, path=keep_path(situation), speed_mps=speed)


def strays(trajectory: Trajectory, situation: Situation, way: Way, vehicle: Vehicle) -> Side:
    """Where a drive that was to keep its lane does not: its body crosses the marking to a side that nobody watches, or by half its width.

    None where it keeps the lane, or was to leave it. A car that begins beyond the marking is let back in.
    """
    if way.side is not Side.NONE:
        return Side.NONE
    half, centre, psi, d = 0.5 * situation.road.lane_width_m, way.path.start_d_m, trajectory.heading_rad, trajectory.d_m
    turned = max(_most(psi), -_least(psi))
    if max(_most(d) - centre, centre - _least(d)) + 0.5 * (vehicle.width_m + vehicle.length_m * turned) < half:
        return Side.NONE  # plainly within it
    reach = 0.5 * vehicle.width_m * np.cos(psi) + 0.5 * vehicle.length_m * np.abs(np.sin(psi))
    offset = d - centre
    found = Side.NONE
    for side, over in ((Side.LEFT, offset + reach - half), (Side.RIGHT, reach - offset - half)):
        watched = situation.coverage.sees(Sector(side.value))
        room = 0.5 * vehicle.width_m if watched else _MARKING_M
        if float(over.max()) > max(room, float(over[0]) + _MARKING_M):
            if not watched:
                return side
            found = found if found is not Side.NONE else side
    return found
