"""What a driven manoeuvre costs, in the weights that the program minimises: ways of different gears are compared by it."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingTrajectory
from mcdas_opt.parking.program.records import COSTS, WANTED_M, ParkingCosts
from mcdas_opt.parking.world import World


def worth(trajectory: ParkingTrajectory, costs: ParkingCosts, world: World, clearance_m: float) -> float:
    """The cost [s]; with the default weights simply the duration, for its other terms are there to smooth."""
    if costs == COSTS["time"]:
        return trajectory.duration_s
    dt = np.diff(trajectory.t_s)
    value = costs.time * trajectory.duration_s + costs.path * trajectory.path_m + costs.gear_changes * trajectory.gear_changes
    middle = 0.5 * (trajectory.steering_rad[1:] + trajectory.steering_rad[:-1])
    value += costs.steering * float(np.sum(dt * middle**2))
    if costs.clearance > 0.0:
        beyond = np.clip(world.clearance(trajectory.poses[:-1]) - clearance_m, 0.0, WANTED_M)
        value += costs.clearance * float(np.sum(dt * (1.0 - beyond / WANTED_M) ** 2))
    return value
