"""What goes into a parking program and what comes out: physics, collision checks, guess and bounds, solution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array

Rows = NDArray[np.int64]
CORNERS = 4  # of the body, and of an obstacle as far as a check sees it
FORMS = ("half-planes", "duals")
SOLVERS = ("ipopt", "fatrop")


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

    def only(self, rows: Rows) -> Checks:
        """Some of the checks, in this order."""
        return Checks(
            intervals=self.intervals[rows],
            fractions=self.fractions[rows],
            vertices=self.vertices[rows],
            angles=self.angles[rows],
            offsets=self.offsets[rows],
        )


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
    violation: float
    iterations: int
    status: str

    @property
    def duration_s(self) -> float:
        return float(self.steps.sum())
