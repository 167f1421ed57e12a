"""Why a plan was chosen: what threatens, and the chosen candidate's own numbers beside those of the best that were not."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.escapes import Closer, Escapes
from mcdas_opt.domain.plan import Candidate
from mcdas_opt.domain.safe_end import EndKind
from mcdas_opt.domain.vocabulary import Sector, Side
from mcdas_opt.planning.candidate import Ended
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.front.headway import ORDINARY_MPS2
from mcdas_opt.planning.proposals.yielding import yielding

NOTHING_THREATENS = "nothing threatens"
_MET = {
    Closer.FRONT: "somebody ahead",
    Closer.REAR: "somebody behind",
    Closer.SIDE: "somebody from the side",
    Closer.EDGE: "the edge of the road",
}
_SAME = 1e-5  # costs that differ by less are equal


def reason(cycle: Cycle, best: Ended, rows: Sequence[Candidate], *, is_comparison: bool) -> str:
    """A sentence without a verb that the numbers do not bear. `rows` is what was looked at, the chosen one among it; without
    `is_comparison` the active manoeuvre, or keeping the lane, stood against nothing of another kind."""
    name, cost = best.proposed.name, best.candidate.cost or 0.0
    told = threat(cycle.assessment)
    told = _answered(best, cycle) or told if told == NOTHING_THREATENS else told
    return f"{told}; {name} costs {cost:.2f}{_beside(name, cost, rows, is_comparison=is_comparison)}"


def threat(assessment: Assessment) -> str:
    """Who threatens, how far off, and in how many seconds he would be met at these speeds."""
    end = "the end of the lane" if assessment.lane_ends else "the end of the road"
    ahead = end if assessment.front_id is None else f"track {assessment.front_id}"
    told = []
    if Sector.FRONT in assessment.threats:
        told.append(f"{ahead}, {assessment.front_gap_m:.1f} m ahead{_in(assessment.ttc_front_s)}")
    if Sector.REAR in assessment.threats:
        told.append(f"track {assessment.rear_id}, {assessment.rear_gap_m:.1f} m behind{_in(assessment.ttc_rear_s)}")
    return " and ".join(told) or NOTHING_THREATENS


def with_alert(told: str, escapes: Escapes | None, *, blind: str = "") -> str:
    """The sentence of a plan with an alert: where nobody ahead or behind threatens, what the constant-input prediction meets, or what is
    said where nobody watches ahead (`blind`)."""
    if not told.startswith(NOTHING_THREATENS):
        return f"{told}; {blind}" if blind else told
    if blind:
        return f"{blind}{told.removeprefix(NOTHING_THREATENS)}"
    if escapes is None or escapes.keeping_on_s is None or escapes.keeping_on_meets is None:
        return f"with its inputs held it meets nothing, but the plan is not comfortable{told.removeprefix(NOTHING_THREATENS)}"
    met = _MET.get(escapes.keeping_on_meets, escapes.keeping_on_meets.value)
    return f"with its inputs held it meets {met} in {escapes.keeping_on_s:.1f} s{told.removeprefix(NOTHING_THREATENS)}"


def _answered(best: Ended, cycle: Cycle) -> str:
    """Who crosses and is let through, or asks for braking ahead, though he does not threaten."""
    proposed, assessment = best.proposed, cycle.assessment
    names = [one.track.id for one in yielding(cycle, proposed.path.target_d_m)] if proposed.is_comfortable else []
    if names:
        return f"{' and '.join(names)} {'crosses and is' if len(names) == 1 else 'cross and are'} let through"
    if cycle.front_braking.stopping_mps2 <= ORDINARY_MPS2 or proposed.side is not Side.NONE:
        return ""
    return f"track {assessment.front_id}, {assessment.front_gap_m:.1f} m ahead, asks for {cycle.front_braking.stopping_mps2:.1f} m/s^2"


def _in(ttc_s: float) -> str:
    return f", met in {ttc_s:.1f} s" if math.isfinite(ttc_s) else ""


def _beside(name: str, cost: float, rows: Sequence[Candidate], *, is_comparison: bool) -> str:
    """The best of those that were not chosen, and what stands against it."""
    others = [(row.cost, row) for row in rows if row.cost is not None and row.name != name]
    passing = sorted((its for its in others if its[1].passed), key=lambda its: its[0])
    failing = [(its_cost, row) for its_cost, row in others if not row.passed and its_cost < cost - _SAME]
    told = []
    if passing:
        least, row = passing[0]
        if least >= cost - _SAME:
            told.append(f"the least of {len(passing) + 1} that pass, next {row.name} with {least:.2f}")
        elif row.end is EndKind.OPEN:
            told.append(f"{row.name} with {least:.2f} comes to no safe end")
        else:
            told.append(f"{row.name} with {least:.2f} is not better by enough")
    elif others and is_comparison:
        told.append(f"the only one of {len(others) + 1} that passes")
    if failing:
        least, row = min(failing, key=lambda its: its[0])
        told.append(f"{row.name} with {least:.2f} fails: {row.refusal}")
    return "".join(f", {each}" for each in told)
