"""A situation and a proposed manoeuvre, in the numbers that the lane problem asks for: parameters of every node, and a guess."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from typing import Any

import numpy as np

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.comfort import ComfortSettings
from mcdas_opt.domain.prediction import BodyMotion, PredictedBody, is_free, sizes_on_road, together
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import HeadwaySettings, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import CROSSING_MPS
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.dynamics.axle_limits import AxleLimits, driving_mps2
from mcdas_opt.ocp.lane_mpc import CENTRE, FAR_M, HEADWAY_HORIZON_S, STEERING_RATE_SHARE
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.front.headway import asked_time_gap_s
from mcdas_opt.planning.lane_problem.bends import mean_curvature
from mcdas_opt.planning.lane_problem.grown_bodies import grown_bodies
from mcdas_opt.situation.passed_in_lane import INTRUSION_M, Passed

_SETTLING_S = 0.8  # of the guess, from where the host is onto the path
_ROAD_END_GAP_M = 0.5
_SLOWEST_MPS = 1.0
_PASSING_SPARE_M = 0.25  # of the distance to one who is passed: the optimiser's bodies are rounded, and so a little wider
_RELEASE_S = 0.6  # of brakes that nobody needs any more
Bumpers = tuple[Array, Array, Array, Array]  # place and speed of one ahead, of one behind (N + 1)


@dataclass(frozen=True, slots=True)
class ObstacleSlots:
    """Everybody who can matter within the horizon, as the problem sees them: their motions on the grid, as rows (J, N + 1), and half their
    grown bodies [m] there, along and across (J, 2, N + 1); at the first node who is where (s, d, speed), how much of the road's length and
    width each takes, and whether he counts in no lane, since he crosses it or is passed within it."""

    bodies: Sequence[PredictedBody]
    motion: BodyMotion
    grown: Array
    first: Sequence[tuple[float, float, float]]
    sizes: Sequence[tuple[float, float]]
    in_no_lane: Sequence[bool]
    _in_lane: dict[float, Bumpers] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __len__(self) -> int:
        return len(self.bodies)

    def bumpers(self, target_d_m: float, situation: Situation, times_s: Array) -> Bumpers:
        """The nearest bumpers ahead and behind in the lane at `target_d_m`, beside where the host is: worked out once."""
        found = self._in_lane.get(target_d_m)
        if found is None:
            found = self._in_lane[target_d_m] = _in_lane(target_d_m, self, situation, times_s)
        return found


def obstacle_slots(
    bodies: Sequence[PredictedBody],
    times_s: Array,
    *,
    along_m: float,
    across_m: float,
    on_foot_m: float = 0.0,
    motion: BodyMotion | None = None,
    passed: Sequence[Passed] = (),
) -> ObstacleSlots:
    """Bodies on the grid (`motion` as rows, where that is known), grown by a clearance and by the uncertainty of their estimates; whoever
    goes along or comes, and is passed, no wider than leaves the host its way."""
    rows = together(bodies, times_s) if motion is None else motion
    first = list(zip(*(row[:, 0].tolist() for row in (rows.s_m, rows.d_m, rows.speed_s_mps)), strict=True))
    sizes = list(zip(*(size[:, 0].tolist() for size in sizes_on_road(bodies, rows.heading_rad[:, :1])), strict=True))
    across = zip(bodies, rows.speed_d_mps[:, 0].tolist(), strict=True)
    ids = {one.track.id for one in passed}
    in_no_lane = [body.id in ids or (abs(v) > CROSSING_MPS and is_free(body)) for body, v in across]
    grown = grown_bodies(bodies, times_s, rows.heading_rad, along_m, across_m, on_foot_m)
    for one in passed:
        for body, (_, across_row) in zip(bodies, grown, strict=True):
            if body.id == one.track.id and not one.stands:
                np.minimum(across_row, 0.5 * one.track.across_m + max(one.gap_m - _PASSING_SPARE_M, 0.0), out=across_row)
    return ObstacleSlots(bodies, rows, grown, first, sizes, in_no_lane)


def vacant_values(slots: Iterable[int]) -> dict[str, float]:
    """Nobody in these slots: name to number."""
    return {name: value for i in slots for name, value in zip(_slot_names(i), (-FAR_M, 0.0, 2.25, 0.9), strict=True)}


def shared_values(situation: Situation, others: ObstacleSlots, *, slots: int, friction_share: float) -> dict[str, Any]:
    """What all candidates of a situation have in common: name to number or vector (N + 1). In the slots that are left is nobody."""
    road = situation.road
    values: dict[str, Any] = {
        "grip": friction_share * road.friction * GRAVITY_MPS2,
        "road_end": FAR_M if road.road_end_s_m is None else road.road_end_s_m - _ROAD_END_GAP_M,
    }
    for i in range(min(len(others), slots)):
        values.update(zip(_slot_names(i), (others.motion.s_m[i], others.motion.d_m[i], *others.grown[i]), strict=True))
    return values | vacant_values(range(len(others), slots))


def slip_values(vehicle: Vehicle, speed_mps: float, friction: float, settings: Settings) -> dict[str, float]:
    """What the problem of a car that slips asks for besides: name to number."""
    jerk = settings.lateral_jerk_mps3 / max(speed_mps, _SLOWEST_MPS) ** 2 * vehicle.wheelbase_m  # [rad/s]
    limits = AxleLimits.of(Chassis.of(vehicle), friction)
    return {
        CENTRE: vehicle.centre_m,
        STEERING_RATE_SHARE: min(max(settings.steering_rate_share, jerk / vehicle.steering_rate_max_radps), 1.0),
        **asdict(limits),
        "brakes_by_load": settings.friction_share * limits.brakes_by_load,  # the reserve is for turning: straight on, none
    }


def nearest_values(others: ObstacleSlots, slots: int, proposed: Proposed, guess_s: Array) -> dict[str, Any]:
    """Where there are more bodies than slots: at every node those that are nearest to where the candidate is guessed to be then."""
    rows, (along, across) = others.motion, others.grown.swapaxes(0, 1)
    guess_d, _ = proposed.path.d_and_slope(guess_s)
    gaps = np.maximum(np.abs(rows.s_m - guess_s) - along, 0.0), np.maximum(np.abs(rows.d_m - guess_d) - across, 0.0)
    order = np.argsort(np.hypot(*gaps), axis=0, kind="stable")
    nearest = np.sort(order[:slots], axis=0)  # a body keeps its slot as long as the same are near
    columns = (each[nearest, np.arange(guess_s.size)] for each in (rows.s_m, rows.d_m, along, across))
    return {name: row for i, values in enumerate(zip(*columns, strict=True)) for name, row in zip(_slot_names(i), values, strict=True)}


@cache
def _slot_names(i: int) -> tuple[str, str, str, str]:
    return f"body{i}_s", f"body{i}_d", f"body{i}_along", f"body{i}_across"


def proposal_values(
    situation: Situation,
    vehicle: Vehicle,
    others: ObstacleSlots,
    proposed: Proposed,
    times_s: Array,
    guess_s: Array,
    headway: HeadwaySettings | None = None,
    comfort: ComfortSettings | None = None,
) -> dict[str, Any]:
    """What is the candidate's own; the road's curvature is linearised around `guess_s` (N + 1)."""
    road, path = situation.road, proposed.path
    bent = not road.is_straight
    return {
        "kappa": road.curvature_at(guess_s) if bent else 0.0,
        "kappa_slope": (road.curvature_at(guess_s + 1.0) - road.curvature_at(guess_s - 1.0)) / 2.0 if bent else 0.0,
        "kappa_nose": mean_curvature(road, guess_s, 0.5 * vehicle.length_m) if bent else 0.0,
        "kappa_tail": mean_curvature(road, guess_s, -0.5 * vehicle.length_m) if bent else 0.0,
        "kappa_s": guess_s,
        "ref_start_s": path.start_s_m,
        "ref_start_d": path.start_d_m,
        "ref_amplitude": path.amplitude_m,
        "ref_a": path.a_per_m,
        "ref_b": path.b,
        "ref_bend": path.bend_m,
        "ref_bend_s": path.bend_s_m,
        "ref_bend_width": path.bend_width_m,
        "speed_ref": proposed.speed_mps if proposed.speeds_mps is None else proposed.speeds_mps,
        **_bounds(situation, vehicle, proposed, guess_s),
        **_end_ahead(situation, vehicle, proposed),
        **_headway(situation, vehicle, others, proposed, times_s, headway or HeadwaySettings()),
        **_comfort(situation, vehicle, proposed, times_s, comfort or ComfortSettings()),
    }


def _bounds(situation: Situation, vehicle: Vehicle, proposed: Proposed, guess_s: Array) -> dict[str, Any]:
    """The road's edges, linear around `guess_s` where they change along it; for a candidate that keeps its lane, the lane's own edge on a
    side that nobody watches."""
    road = situation.road
    edges = road.steered_edges
    left: Any = road.left_edge_m
    right: Any = road.right_edge_m
    slopes: dict[str, Any] = {}
    if edges is not None:
        half = 0.5 * vehicle.length_m
        tail, middle, nose = ((edges.left(s), edges.right(s)) for s in (guess_s - half, guess_s, guess_s + half))
        left, right = (
            least.reduce(side) for least, side in zip((np.minimum, np.maximum), zip(tail, middle, nose, strict=True), strict=True)
        )
        left_slope, right_slope = ((after - before) / vehicle.length_m for before, after in zip(tail, nose, strict=True))
        slopes = {"left_slope": left_slope, "right_slope": right_slope, "edge_s": guess_s}
    if proposed.manoeuvre is None:
        centre = proposed.path.start_d_m
        half = 0.5 * road.lane_width_at(road.lane_of(centre, situation.host.s_m), situation.host.s_m)
        left = left if situation.sees_lane(Side.LEFT) else np.minimum(left, centre + half)
        right = right if situation.sees_lane(Side.RIGHT) else np.maximum(right, centre - half)
    return {"left_edge": left, "right_edge": right, **slopes}


def _end_ahead(situation: Situation, vehicle: Vehicle, proposed: Proposed) -> dict[str, Any]:
    """Who keeps a lane that ends stops before, nothing where it is too narrow already; and before a stop line, who does not
    escape from somebody."""
    road, host, line_m = situation.road, situation.host, situation.stop_line_s_m
    front_m, ends_m = host.s_m + 0.5 * vehicle.length_m + _ROAD_END_GAP_M, []
    if road.lanes and proposed.manoeuvre is None:
        ends_m.append(road.ends_m(road.lane_of(proposed.path.start_d_m, host.s_m), host.s_m, vehicle.width_m))
    if line_m is not None and proposed.mode not in (Mode.ACCELERATE, Mode.EVADE):
        ends_m.append(line_m if road.road_end_s_m is None else min(line_m, road.road_end_s_m))
    end = min((end for end in ends_m if end > front_m), default=None)
    return {} if end is None else {"road_end": min(end - _ROAD_END_GAP_M, FAR_M)}


def _headway(
    situation: Situation, vehicle: Vehicle, others: ObstacleSlots, proposed: Proposed, times_s: Array, headway: HeadwaySettings
) -> dict[str, Any]:
    """The bumpers, and the time gap to keep from the one ahead. A follower who keeps his distance himself holds nobody back."""
    host, (arrival, bumpers) = situation.host, _bumpers(situation, others, proposed, times_s)
    if not proposed.keeps_room_behind:
        bumpers["rear_bumper"] = np.full_like(times_s, -FAR_M)
    time_gap = asked_time_gap_s(
        bumpers["front_bumper"] - host.s_m - 0.5 * vehicle.length_m,
        bumpers["front_speed"],
        host.speed_mps,
        times_s,
        headway,
        closing_s=HEADWAY_HORIZON_S,
        since_s=arrival,
    )
    return {**bumpers, "standstill": headway.standstill_m, "time_gap": time_gap}


def _comfort(situation: Situation, vehicle: Vehicle, proposed: Proposed, times_s: Array, comfort: ComfortSettings) -> dict[str, Any]:
    """What the host's speed makes comfortable, reached from its acceleration with the jerk that is; else what the driven axle can hold.
    Braking that is harder may be let go of at once, within `_RELEASE_S`: ISO 15622 bounds the jerk with which braking is built up."""
    if not proposed.is_comfortable:
        driving = driving_mps2(vehicle, situation.road.friction)
        return {
            "most_acceleration": FAR_M if driving == vehicle.acceleration_max_mps2 else driving,
            "most_braking": FAR_M,
            "most_jerk": FAR_M,
        }
    limits, a = comfort.limits(situation.host.speed_mps), situation.host.acceleration_mps2
    change = limits.jerk_mps3 * times_s
    release = max(-a / _RELEASE_S, limits.jerk_mps3) if -a > limits.braking_mps2 else limits.jerk_mps3
    sooner = (release - limits.jerk_mps3) * np.minimum(times_s, _RELEASE_S)
    return {
        "most_acceleration": _reached(limits.acceleration_mps2, a, change + sooner),
        "most_braking": _reached(limits.braking_mps2, -a, change),
        "most_jerk": np.where(times_s < _RELEASE_S, release, limits.jerk_mps3),
    }


def _reached(limit: float, now: float, change: Array) -> Array:
    """From `now` up to a limit, or back to it, by no more than `change`."""
    return np.minimum(limit, now + change) if now <= limit else np.maximum(limit, now - change)


def _bumpers(situation: Situation, others: ObstacleSlots, proposed: Proposed, times_s: Array) -> tuple[float, dict[str, Array]]:
    """When the candidate gets to the lane that it ends in [s], and the nearest bumpers ahead and behind there; far away before."""
    host = situation.host
    arrival, target = 0.0, proposed.path.target_d_m
    if proposed.manoeuvre is not None:
        crossing = proposed.path.start_s_m + 0.6 * proposed.path.length_m
        arrival = max(crossing - host.s_m, 0.0) / max(host.speed_mps, 1.0)
        target = proposed.manoeuvre.target_d_m
    front, front_speed, rear, rear_speed = others.bumpers(target, situation, times_s)
    if arrival > 0.0:
        early = times_s < arrival
        front, rear = np.where(early, FAR_M, front), np.where(early, -FAR_M, rear)
    return arrival, {"front_bumper": front, "front_speed": front_speed, "rear_bumper": rear, "rear_speed": rear_speed}


def _in_lane(target_d_m: float, others: ObstacleSlots, situation: Situation, times_s: Array) -> Bumpers:
    host, road = situation.host, situation.road
    lane = road.lane_of(target_d_m, host.s_m)
    here = road.lane_width_at(lane, host.s_m)
    ahead: list[tuple[Array, Array]] = []
    behind: list[tuple[Array, Array]] = []
    for i, ((s, d, _), (length, its_width), in_no_lane) in enumerate(zip(others.first, others.sizes, others.in_no_lane, strict=True)):
        if in_no_lane or abs(d - target_d_m) - 0.5 * its_width > 0.5 * (road.lane_width_at(lane, s) or here) - INTRUSION_M:
            continue
        if s > host.s_m:
            ahead.append((others.motion.s_m[i] - 0.5 * length, others.motion.speed_s_mps[i]))
        else:
            behind.append((others.motion.s_m[i] + 0.5 * length, others.motion.speed_s_mps[i]))
    return *_nearest(ahead, FAR_M, np.less, times_s), *_nearest(behind, -FAR_M, np.greater, times_s)


def _nearest(bumpers: Sequence[tuple[Array, Array]], far: float, is_nearer: Any, times_s: Array) -> tuple[Array, Array]:
    """Place and speed of the nearest bumper at every time; `far` and standing where there is none."""
    place, speed = np.full(times_s.shape, far), np.zeros(times_s.shape)
    for bumper, its_speed in bumpers:
        nearer = is_nearer(bumper, place)
        place, speed = np.where(nearer, bumper, place), np.where(nearer, its_speed, speed)
    return place, speed


def guessed_states(situation: Situation, proposed: Proposed, vehicle: Vehicle, times_s: Array) -> Array:
    """(N + 1, 6): the candidate's path, driven towards its speed. Dynamically inconsistent on purpose: it only chooses the basin."""
    host = situation.host
    gap = proposed.speed_mps - host.speed_mps
    rate = min(max(gap / 2.0, 0.6 * vehicle.acceleration_min_mps2), 0.9 * driving_mps2(vehicle, situation.road.friction))
    gained = np.minimum(np.maximum(rate * times_s, min(gap, 0.0)), max(gap, 0.0))
    x = np.zeros((times_s.size, 6))
    s, d, psi, v = x[:, 0], x[:, 1], x[:, 2], x[:, 3]
    v[:] = np.maximum(host.speed_mps + gained, 0.0) if proposed.speeds_mps is None else proposed.speeds_mps
    s[0] = host.s_m
    s[1:] = host.s_m + np.cumsum(0.5 * (v[1:] + v[:-1]) * (times_s[1:] - times_s[:-1]))
    path_d, slope = proposed.path.d_and_slope(s)
    d[:] = path_d + (host.d_m - path_d[0]) * np.exp(-times_s / _SETTLING_S)
    np.arctan(slope, out=psi)
    return x
