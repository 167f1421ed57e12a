"""The fallback ladder: what answers when a method has no plan that passes, or none with a safe end."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from mcdas_opt.domain.plan import Candidate, Plan
from mcdas_opt.domain.vocabulary import Alert, Status
from mcdas_opt.planning.candidate import Checked, Continuation
from mcdas_opt.planning.candidates.continuation import to_safe_end
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.fallback.least_severe import least_severe
from mcdas_opt.planning.memory import FollowerReaction, Memory
from mcdas_opt.planning.order import FALLBACK, HOST_REFUSED, Rung
from mcdas_opt.planning.proposals.unwatched import begins_unwatched
from mcdas_opt.planning.reporting.reliance import reliance_in_words, told_of_followers
from mcdas_opt.planning.rungs.previous_plan import NAME as REMAINDER
from mcdas_opt.planning.rungs.previous_plan import previous_plan


@dataclass(frozen=True, slots=True, kw_only=True)
class NothingPasses:
    """A method's answer where it has no plan: why, what it tried, what of that was driven and failed, and its memory."""

    reason: str
    candidates: tuple[Candidate, ...] = ()
    iterations: int = 0
    failed: tuple[Checked, ...] = field(default=(), repr=False)
    memory: Memory = field(default_factory=Memory, repr=False)


_LASTS_S = 1.0  # the rest of a plan that is over sooner passes whatever comes then
_ROUNDING_S = 1e-6
_GLITCH_S = 0.25  # a host's state that cannot be for no longer is a glitch: the previous plan goes on


def host_refused(cycle: Cycle, fault: str, faulty_s: float) -> Plan:
    """The answer to a host's state that cannot be, the cycle's being one that can: in a glitch the fallback as it is, then a stop in
    the lane, judged, and only where that does not pass the others."""
    refused = NothingPasses(reason=f"the host's state cannot be: {fault}", memory=replace(cycle.memory, warm_starts=None))
    return fall_back(cycle, refused, FALLBACK if faulty_s <= _GLITCH_S else HOST_REFUSED)


def fall_back(cycle: Cycle, refused: NothingPasses, order: tuple[Rung, ...] = FALLBACK) -> Plan:
    """A plan that passed (status `fallback`), else the least severe (`unavoidable`); the reason says what was refused before.

    Of the drives that pass, the first that comes to a safe end; where none does, the first that lasts for long enough to say something.
    Steering into a lane that nobody watches from behind passes only where nothing else does and all else is clearly more severe.
    """
    rows: list[Candidate] = []
    failed: list[Checked] = []
    lasting_s = min(_LASTS_S, float(cycle.settings.grid.times_s[-1]))
    first: tuple[Checked, Continuation] | None = None
    for checked in (one for rung in order for one in rung(cycle, rows)):
        if not checked.verdict.passed or begins_unwatched(cycle, checked.proposed.side):
            failed.append(checked)
            continue
        continued = to_safe_end(checked.trajectory, checked.verdict, cycle)
        if continued.is_sound:
            return _passed(cycle, refused, rows, checked, continued)
        if checked.trajectory.t_s[-1] >= lasting_s - _ROUNDING_S:
            first = first or (checked, continued)
    if first is not None:
        return _passed(cycle, refused, rows, *first)
    checked, why, reaction = least_severe(failed, refused.failed, cycle)
    if checked.verdict.passed:
        continued = to_safe_end(checked.trajectory, checked.verdict, cycle)
        return replace(_passed(cycle, refused, rows, checked, continued), reason=f"{why}; before: {refused.reason}")
    as_it_is = Continuation(checked.trajectory, checked.verdict, None)
    plan = _plan(cycle, refused, rows, checked, as_it_is, reaction)
    return replace(plan, status=Status.UNAVOIDABLE, reason=f"{why}; before: {refused.reason}")


def remainder_instead(cycle: Cycle, plan: Plan) -> Plan:
    """Of a plan that passes but comes to no safe end: the remainder of the previous one where that still does, else the plan as a fallback
    that says that it does not."""
    rows: list[Candidate] = []
    for checked in previous_plan(cycle, rows):
        continued = to_safe_end(checked.trajectory, checked.verdict, cycle)
        if continued.is_sound:
            memory = plan.memory if isinstance(plan.memory, Memory) else cycle.memory
            refused = NothingPasses(
                reason="no candidate with a safe end", candidates=plan.candidates, iterations=plan.iterations, memory=memory
            )
            return _passed(cycle, refused, rows, checked, continued)
    reason = f"{plan.reason}; passes for {plan.trajectory.t_s[-1]:.1f} s, but comes to no safe end"
    return replace(plan, status=Status.FALLBACK, warning=True, reason=reason)


def _passed(cycle: Cycle, refused: NothingPasses, rows: list[Candidate], checked: Checked, continued: Continuation) -> Plan:
    reaction = cycle.memory.reaction if checked.proposed.name == REMAINDER else None
    told = told_of_followers(continued, cycle)
    plan = _plan(cycle, refused, rows, checked, told, reaction)
    return replace(plan, reason=f"{checked.proposed.name} instead of: {refused.reason}{reliance_in_words(told.end, cycle)}")


def _plan(
    cycle: Cycle,
    refused: NothingPasses,
    rows: list[Candidate],
    checked: Checked,
    continued: Continuation,
    reaction: FollowerReaction | None,
) -> Plan:
    proposed = checked.proposed
    return Plan(
        planner="ladder",
        mode=checked.driven_mode,
        side=proposed.side,
        warning=True,
        alert=Alert.WARN,
        status=Status.FALLBACK,
        verdict=continued.verdict,
        prediction=cycle.prediction.name,
        trajectory=continued.trajectory,
        safe_end=continued.end,
        candidates=refused.candidates + tuple(rows),
        iterations=refused.iterations,
        memory=replace(refused.memory, active=proposed.manoeuvre, reaction=reaction),
    )
