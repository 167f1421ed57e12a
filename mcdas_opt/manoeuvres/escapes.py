"""The escape map: for each way out, the last moment at which it still can be started, and what ends it."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.escapes import Closer, Escape, Escapes
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Sector, Side
from mcdas_opt.manoeuvres.clearance import Margins, clearance
from mcdas_opt.manoeuvres.family import EDGE_M, Demand, first_contact, roll_out
from mcdas_opt.manoeuvres.held import held
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.manoeuvres.phases import Phases
from mcdas_opt.manoeuvres.sidesteps import Sidesteps, Starts, Ways

KINDS = ("brake", "accelerate", "left", "right")
_SIDEWAYS = 2  # kinds from here on steer
_STEP_S = 0.1
_HELD_STEP_S = 0.05
_PARTS = 4
_NEVER_S = 99.0
_PRECISION: Any = np.float32
_ROOM_SHARE = 0.95  # of the braking or accelerating that ends what still closes in at the end


@dataclass(frozen=True, slots=True, kw_only=True)
class EscapeSettings:
    """`clear_s`: a way out counts when it stays clear for so long after its start, and ends with room for what still closes in.
    `latest_s`: starts are not sought beyond it.

    In the lane: levels as shares of what the car can do, each held, or for a while, or until the front (rear) car's speed is reached;
    less than the least level for the shortest while is no braking (accelerating). Sideways:
    (share of mu g across, b of the sigmoid, share of braking (-) or accelerating (+), until [s]).
    """

    clear_s: float = 4.0
    latest_s: float = 10.0
    levels: tuple[float, ...] = (0.97, 0.75, 0.5, 0.3, 0.12)
    phases_s: tuple[float, ...] = (0.5, 1.0, 1.6, 2.6)
    sideways: tuple[tuple[float, float, float, float], ...] = (
        (0.97, 8.0, 0.0, 0.0),
        (0.9, 20.0, 0.0, 0.0),
        (0.72, 20.0, 0.0, 0.0),
        (0.65, 8.0, 0.0, 0.0),
        (0.4, 12.0, 0.0, 0.0),
        (0.2, 12.0, 0.0, 0.0),
        (0.2, 50.0, 0.0, 0.0),
        (0.9, 8.0, 0.4, 9.0),
        (0.72, 20.0, 0.4, 9.0),
        (0.55, 12.0, 0.4, 9.0),
        (0.93, 8.0, 0.9, 1.2),
        (0.93, 8.0, 0.9, 9.0),
        (0.55, 20.0, 0.9, 1.0),
        (0.35, 20.0, 0.9, 1.0),
        (0.35, 12.0, 0.9, 9.0),
        (0.88, 8.0, -0.4, 9.0),
        (0.76, 8.0, -0.6, 9.0),
        (0.7, 20.0, -0.2, 0.8),
        (0.65, 20.0, -0.4, 0.8),
        (0.55, 12.0, -0.6, 0.8),
        (0.35, 12.0, -0.6, 0.8),
        (0.25, 20.0, -0.75, 0.8),
        (0.72, 50.0, -0.4, 9.0),
        (0.55, 20.0, -0.4, 9.0),
        (0.6, 8.0, -0.76, 1.5),
    )
    coarse: int = 11
    fine: int = 12
    clear_m: float = 0.02
    demand: Demand = field(default_factory=lambda: Demand(friction=1.0, steering=1.0))
    margins: Margins = field(default_factory=Margins)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Members:
    """Columns (M,): which kind, and what it does."""

    kind: NDArray[np.intp]
    level_mps2: Array
    until_s: Array
    until_mps: Array  # the phase ends where this speed is reached; NaN for a phase that ends by the clock
    target_d_m: Array
    lateral_mps2: Array
    b: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class _Looked:
    """(S, M): starts by members."""

    open: NDArray[np.bool_]
    possible: NDArray[np.bool_]
    on_road: NDArray[np.bool_]
    separation_m: Array
    contact_with: NDArray[np.intp]
    demand_mps2: Array


def escapes(situation: Situation, vehicle: Vehicle, prediction: Prediction, settings: EscapeSettings | None = None) -> Escapes:
    """The four ways out, each judged by the best of a few manoeuvres of its kind, for all starts at once.

    First on a coarse grid of starts up to the moment at which keeping on ends in somebody or off the road; then between the last open
    start and the next. Bodies are parted throughout the steps by a lower bound, so that a way called open is one.
    """
    chosen = settings or EscapeSettings()
    times = np.round(np.arange(0.0, chosen.latest_s + 1e-9, _HELD_STEP_S), 9)
    path = held(situation.host, times, vehicle, situation.road)
    end, ender = _end_of_keeping_on(path, times, situation, vehicle, prediction, chosen)
    members = _members(situation, vehicle, prediction, chosen)
    coarse = np.linspace(0.0, end, chosen.coarse)
    first = _look(_at(path, times, coarse[:, None]), coarse[:, None], members, situation, vehicle, prediction, chosen)
    found = [first.open[:, members.kind == kind].any(axis=1) for kind in range(len(KINDS))]
    last = np.array([np.flatnonzero(row)[-1] if row.any() else 0 for row in found])
    low = coarse[last]
    high = coarse[np.minimum(last + 1, chosen.coarse - 1)]
    share = np.linspace(0.0, 1.0, chosen.fine)[:, None]
    starts = (low + share * (high - low))[:, members.kind]
    second = _look(_at(path, times, starts), starts, members, situation, vehicle, prediction, chosen)
    answers: dict[str, Escape] = {}
    for kind, name in enumerate(KINDS):
        mine = members.kind == kind
        refusal = _refusal(name, situation)
        if refusal is not None or not (mine.any() and found[kind].any()):
            closer = refusal or (_closer(first, 0, mine, path, situation, prediction) if mine.any() else Closer.EDGE)
            answers[name] = Escape(closed_by=closer)
            continue
        rows = second.open[:, mine].any(axis=1)
        k = int(np.flatnonzero(rows)[-1]) if rows.any() else 0
        moment = float(low[kind] + share[k, 0] * (high[kind] - low[kind]))
        now = first.open[0] & mine
        closed_by = None
        if moment < chosen.latest_s - 1e-9:
            at_end = last[kind] == chosen.coarse - 1
            closed_by = ender if at_end or k + 1 >= chosen.fine else _closer(second, k + 1, mine, path, situation, prediction)
        demand = float(first.demand_mps2[0, now].min()) if now.any() else None
        answers[name] = Escape(open=True, last_moment_s=round(moment, 4), closed_by=closed_by, demand_mps2=demand)
    return Escapes(**answers)


def _refusal(name: str, situation: Situation) -> Closer | None:
    """A way into a direction that nobody watches is closed."""
    sector, closer = {
        "brake": (None, None),
        "accelerate": (Sector.FRONT, Closer.FRONT),
        "left": (Sector.LEFT, Closer.SIDE),
        "right": (Sector.RIGHT, Closer.SIDE),
    }[name]
    return closer if sector is not None and not situation.coverage.sees(sector) else None


def _end_of_keeping_on(
    path: Starts, times: Array, situation: Situation, vehicle: Vehicle, prediction: Prediction, chosen: EscapeSettings
) -> tuple[float, Closer | None]:
    """When keeping on ends, and by what; the latest start that is sought when it does not."""
    road = situation.road
    sine, cosine = np.sin(path.heading_rad), np.cos(path.heading_rad)
    way = Ways(s_m=path.s_m, d_m=path.d_m, heading_rad=path.heading_rad, sine=sine, cosine=cosine, curvature_1pm=np.zeros_like(sine))
    near = clearance(way, times, prediction.bodies, vehicle, road, chosen.margins, parts=_PARTS)
    moment, who = (q.item() for q in first_contact(near, times, 0.0))
    room = 0.5 * (vehicle.width_m * cosine + vehicle.length_m * np.abs(sine)) + EDGE_M
    off = (path.d_m + room > road.left_edge_m) | (path.d_m - room < road.right_edge_m)
    if road.road_end_s_m is not None:
        off |= path.s_m + 0.5 * vehicle.length_m + EDGE_M > road.road_end_s_m
    leaves = float(times[int(off.argmax())]) if off.any() else np.inf
    if min(moment, leaves) >= chosen.latest_s:
        return chosen.latest_s, None
    if leaves < moment:
        return leaves, Closer.EDGE
    return float(moment), _closer_of(int(who), situation, prediction, float(np.interp(moment, times, path.s_m)), float(moment))


def _members(situation: Situation, vehicle: Vehicle, prediction: Prediction, chosen: EscapeSettings) -> _Members:
    host, road = situation.host, situation.road
    grip = road.friction * GRAVITY_MPS2
    brake, accelerate = min(-vehicle.acceleration_min_mps2, grip), min(vehicle.acceleration_max_mps2, grip)
    keep = road.lane_centre_m(road.lane_of(host.d_m))
    front, rear = _speed_of_nearest(situation, prediction, 1.0), _speed_of_nearest(situation, prediction, -1.0)
    gentle = min(1.0, 0.2 * grip)
    rows: list[tuple[float, ...]] = []
    for level in chosen.levels:
        for kind, most, speed in ((0, -brake, front), (1, accelerate, rear)):
            ends = [(until, np.nan) for until in (_NEVER_S, *chosen.phases_s)] + ([(0.0, speed)] if speed is not None else [])
            rows += [(kind, level * most, *end, keep, gentle, 50.0) for end in ends]
    for (share, b, pace, until), (kind, side) in product(chosen.sideways, ((2, Side.LEFT), (3, Side.RIGHT))):
        target = next_lane_m(situation, vehicle, side)
        if target is not None:
            level = pace * (accelerate if pace > 0.0 else brake)
            rows.append((kind, level, until, np.nan, target, share * grip, b))
    columns = np.array(rows).T
    return _Members(
        kind=columns[0].astype(np.intp),
        level_mps2=columns[1],
        until_s=columns[2],
        until_mps=columns[3],
        target_d_m=columns[4],
        lateral_mps2=columns[5],
        b=columns[6],
    )


def _speed_of_nearest(situation: Situation, prediction: Prediction, sign: float) -> float | None:
    """Speed of the nearest body ahead (1) or behind (-1) in the host's way; None when there is nobody."""
    host, now = situation.host, np.zeros(1)
    best, speed = np.inf, None
    for body in prediction.bodies:
        motion = body.at(now)
        apart = sign * (float(motion.s_m[0]) - host.s_m)
        if 0.0 < apart < best and abs(float(motion.d_m[0]) - host.d_m) < 0.5 * situation.road.lane_width_m + 0.5:
            best, speed = apart, float(motion.speed_s_mps[0])
    return speed


