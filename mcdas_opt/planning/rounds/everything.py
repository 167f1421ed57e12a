"""Nothing was enough: everything that is left is solved, and all that passes is compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.choice import Round
from mcdas_opt.planning.search import Search


def everything(search: Search) -> Iterator[Round]:
    """What departs from its lane takes part where nothing else passes, or nothing else comes to a safe end. The closed forms alone are the
    fallback's to drive, and to label."""
    evaluator, before = search.evaluator, search.cycle.memory.chosen
    search.solve(search.pending)
    search.pending = ()
    if not evaluator.passing and not evaluator.departing:
        evaluator.solve(_nearest_to_passing(search), search.solvers.closer.solve)
    departing = [] if evaluator.passing else list(evaluator.departing)
    competing = evaluator.passing + departing
    if competing:
        competing = competing + search.closed_forms
    yield Round(competing=competing, before=before)
    yield Round(competing=competing + evaluator.departing[len(departing) :], before=before)


def _nearest_to_passing(search: Search) -> list[Proposed]:
    """Those that were a little short of room, the nearest ones, to be solved again with less of it asked for."""
    own = search.solvers.usual.own
    short = [(one.shortfall_m, one.proposed) for one in search.evaluator.account.failed]
    near = sorted((one for one in short if one[0] <= own.near_m), key=lambda one: one[0])
    return [replace(proposed, name=f"{proposed.name}-close") for _, proposed in near[: own.closer_candidates]]
