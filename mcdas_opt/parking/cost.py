"""What a parking manoeuvre costs: weights by name, and the cost of a driven trajectory in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.parking import ParkingTrajectory
from mcdas_opt.domain.rules import non_negative, require
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.parking.world import World

WANTED_M = 0.25  # clearance beyond the asked one that the clearance cost still pays for


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingCosts:
    """Weights of the costs. A second at the asked clearance costs `clearance`, one farther off less, and nothing from `WANTED_M` on."""

    time: float = 1.0  # per second
    path: float = 0.02  # per metre
    steering: float = 0.01  # per rad^2 s of steering
    smooth: float = 0.02  # per rad^2 of its changes
    gear_changes: float = 0.0  # each
    clearance: float = 0.0

    def __post_init__(self) -> None:
        for name, weight in (("time", self.time), ("path", self.path), ("steering", self.steering), ("smooth", self.smooth)):
            non_negative(name, weight)
        require(self, non_negative, "gear_changes", "clearance")

    @property
    def of_the_program(self) -> tuple[float, float, float, float, float]:
        """Time, path, steering, its changes, clearance: what the program's equations weigh. It never changes gears."""
        return self.time, self.path, self.steering, self.smooth, self.clearance


COSTS = {
    "time": ParkingCosts(),
    "path": ParkingCosts(time=0.2, path=2.0),
    "gear-changes": ParkingCosts(gear_changes=8.0),
    "steering": ParkingCosts(time=0.5, steering=2.0, smooth=3.0),
    "clearance": ParkingCosts(clearance=2.0),
}


def costs_named(name: str) -> ParkingCosts:
    """The weights called `time`, `path`, `gear-changes`, `steering` or `clearance`; raises `ParameterError` for another name."""
    if name not in COSTS:
        raise ParameterError("cost", name, f"is unknown; {nearest(name, COSTS)}")
    return COSTS[name]


def trajectory_cost(trajectory: ParkingTrajectory, costs: ParkingCosts, world: World, clearance_m: float) -> float:
    """The cost [s], by which manoeuvres of different gears are compared; with the default weights the duration alone."""
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
