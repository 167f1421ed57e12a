"""A threat and no active manoeuvre: the few candidates that rank highest are solved first."""

from __future__ import annotations

from collections.abc import Iterator

from mcdas_opt.planning.candidate import Costed
from mcdas_opt.planning.candidates.choice import Round, persistent_cost
from mcdas_opt.planning.candidates.ranking import ranked
from mcdas_opt.planning.deadline import Stage
from mcdas_opt.planning.proposals.sampled import further
from mcdas_opt.planning.search import Search


def ranked_first(search: Search) -> Iterator[Round]:
    """Compared with the closed forms; enough where none of the others is ranked at less than the best costs."""
    cycle, evaluator = search.cycle, search.evaluator
    if cycle.active is not None:
        return
    proposals = search.basic if cycle.is_late_for(Stage.MORE_CANDIDATES) else search.basic + further(cycle)
    ranks = ranked(proposals, search.solvers.usual.own.first_candidates, cycle, evaluator.weights)
    search.solve(ranks.first)
    search.pending = ranks.others
    before = cycle.memory.chosen

    def costs_less_than_others_rank(best: Costed) -> bool:
        return persistent_cost(best, evaluator, before)[0] <= ranks.least_cost

    if evaluator.passing and ranks.others:
        yield Round(competing=evaluator.passing + search.closed_forms, before=before, is_enough=costs_less_than_others_rank)
