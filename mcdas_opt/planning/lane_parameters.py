"""A situation and a way out, in the numbers that the lane problem asks for: parameters of every node, and a guess."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mcdas_opt.domain.prediction import PredictedBody
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.ocp.lane_mpc import FAR_M
from mcdas_opt.planning.ways import Way

_SETTLING_S = 0.8  # of the guess, from where the host is onto the path
_ROAD_END_GAP_M = 0.5
INTRUSION_M = 0.2  # a body that reaches further than this into a lane is in it


def node_values(
    situation: Situation,
    bodies: Sequence[PredictedBody],
    way: Way,
    times_s: Array,
    guess_s: Array,
    *,
    seats: int,
    friction_share: float,
    clearance_along_m: float,
    clearance_across_m: float,
) -> dict[str, Any]:
    """Name to number or vector (N + 1); the road's curvature is linearised around `guess_s` (N + 1)."""
    road, path = situation.road, way.path
    left_edge, right_edge = _bounds(situation, way)
    values: dict[str, Any] = {
        "kappa": road.curvature_at(guess_s),
        "kappa_slope": (road.curvature_at(guess_s + 1.0) - road.curvature_at(guess_s - 1.0)) / 2.0,
        "kappa_s": guess_s,
        "ref_start_s": path.start_s_m,
        "ref_start_d": path.start_d_m,
        "ref_amplitude": path.amplitude_m,
        "ref_a": path.a_per_m,
        "ref_b": path.b,
        "ref_bend": path.bend_m,
        "ref_bend_s": path.bend_s_m,
        "ref_bend_width": path.bend_width_m,
        "speed_ref": way.speed_mps,
        "grip": friction_share * road.friction * GRAVITY_MPS2,
        "left_edge": left_edge,
        "right_edge": right_edge,
        "road_end": FAR_M if road.road_end_s_m is None else road.road_end_s_m - _ROAD_END_GAP_M,
        **_bumpers(situation, bodies, way, times_s),
    }
    for i in range(seats):
        seat: tuple[Any, ...] = (-FAR_M, 0.0, 2.25, 0.9)  # nobody
        if i < len(bodies):
            body, motion = bodies[i], bodies[i].at(times_s)
            along = 0.5 * body.length_m + clearance_along_m + body.margin_along_m(times_s)
            across = 0.5 * body.width_m + clearance_across_m + body.margin_across_m(times_s)
            seat = (motion.s_m, motion.d_m, along, across)
        values |= dict(zip((f"body{i}_s", f"body{i}_d", f"body{i}_along", f"body{i}_across"), seat, strict=True))
    return values


def _bounds(situation: Situation, way: Way) -> tuple[float, float]:
    """The road's edges; for a way that keeps its lane, the lane's own edge on a side that nobody watches."""
    road, seen = situation.road, situation.coverage
    left, right = road.left_edge_m, road.right_edge_m
    if way.manoeuvre is None:
        centre, half = way.path.start_d_m, 0.5 * road.lane_width_m
        left = left if seen.left else min(left, centre + half)
        right = right if seen.right else max(right, centre - half)
    return left, right


def _bumpers(situation: Situation, bodies: Sequence[PredictedBody], way: Way, times_s: Array) -> dict[str, Array]:
    """The nearest bumpers ahead and behind in the lane that the way ends in, from the time it gets there; far away elsewhere."""
    host, road = situation.host, situation.road
    arrival, target = 0.0, way.path.target_d_m
    if way.manoeuvre is not None:
        crossing = way.path.start_s_m + 0.6 * way.path.length_m
        arrival = max(crossing - host.s_m, 0.0) / max(host.speed_mps, 1.0)
        target = way.manoeuvre.target_d_m
    front, front_speed = np.full_like(times_s, FAR_M), np.zeros_like(times_s)
    rear, rear_speed = np.full_like(times_s, -FAR_M), np.zeros_like(times_s)
    for body in bodies:
        motion = body.at(times_s)
        if abs(float(motion.d_m[0]) - target) - 0.5 * body.width_m > 0.5 * road.lane_width_m - INTRUSION_M:
            continue
        if float(motion.s_m[0]) > host.s_m:
            bumper = motion.s_m - 0.5 * body.length_m
            nearer = bumper < front
            front, front_speed = np.where(nearer, bumper, front), np.where(nearer, motion.speed_s_mps, front_speed)
        else:
            bumper = motion.s_m + 0.5 * body.length_m
            nearer = bumper > rear
            rear, rear_speed = np.where(nearer, bumper, rear), np.where(nearer, motion.speed_s_mps, rear_speed)
    early = times_s < arrival
    return {
        "front_bumper": np.where(early, FAR_M, front),
        "front_speed": front_speed,
        "rear_bumper": np.where(early, -FAR_M, rear),
        "rear_speed": rear_speed,
    }


def guessed_states(situation: Situation, way: Way, vehicle: Vehicle, times_s: Array) -> Array:
    """(N + 1, 6): the way's own path, driven towards its own speed. Dynamically inconsistent on purpose: it only chooses the basin."""
    host = situation.host
    gap = way.speed_mps - host.speed_mps
    rate = np.clip(gap / 2.0, 0.6 * vehicle.acceleration_min_mps2, 0.9 * vehicle.acceleration_max_mps2)
    v = np.maximum(host.speed_mps + np.clip(rate * times_s, min(gap, 0.0), max(gap, 0.0)), 0.0)
    s = host.s_m + np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(times_s))])
    path_d = np.asarray(way.path.d(s))
    d = path_d + (host.d_m - path_d[0]) * np.exp(-times_s / _SETTLING_S)
    psi = np.arctan(np.asarray(way.path.slope(s)))
    return np.column_stack([s, d, psi, v, np.zeros_like(s), np.zeros_like(s)])
