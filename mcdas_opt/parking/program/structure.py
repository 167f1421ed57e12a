"""A manoeuvre changed: a phase left out or put in, a finer grid, a driven trajectory as a guess. The program bridges what is missing."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.parking.program.collision_checks import PER_INTERVAL, Place
from mcdas_opt.parking.program.manoeuvre import INTERVAL_S, Manoeuvre, node_poses

_LEAST = 8  # intervals of a run


def phases(manoeuvre: Manoeuvre) -> list[tuple[int, int]]:
    """(first, end) intervals of every phase; the standstill before it belongs to it."""
    starts, gear, stand = [0], 0.0, None
    for k, now in enumerate(manoeuvre.gears):
        if now == 0.0:
            stand = k if stand is None else stand
            continue
        if gear not in (0.0, now):
            starts.append(k if stand is None else stand)
        gear, stand = float(now), None
    return list(pairwise([*starts, len(manoeuvre.steps)]))


def phase_lengths(manoeuvre: Manoeuvre) -> list[float]:
    """Metres driven in every phase."""
    driven = manoeuvre.distances
    return [float(driven[a:b].sum()) for a, b in phases(manoeuvre)]


def without(manoeuvre: Manoeuvre, phase: int) -> Manoeuvre:
    """A phase left out; its neighbours, of one gear, become one. Needs two phases at least."""
    cuts = phases(manoeuvre)
    first, end = cuts[phase]
    keep = np.ones(len(manoeuvre.steps), dtype=np.bool_)
    keep[first:end] = False
    last = end == len(keep)
    nodes = np.concatenate([manoeuvre.nodes[:-1][keep], manoeuvre.nodes[first : first + 1] if last else manoeuvre.nodes[-1:]])
    if first == 0:
        nodes[0] = manoeuvre.nodes[0]
    if last:
        nodes[-1] = manoeuvre.nodes[-1]
    return Manoeuvre(nodes, manoeuvre.steps[keep], manoeuvre.gears[keep], manoeuvre.segments[keep])


def in_pieces(manoeuvre: Manoeuvre, intervals: int) -> Manoeuvre:
    """Interval lengths free every so many intervals: switching times need not lie on an even grid."""
    segments = np.zeros(len(manoeuvre.steps))
    number = run = 0
    for k in range(1, len(segments)):
        run += 1
        if manoeuvre.segments[k] != manoeuvre.segments[k - 1] or run >= intervals:
            number, run = number + 1, 0
        segments[k] = number
    return replace(manoeuvre, segments=segments)


def finer(case: ParkingCase, manoeuvre: Manoeuvre) -> Manoeuvre:
    """Every interval halved; what it drives stays."""
    poses, _ = node_poses(case, manoeuvre, 2)
    nodes = np.empty((2 * len(manoeuvre.steps) + 1, manoeuvre.nodes.shape[1]))
    nodes[0::2] = manoeuvre.nodes
    nodes[1::2, :3] = poses[:, 1]
    nodes[1::2, 3:] = 0.5 * (manoeuvre.nodes[:-1, 3:] + manoeuvre.nodes[1:, 3:])
    steps, gears, segments = (np.repeat(column, 2) for column in (0.5 * manoeuvre.steps, manoeuvre.gears, manoeuvre.segments))
    return Manoeuvre(nodes, steps, gears, segments)


def finer_places(checked: frozenset[Place]) -> frozenset[Place]:
    """Where the checks of a manoeuvre lie once its intervals are halved."""
    half = PER_INTERVAL // 2
    return frozenset((2 * k + point // half, polygon, 2 * (point % half)) for k, polygon, point in checked)


def from_trajectory(case: ParkingCase, trajectory: ParkingTrajectory) -> Manoeuvre:
    """A driven trajectory as a guess: each run of one gear evenly cut, each rest one interval."""
    t, v = trajectory.t_s, trajectory.speed_mps
    rate = case.vehicle.steering_rate_max_radps
    sign = np.sign(np.where(np.abs(v[1:] + v[:-1]) > 1e-6, v[1:] + v[:-1], 0.0))
    cuts = [0, *(np.flatnonzero(np.diff(sign) != 0.0) + 1).tolist(), len(sign)]
    times, steps, gears, segments = [], [], [], []
    for number, (a, b) in enumerate(pairwise(cuts)):
        length = float(t[b] - t[a])
        count = max(_LEAST, int(np.ceil(length / INTERVAL_S))) if sign[a] else 1
        times.append(t[a] + length * np.arange(count) / count)
        steps.append(np.full(count, max(length / count, 1e-3)))
        gears.append(np.full(count, sign[a]))
        segments.append(np.full(count, number))
    at = np.append(np.concatenate(times), t[-1])
    columns = (trajectory.x_m, trajectory.y_m, np.unwrap(trajectory.heading_rad), v, trajectory.steering_rad)
    nodes = np.column_stack([np.interp(at, t, column) for column in columns])
    nodes[0, 4] = case.start_steering_rad
    stands = Manoeuvre(nodes, np.concatenate(steps), np.concatenate(gears), np.concatenate(segments))
    if stands.gears[0] == 0.0:
        return stands
    turn_s = max(abs(float(trajectory.steering_rad[0]) - case.start_steering_rad) / rate, 1e-3)
    return Manoeuvre(
        np.vstack([nodes[:1], nodes]),
        np.append(turn_s, stands.steps),
        np.append(0.0, stands.gears),
        np.append(0, stands.segments + 1),
    )
