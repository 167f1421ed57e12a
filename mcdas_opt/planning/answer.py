"""A way out that was solved and judged."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.plan import Attempt, Candidate
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.planning.ways import Way, in_lane_mode


@dataclass(frozen=True, slots=True)
class Answer:
    """The way, what is said of it among the candidates, its drive and the judge's verdict."""

    way: Way
    candidate: Candidate
    trajectory: Trajectory
    verdict: Verdict

    @property
    def mode(self) -> Mode:
        return self.way.mode if self.way.side is not Side.NONE else in_lane_mode(self.trajectory, self.way)

    def attempt(self) -> Attempt:
        return Attempt(
            name=self.way.name,
            mode=self.mode,
            side=self.way.side,
            trajectory=self.trajectory,
            verdict=self.verdict,
            reference=self.way.manoeuvre,
        )
