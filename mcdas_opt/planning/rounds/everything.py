"""Nothing was enough: everything that is left is solved, and all that passes is compared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.candidates.choice import Round
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
    """The one that was the least short of room, if it was little, to be solved again with less of it asked for."""
    short = [one for one in search.evaluator.account.failed if one.shortfall_m <= search.solvers.usual.own.near_m]
    nearest = min(short, key=lambda one: one.shortfall_m, default=None)
    return [] if nearest is None else [replace(nearest.proposed, name=f"{nearest.proposed.name}-close")]
