"""A threat during a manoeuvre: it goes on alone while it costs hardly more than before; else the others are compared with it."""

from __future__ import annotations

from collections.abc import Iterator

from mcdas_opt.planning.candidate import Costed
from mcdas_opt.planning.candidates.choice import Round
from mcdas_opt.planning.proposals.sampled import further
from mcdas_opt.planning.search import Search


def active_manoeuvre_alone(search: Search) -> Iterator[Round]:
    """Enough up to the re-planning ratio over what it cost when the candidates were last compared."""
    cycle = search.cycle
    active, least_cost = cycle.active, cycle.memory.least_cost
    if active is None or cycle.is_ordinary:
        return

    def is_within_replanning_ratio(best: Costed) -> bool:
        return least_cost is not None and (best.cost or 0.0) <= search.evaluator.weights.replanning_ratio * least_cost

    alone = search.solve(proposed for proposed in search.basic if proposed.side is active.side)
    yield Round(competing=alone, before=cycle.memory.chosen, is_comparison=False, is_enough=is_within_replanning_ratio)


def beside_the_active_manoeuvre(search: Search) -> Iterator[Round]:
    """The other basic candidates; the sampled family waits until none of these will do."""
    cycle = search.cycle
    active = cycle.active
    if active is None:
        return
    known = None if cycle.is_ordinary else active.side
    search.solve(proposed for proposed in search.basic if proposed.side is not known)
    yield Round(competing=list(search.evaluator.passing), before=cycle.memory.chosen)
    search.pending = further(cycle)
