"""What one planning cycle leaves for the next, in one typed record."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TypeVar

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import STRETCH_M
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vocabulary import Alert, Mode, Sector, Side, Status
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.traffic.observed import Observed
from mcdas_opt.situation.assess import CLOCK_DIGITS

M = TypeVar("M")


_OLDEST_S = 10.0  # no plan is as long: the clock has jumped, or nobody has asked since


@dataclass(frozen=True, slots=True, kw_only=True)
class PreviousPlan:
    """A judged trajectory that may be driven on, for how long it has been driven [s], and what it does."""

    trajectory: Trajectory
    mode: Mode
    side: Side
    age_s: float = 0.0

    @classmethod
    def of(cls, plan: Plan) -> PreviousPlan | None:
        """None of a plan that no judge passed."""
        if plan.status is Status.UNAVOIDABLE or not plan.verdict.passed:
            return None
        return cls(trajectory=plan.trajectory, mode=plan.mode, side=plan.side)


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowerReaction:
    """The follower-reaction assumption: who is relied on to brake, and for how long [s]. Who has had the time to respond has responded."""

    names: tuple[str, ...]
    age_s: float = 0.0

    def __str__(self) -> str:
        return " and ".join(self.names)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportedMode:
    """What the last plan was reported as and since when [s], with what was known then: who was there, and what was foreseen of them besides
    going on as they do."""

    mode: Mode
    side: Side
    status: Status
    threats: frozenset[Sector]
    tracks: frozenset[str]
    foreseen: frozenset[str]
    age_s: float = 0.0

    def is_news_after(self, before: ReportedMode) -> bool:
        """Whether somebody is there who was not, something else threatens, or the plan is to another side."""
        return (self.side, self.threats) != (before.side, before.threats) or not self.tracks <= before.tracks


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory:
    """What one cycle leaves: places along the road are counted from `origin_m`, times from when `situation` was given. `Memory()` is that
    of a planner which begins.

    `chosen` names the candidate that was chosen last; `least_cost` is the least that one was chosen for since the candidates were last
    compared. `warm_starts` is the mark of the solver's workspace that this memory goes with: one with another mark begins cold.
    """

    situation: Situation | None = None
    origin_m: float = 0.0
    elapsed_s: float = 0.0  # since then, once it is seen from a later cycle
    previous: PreviousPlan | None = None
    side: Side = Side.NONE
    alert: Alert = Alert.NONE
    reported: ReportedMode | None = None
    assessment: Assessment | None = None
    active: Manoeuvre | None = None
    chosen: str = ""
    least_cost: float | None = None
    reaction: FollowerReaction | None = None
    observed: Observed = field(default_factory=Observed)
    warm_starts: object = None

    @property
    def is_empty(self) -> bool:
        return self.situation is None

    def seen_by(self, later: Situation) -> Memory:
        """The same for the cycle of a situation; an empty one where that is not later, or far later.

        A drive's origin is the whole metre at which it begins, and stays for a kilometre: so numbers are small wherever a car drives, they
        are the same in a scene moved by whole metres, and what is remembered of a road, or of the last solve, serves for that long.
        """
        here_m = float(math.floor(later.host.s_m))
        if self.situation is None:
            return Memory(origin_m=here_m)
        elapsed_s = round(later.time_s - self.situation.time_s, CLOCK_DIGITS)
        if not 0.0 < elapsed_s <= _OLDEST_S:
            return Memory(origin_m=here_m)
        origin_m = self.origin_m if abs(here_m - self.origin_m) <= STRETCH_M else here_m
        by_m, previous, reaction = origin_m - self.origin_m, self.previous, self.reaction
        if previous is not None:
            previous = replace(previous, trajectory=previous.trajectory.seen_from(by_m), age_s=previous.age_s + elapsed_s)
        return replace(
            self,
            origin_m=origin_m,
            elapsed_s=elapsed_s,
            previous=previous,
            active=None if self.active is None else self.active.seen_from(by_m),
            observed=self.observed.seen_from(by_m),
            reaction=None if reaction is None else replace(reaction, age_s=reaction.age_s + elapsed_s),
            warm_starts=None if by_m else self.warm_starts,  # places in the solver's workspace are not moved
        )


def carried(previous: Plan | None, kind: type[M]) -> M | None:
    """What a method left in its last plan for itself, where that is of this kind."""
    return previous.memory if previous is not None and isinstance(previous.memory, kind) else None
