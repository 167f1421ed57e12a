"""How near drives come to everybody else, in one go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.separations import separations


@dataclass(frozen=True, slots=True)
class Nearness:
    """Of so many drives: their tables (drives, 9, n), signed separations (drives, bodies, n) of the host's body from every predicted one
    [m], the deepest of each (drives, bodies), and where those bodies are: their motions as rows, and at the end s, d, speed."""

    tables: Array
    separation_m: Array
    deepest_m: Array
    motion: BodyMotion
    ends: tuple[tuple[float, float, float], ...]


def nearness(trajectories: Sequence[Trajectory], cycle: Cycle) -> Nearness:
    """Of at least one trajectory; all are sampled at the same times."""
    tables = trajectories[0].table[None] if len(trajectories) == 1 else np.array([one.table for one in trajectories])
    return nearness_of(tables, trajectories[0].t_s, cycle)


def nearness_of(tables: Array, t_s: Array, cycle: Cycle) -> Nearness:
    """`nearness` of drives that are tables (drives, 9, n) at these times."""
    road, vehicle = cycle.situation.road, cycle.vehicle
    bodies, rows = cycle.prediction.bodies, cycle.prediction.rows_on(t_s)
    places = rows.s_m
    frame = frame_near(road, float(tables[0, 1, 0]))
    along = tables[:, 1]
    if not road.is_straight:  # who is beyond the frame is far enough away there too; a host near a bend's centre may seem to fly off
        places, along = (np.clip(s, frame.s_min_m, frame.s_max_m) for s in (places, along))
    x, y, yaw = frame.to_plane(places, rows.d_m, rows.heading_rad)
    hosts = frame.to_plane(along, tables[:, 2], tables[:, 3])
    halves = np.array([(0.5 * body.length_m, 0.5 * body.width_m) for body in bodies]).reshape(-1, 2)
    separation = separations(hosts, (x, y, yaw), (0.5 * vehicle.length_m, 0.5 * vehicle.width_m), halves)
    ends = tuple(zip(rows.s_m[:, -1].tolist(), rows.d_m[:, -1].tolist(), rows.speed_s_mps[:, -1].tolist(), strict=True))
    deepest = np.minimum.reduce(separation, axis=-1) if bodies else np.zeros((len(tables), 0))
    return Nearness(tables, separation, deepest, rows, ends)
