"""The choice between candidates: the cheapest that comes to a safe end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mcdas_opt.planning.candidate import Costed, Ended
from mcdas_opt.planning.candidates.evaluator import Evaluator
from mcdas_opt.planning.deadline import Stage


def _any(candidate: Costed) -> bool:
    return True


@dataclass(frozen=True, slots=True, kw_only=True)
class Round:
    """Candidates that compete. The search ends with the best of them where it comes to a safe end and `is_enough`.

    `before` names the candidate that was chosen in the cycle before, which costs less for it. In a comparison what is chosen stands against
    others of another kind: the active manoeuvre's cost is measured anew from there.
    """

    competing: Sequence[Costed]
    before: str = ""
    is_comparison: bool = True
    is_enough: Callable[[Costed], bool] = _any


def choose(evaluator: Evaluator, among: Round) -> Ended | None:
    """The cheapest that comes to a safe end; where none does, or the deadline passes meanwhile, the cheapest, with its open end."""
    cheapest = None
    for candidate in sorted(among.competing, key=lambda one: persistent_cost(one, evaluator, among.before)):
        if cheapest is not None and evaluator.cycle.is_late_for(Stage.SAFE_END):
            break
        ended = evaluator.ended(candidate)
        if ended.is_sound:
            return ended
        cheapest = cheapest or ended
    return cheapest


def persistent_cost(candidate: Costed, evaluator: Evaluator, before: str) -> tuple[float, int]:
    """Cost, less for what was chosen before; equal costs (to 1e-5 of each other) go to the tie-break side."""
    cost, cycle, proposed = candidate.cost or 0.0, evaluator.cycle, candidate.proposed
    goes_on = proposed.name == before if cycle.active is None else proposed.manoeuvre == cycle.active
    if goes_on:
        cost *= evaluator.weights.persistence
    return (round(cost, 5), 0 if proposed.side is cycle.settings.selector.tie_break else 1)
