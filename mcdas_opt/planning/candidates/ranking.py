"""The ranking of candidates before they are solved: by the cost of their guesses, so that the few that rank highest are solved first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.candidates.collision_check import CERTAIN_M
from mcdas_opt.planning.candidates.cost import driving_costs
from mcdas_opt.planning.candidates.lane_change_cost import lane_change_cost
from mcdas_opt.planning.candidates.nearness import nearness_of
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lane_problem.lane_parameters import guessed_states


class Ranked(NamedTuple):
    """Candidates to solve first, the others, and the least cost that the guess of one of those has."""

    first: tuple[Proposed, ...]
    others: tuple[Proposed, ...]
    least_cost: float


def ranked(proposals: Sequence[Proposed], most: int, cycle: Cycle, weights: CostWeights) -> Ranked:
    """The `most` that rank highest, with what was chosen before, what is refused anyway and what has no finite cost; and the others. Each
    with its guess, in the order given.

    A candidate ranks by the cost of its guess, with what it costs beside; who certainly hits somebody there comes last. Equal costs (to
    1e-5 of each other) go to the tie-break side. Where fewer than `most` guesses hit nobody, it is too tight to tell, and there are no
    others.
    """
    situation, settings = cycle.situation, cycle.settings
    times_s, tie_break = settings.grid.times_s, settings.selector.tie_break
    asked = [i for i, proposed in enumerate(proposals) if not proposed.refusal]
    if len(asked) <= most:
        return Ranked(tuple(proposals), (), math.inf)
    guessed = list(proposals)
    tables = np.zeros((len(asked), 9, times_s.size))
    tables[:, 0] = times_s
    for row, i in enumerate(asked):
        if proposals[i].guess is None:
            guessed[i] = replace(proposals[i], guess=guessed_states(situation, proposals[i], cycle.vehicle, times_s))
        tables[row, 1:7] = np.asarray(guessed[i].guess).T
    tables[:, 8, :-1] = (tables[:, 5, 1:] - tables[:, 5, :-1]) / (times_s[1:] - times_s[:-1])
    near = nearness_of(tables, times_s, cycle)
    costs = driving_costs(near, cycle, weights)
    hits: list[bool] = (near.deepest_m.min(axis=-1, initial=np.inf) < -CERTAIN_M).tolist()
    for row, i in enumerate(asked):
        costs[row] += lane_change_cost(proposals[i].side, cycle, weights) + (weights.delayed if proposals[i].is_delayed else 0.0)
    if hits.count(False) < most:
        return Ranked(tuple(guessed), (), math.inf)

    def rank(row: int) -> tuple[bool, float, int]:
        return (
            hits[row],
            round(costs[row], 5) if math.isfinite(costs[row]) else math.inf,
            0 if proposals[asked[row]].side is tie_break else 1,
        )

    before = cycle.memory.chosen
    below = [row for row in sorted(range(len(asked)), key=rank)[most:] if math.isfinite(costs[row])]
    rest = {asked[row]: costs[row] for row in below if proposals[asked[row]].name != before}
    first = tuple(proposed for i, proposed in enumerate(guessed) if i not in rest)
    return Ranked(first, tuple(guessed[i] for i in sorted(rest)), min(rest.values(), default=math.inf))
