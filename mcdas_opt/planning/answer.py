"""A way out that was solved and judged."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.plan import Attempt, Candidate
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.planning.ways import Way

_STEADY_MPS2 = 0.3  # a plan that stays under it over its first second neither brakes nor accelerates


@dataclass(frozen=True, slots=True)
class Answer:
    """The way, what is said of it among the candidates, its drive and the judge's verdict."""

    way: Way
    candidate: Candidate
    trajectory: Trajectory
    verdict: Verdict

    @property
    def mode(self) -> Mode:
        """What it does: of one that keeps its lane named by its acceleration over the first second, not by what it was meant to be."""
        way, trajectory = self.way, self.trajectory
        if way.side is not Side.NONE or way.mode in (Mode.HOLD, Mode.CRUISE, Mode.PARK):
            return way.mode
        first = trajectory.acceleration_mps2[trajectory.t_s <= 1.0 + 1e-9]
        strongest = float(first[int(np.argmax(np.abs(first)))])
        if abs(strongest) < _STEADY_MPS2:
            return Mode.HOLD
        return Mode.ACCELERATE if strongest > 0.0 else Mode.BRAKE

    @property
    def shortfall_m(self) -> float:
        """The room that was short of passing: the deepest overlap; infinite where something else is wrong."""
        if not self.verdict.only_collides:
            return math.inf
        return max((violation.limit - violation.value for violation in self.verdict.violations), default=0.0)

    def attempt(self) -> Attempt:
        return Attempt(
            name=self.way.name,
            mode=self.mode,
            side=self.way.side,
            trajectory=self.trajectory,
            verdict=self.verdict,
            reference=self.way.manoeuvre,
        )
