"""What goes into a parking program and what comes out: costs by name, physics, collision checks, guess and bounds, solution."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array, non_negative
from mcdas_opt.errors import ParameterError, nearest

Rows = NDArray[np.int64]
CORNERS = 4  # of the body, and of an obstacle as far as a check sees it
WANTED_M = 0.25  # clearance beyond the asked one that the clearance cost still pays for
FORMS = ("half-planes", "duals")
SOLVERS = ("ipopt", "fatrop")


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingCosts:
    """Weights of the costs: seconds per second, per metre, per rad^2 s of steering, per rad^2 of its changes, per gear change, and per

    second spent at the asked clearance (falling with the square to nothing at `WANTED_M` beyond it).
    """

    time: float = 1.0
    path: float = 0.02
    steering: float = 0.01
    smooth: float = 0.02
    gear_changes: float = 0.0
    clearance: float = 0.0

    def __post_init__(self) -> None:
        for item in fields(self):
            non_negative(item.name, getattr(self, item.name))


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


class ParkingPhysics(NamedTuple):
    """What the equations need of the car and of the limits."""

    wheelbase_m: float
    rear_m: float
    front_m: float
    half_width_m: float
    acceleration_mps2: float
    steering_rate_radps: float
    clearance_m: float


@dataclass(slots=True, kw_only=True)
class Checks:
    """m collision checks: in which interval, where in it, against which four vertices, with which separating line to begin."""

    intervals: Rows  # (m,)
    fractions: Array  # (m,) 0: at the interval's first node
    vertices: Array  # (m, 4, 2)
    angles: Array  # (m,) of the normal from obstacle to car
    offsets: Array  # (m,)

    def only(self, rows: NDArray[np.bool_] | Rows) -> Checks:
        return Checks(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})


@dataclass(slots=True, kw_only=True)
class ParkingProgram:
    """Numbers of one program over n intervals: a guess, bounds, and collision checks. A segment is a run of intervals of one length."""

    nodes: Array  # (n + 1, 5) guess
    nodes_low: Array
    nodes_high: Array
    segments: Rows  # (n,) which segment each interval belongs to, 0 .. s - 1
    steps: Array  # (s,) guess of the segments' interval lengths [s]
    steps_low: Array
    steps_high: Array
    checks: Checks


@dataclass(frozen=True, slots=True)
class ParkingSolution:
    """What the solver left; `violation` is measured here, not taken from its word."""

    nodes: Array
    steps: Array  # (n,)
    duration_s: float
    violation: float
    iterations: int
    status: str
    solver: str = "ipopt"