def _at(path: Starts, times: Array, starts: Array) -> Starts:
    def column(values: Array) -> Array:
        return np.interp(starts, times, values)

    return Starts(
        s_m=column(path.s_m),
        d_m=column(path.d_m),
        heading_rad=column(path.heading_rad),
        speed_mps=column(path.speed_mps),
        acceleration_mps2=column(path.acceleration_mps2),
        steering_rad=column(path.steering_rad),
    )


def _look(
    begin: Starts,
    starts_s: Array,
    members: _Members,
    situation: Situation,
    vehicle: Vehicle,
    prediction: Prediction,
    chosen: EscapeSettings,
) -> _Looked:
    """Every member from every start (S, 1) or (S, M)."""
    times: Array = (np.arange(round(chosen.clear_s / _STEP_S) + 1) * _STEP_S).astype(_PRECISION)
    level = members.level_mps2
    gap = members.until_mps - begin.speed_mps
    until = np.where(np.isnan(members.until_mps), members.until_s, np.maximum(gap / np.where(level == 0.0, 1.0, level), 0.0))
    size = np.broadcast_shapes(until.shape, starts_s.shape, members.kind.shape)
    first = np.where(np.isnan(members.until_mps) | (until >= min(chosen.phases_s)), level, 0.0)
    phases = Phases(first_mps2=np.broadcast_to(first, size), switch_s=np.broadcast_to(until, size), then_mps2=np.zeros(size))
    steps = Sidesteps(target_d_m=members.target_d_m, lateral_mps2=members.lateral_mps2, delay_s=np.zeros(members.kind.size), b=members.b)
    rolled = roll_out(phases, steps, times, begin, vehicle, situation.road, chosen.demand)
    allowed = rolled.possible & rolled.on_road & ((first != 0.0) | (members.kind >= _SIDEWAYS))
    rows = np.nonzero(allowed)
    clock: Array = (np.broadcast_to(starts_s, size)[rows])[:, None].astype(_PRECISION) + times
    some = rolled.ways.only(rows)
    near = clearance(some, clock, prediction.bodies, vehicle, situation.road, chosen.margins, parts=_PARTS)
    least, who = np.full(size, -np.inf), np.full(size, -1, dtype=np.intp)
    least[rows] = near.separation_m.min(-1)
    speed = np.broadcast_to(rolled.speeds.speed_mps[..., -1], size)[rows]
    doomed_by = _doomed_by(some, speed, clock[:, -1], situation, vehicle, prediction)
    _, touched = first_contact(near, times, chosen.clear_m)
    who[rows] = np.where(touched >= 0, touched, doomed_by)
    effort = np.sqrt(rolled.speeds.acceleration_mps2**2 + rolled.lateral_mps2**2).max(-1)
    return _Looked(
        open=allowed & (least > chosen.clear_m) & (who < 0),
        possible=rolled.possible,
        on_road=rolled.on_road,
        separation_m=least,
        contact_with=who,
        demand_mps2=np.broadcast_to(effort, size),
    )


