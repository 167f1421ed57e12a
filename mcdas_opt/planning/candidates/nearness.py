"""How near drives come to everybody else, in one go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.traffic.others import Others
from mcdas_opt.planning.traffic.separations import Rectangles, separations


@dataclass(frozen=True, slots=True)
class Nearness:
    """Of so many drives: their tables (drives, 9, n), signed separations (drives, bodies, n) of the host's body from every predicted one
    [m], the deepest of each (drives, bodies), and where those bodies are."""

    tables: Array
    separation_m: Array
    deepest_m: Array
    others: Others


def nearness(trajectories: Sequence[Trajectory], cycle: Cycle) -> Nearness:
    """Of at least one trajectory; all are sampled at the same times."""
    return nearness_of(np.array([one.table for one in trajectories]), trajectories[0].t_s, cycle)


def nearness_of(tables: Array, t_s: Array, cycle: Cycle) -> Nearness:
    """`nearness` of drives that are tables (drives, 9, n) at these times."""
    vehicle, along = cycle.vehicle, tables[:, 1]
    others = cycle.others_at(t_s, float(along[0, 0]))
    frame = others.frame
    if not frame.road.is_straight:  # a host near a bend's centre may seem to fly off
        along = np.clip(along, frame.s_min_m, frame.s_max_m)
    half = np.array([[0.5 * vehicle.length_m, 0.5 * vehicle.width_m]])
    hosts = Rectangles.of(*frame.to_plane(along, tables[:, 2], tables[:, 3]), half)
    separation = separations(hosts, others.rectangles)
    deepest = np.minimum.reduce(separation, axis=-1) if others.ends else np.zeros((len(tables), 0))
    return Nearness(tables, separation, deepest, others)
