"""What one planning cycle leaves for the next, in one typed record."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status
from mcdas_opt.planning.manoeuvre import Manoeuvre

M = TypeVar("M")


@dataclass(frozen=True, slots=True, kw_only=True)
class PreviousPlan:
    """A judged trajectory that may be driven on, since when it is driven [s], and what it does."""

    trajectory: Trajectory
    time_s: float
    mode: Mode
    side: Side

    @classmethod
    def of(cls, plan: Plan) -> PreviousPlan | None:
        """None of a plan that no judge passed."""
        if plan.status is Status.UNAVOIDABLE or not plan.verdict.passed:
            return None
        return cls(trajectory=plan.trajectory, time_s=plan.time_s, mode=plan.mode, side=plan.side)


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowerReaction:
    """The follower-reaction assumption: who is relied on to brake, and since when [s]. Who has had the time to respond has responded."""

    names: tuple[str, ...]
    since_s: float

    def __str__(self) -> str:
        return " and ".join(self.names)


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory:
    """`Memory()` is that of a planner which begins.

    `chosen` names the candidate that was chosen last; `least_cost` is the least that one was chosen for since the candidates were last
    compared. `warm_starts` is the mark of the solver's workspace that this memory goes with: one with another mark begins cold.
    """

    situation: Situation | None = None
    previous: PreviousPlan | None = None
    side: Side = Side.NONE
    alert: Alert = Alert.NONE
    assessment: Assessment | None = None
    active: Manoeuvre | None = None
    chosen: str = ""
    least_cost: float | None = None
    reaction: FollowerReaction | None = None
    warm_starts: object = None

    @property
    def is_empty(self) -> bool:
        return self.situation is None


def remembered(plan: Plan, situation: Situation) -> Memory:
    """What a plan that leaves means for the next cycle: the method's own part, and what holds for all of them."""
    own = plan.memory if isinstance(plan.memory, Memory) else Memory()
    return replace(own, situation=situation, previous=PreviousPlan.of(plan), side=plan.side, alert=plan.alert)


def carried(previous: Plan | None, kind: type[M]) -> M | None:
    """What a method left in its last plan for itself, where that is of this kind."""
    return previous.memory if previous is not None and isinstance(previous.memory, kind) else None
