"""Plans and verdicts in plain words."""

from __future__ import annotations

import math

from mcdas_opt.domain.plan import Candidate, Plan
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.safe_end import EndKind
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status

_DOING = {
    Mode.HOLD: "keeps its lane",
    Mode.CRUISE: "keeps its lane, towards the desired speed",
    Mode.BRAKE: "brakes in its lane",
    Mode.ACCELERATE: "accelerates in its lane",
    Mode.EVADE: "steers out",
    Mode.PARK: "stands and waits to be parked",
}
_ASIDE = {
    Mode.HOLD: "moves over",
    Mode.CRUISE: "moves over, towards the desired speed,",
    Mode.BRAKE: "brakes and moves over",
    Mode.ACCELERATE: "accelerates and moves over",
}
_KEPT_MPS = 0.5  # a speed that changes by no more is kept
_NAMED = 2
_GRAVEST_FIRST = (
    ViolationKind.COLLISION,
    ViolationKind.LEFT_EDGE,
    ViolationKind.RIGHT_EDGE,
    ViolationKind.ROAD_END,
    ViolationKind.FRICTION,
    ViolationKind.ACCELERATION,
    ViolationKind.JERK,
    ViolationKind.STEERING_RATE,
    ViolationKind.SPEED,
    ViolationKind.STEERING_ANGLE,
)
TOLD = {Alert.NONE: "", Alert.WARN: ", driver warned", Alert.ACT: ", last moment"}  # to the driver
_STATUS = {
    Status.PLANNED: "",
    Status.FALLBACK: "from the fallback ladder",
    Status.UNAVOIDABLE: "nothing passes: the least severe",
}


def doing(plan: Plan) -> str:
    """What the plan does: 'steers out to the left'."""
    if plan.side is not Side.NONE:
        return f"{_ASIDE.get(plan.mode) or _DOING.get(plan.mode, plan.mode.value)} to the {plan.side.value}"
    pace = _pace(plan.trajectory.speed_mps) if plan.mode is Mode.HOLD else ""
    return f"{_DOING.get(plan.mode, plan.mode.value)}{pace}"


def _pace(speed_mps: Array) -> str:
    slowest, fastest, now = float(speed_mps.min()), float(speed_mps.max()), float(speed_mps[0])
    if not max(now - slowest, fastest - now) > _KEPT_MPS:
        return " and speed"
    return f", slows down to {slowest:.1f} m/s" if now - slowest > fastest - now else f", speeds up to {fastest:.1f} m/s"


def judged(verdict: Verdict) -> str:
    """What the judge says: 'passed by the judge', or the two gravest rules that it found broken, and how many more."""
    if verdict.passed:
        return "passed by the judge"
    found = sorted(verdict.violations, key=_grave)
    more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
    return "failed by the judge: " + "; ".join(broken(v) for v in found[:_NAMED]) + more


def _grave(violation: Violation) -> int:
    """Who is hit comes before where the car leaves the road, what it cannot do, and how badly the record begins or fits together."""
    return _GRAVEST_FIRST.index(violation.kind) if violation.kind in _GRAVEST_FIRST else len(_GRAVEST_FIRST)


def broken(violation: Violation) -> str:
    """One broken rule: 'collision with rear at 2.1 s', 'friction 31.3 m/s^2 at 0.6 s (limit 8.8)'."""
    if violation.kind is ViolationKind.COLLISION:
        return f"{violation.name} at {violation.t_s:.1f} s"
    return _raised(f"{violation.name} {violation.value:.3g} {violation.unit} at {violation.t_s:.1f} s (limit {violation.limit:.3g})")


def sentence(plan: Plan) -> str:
    """Status and verdict together, and whether anybody looked beyond."""
    unknown = f"for {plan.trajectory.t_s[-1]:.1f} s, its end was not looked at" if plan.verdict.passed and plan.safe_end is None else ""
    slides = any(found.kind is ViolationKind.SIDESLIP for found in plan.verdict.violations)
    status = "the car slides, and follows no plan" if slides else _STATUS.get(plan.status, plan.status.value)
    return "; ".join(part for part in (status, f"{judged(plan.verdict)} {unknown}".strip()) if part)


def because(plan: Plan) -> str:
    """Why the plan is what it is, and what is doubted of the tracks, without the refusals that came before it: those stand with the
    candidates."""
    why = plan.reason.partition("; before:")[0]
    return _raised("; ".join([why, *(f"doubted: {doubt}" for doubt in plan.doubts[:_NAMED])]))


def ending(plan: Plan) -> str:
    """How the plan ends: 'at rest in its lane after 3.2 s'."""
    end = plan.safe_end
    if end is None:
        return "not looked at"
    words = {
        EndKind.CLEAR: "nobody is in its way",
        EndKind.HELD: "nobody is ahead"
        if end.front_margin_m is None
        else "at a distance to whoever is ahead that can be held if that brakes fully",
        EndKind.STOPPED: "at rest in its lane",
        EndKind.OPEN: "not safely: at rest nowhere, and nearer to somebody than can be held",
    }
    asked = ""
    if end.follower_demand_mps2:
        most = f"asks {end.follower_demand_mps2:.1f} m/s² of whoever is behind"
        asked = f"; {most if math.isfinite(end.follower_demand_mps2) else 'no braking of whoever is behind is enough'}"
    several = " and " in (end.relies_on or "")
    relied = "" if end.relies_on is None else f"; {end.relies_on} behind {'are' if several else 'is'} expected to brake"
    return f"{words[end.kind]}, after {end.t_s:.1f} s{asked}{relied}"


def alerted(plan: Plan) -> str:
    """What the driver is told, and why."""
    if plan.alert is Alert.NONE:
        return "none"
    if plan.alert is Alert.ACT:
        return "act: the last candidate is about to close, or closed"
    if plan.status is not Status.PLANNED:
        return "warn: no plan of the planner's own ends safely"
    return f"warn: {'no comfortable candidate is left' if plan.side is Side.NONE else 'the car steers out'}"


def passed(candidate: Candidate) -> str:
    """Whether a candidate passed, and how far anybody looked: 'yes, end not looked at'."""
    if not candidate.passed:
        return "no"
    if candidate.end is None:
        return "yes, end not looked at"
    return "yes, to no safe end" if candidate.end is EndKind.OPEN else "yes, to a safe end"


def _raised(text: str) -> str:
    return text.replace("^2", "²").replace("^3", "³")