def _doomed_by(
    ways: Ways, speed_mps: Array, clock_s: Array, situation: Situation, vehicle: Vehicle, prediction: Prediction
) -> NDArray[np.intp]:
    """For each member the body that it ends up with no room for: closing in on it at its end, in its way, and too near for braking (one
    ahead) or accelerating (one behind) to end that; -1 without. What only puts a collision off is no way out."""
    grip = situation.road.friction * GRAVITY_MPS2
    brake, accelerate = min(-vehicle.acceleration_min_mps2, grip), min(vehicle.acceleration_max_mps2, grip)
    who = np.full(speed_mps.shape, -1, dtype=np.intp)
    s, d = ways.s_m[:, -1], ways.d_m[:, -1]
    for number, body in enumerate(prediction.bodies):
        motion = body.at(clock_s)
        apart = motion.s_m - s
        gap = np.maximum(np.abs(apart) - 0.5 * (body.length_m + vehicle.length_m), 0.0)
        in_way = np.abs(motion.d_m - d) < 0.5 * (body.width_m + vehicle.width_m)
        closing = np.maximum(np.sign(apart) * (speed_mps - motion.speed_s_mps), 0.0)
        late = closing**2 > 2.0 * _ROOM_SHARE * gap * np.where(apart > 0.0, brake, accelerate)
        who[in_way & late] = number
    return who


def _closer(looked: _Looked, k: int, mine: NDArray[np.bool_], path: Starts, situation: Situation, prediction: Prediction) -> Closer:
    """What is in the way of the start `k` of a kind: of its members that car and road allow, the one that comes nearest to being clear."""
    allowed = mine & looked.possible[k] & looked.on_road[k]
    if not allowed.any():
        return Closer.EDGE if (mine & looked.possible[k]).any() else Closer.FRICTION
    best = int(np.argmax(np.where(allowed, looked.separation_m[k], -np.inf)))
    return _closer_of(int(looked.contact_with[k, best]), situation, prediction, float(path.s_m[0]), 0.0)


def _closer_of(who: int, situation: Situation, prediction: Prediction, host_s_m: float, moment_s: float) -> Closer:
    """Front or rear for bodies in the host's way now, else a side car."""
    motion = prediction.bodies[who].at(np.array([moment_s]))
    if abs(float(motion.d_m[0]) - situation.host.d_m) > 0.5 * situation.road.lane_width_m + 0.5:
        return Closer.SIDE
    return Closer.FRONT if float(motion.s_m[0]) > host_s_m else Closer.REAR
