"""Lane departure: a drive that was to keep its lane, and does not."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.cycle import Cycle

_most, _least = np.maximum.reduce, np.minimum.reduce
_MARKING_M = 0.15  # a body that crosses the marking by less still keeps its lane


def departure(trajectory: Trajectory, proposed: Proposed, cycle: Cycle) -> Side:
    """Where a drive that was to keep its lane does not: its body crosses the marking to a side that nobody watches, or by half its width,
    and by more than it was to.

    None where it keeps the lane, or was to leave it. A car that begins beyond the marking is let back in.
    """
    if proposed.side is not Side.NONE:
        return Side.NONE
    situation, vehicle = cycle.situation, cycle.vehicle
    road, s = situation.road, situation.host.s_m
    centre, psi, d = proposed.path.start_d_m, trajectory.heading_rad, trajectory.d_m
    half = 0.5 * road.lane_width_at(road.lane_of(centre, s), s)
    turned = max(_most(psi), -_least(psi))
    if max(_most(d) - centre, centre - _least(d)) + 0.5 * (vehicle.width_m + vehicle.length_m * turned) < half:
        return Side.NONE  # well within it
    reach = 0.5 * vehicle.width_m * np.cos(psi) + 0.5 * vehicle.length_m * np.abs(np.sin(psi))
    offset, aside = d - centre, proposed.path.target_d_m - centre
    found = Side.NONE
    for side, over in ((Side.LEFT, offset + reach - half - max(aside, 0.0)), (Side.RIGHT, reach - offset - half - max(-aside, 0.0))):
        watched = situation.sees_lane(side)
        room = 0.5 * vehicle.width_m if watched else _MARKING_M
        if float(over.max()) > max(room, float(over[0]) + _MARKING_M):
            if not watched:
                return side
            found = found if found is not Side.NONE else side
    return found
