"""Which detection belongs to which track: Mahalanobis gate, then the global nearest neighbour."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.tracking.fix import Belief, Fix

Path = tuple[tuple[int, int], ...]  # pairs (row, column)
_ROUNDING = 1e-9
FAR_M, FAR_SD = 20.0, 6.0  # further from the belief than this plus so many of its deviations no radar is that wrong


def innovation(belief: Belief, fix: Fix) -> tuple[Array, Array]:
    """(z - H x, its covariance H P H' + R)."""
    x, P = belief
    z, H, R = fix.read(belief)
    return z - H @ x, H @ P @ H.T + R


def gated_costs(beliefs: Sequence[Belief], fixes: Sequence[Sequence[Fix | None]], gate: float) -> Array:
    """(tracks, detections): d^2 + ln det S inside the gate, infinite outside; `fixes[i][j]` is detection j as track i reads it, if it can.

    d^2 + ln det S is minus twice the log-likelihood up to a constant: a vague track does not win a detection from a sharp one.
    """
    costs = np.full((len(beliefs), len(fixes[0]) if fixes else 0), np.inf)
    for i, (x, P) in enumerate(beliefs):
        far_s, far_d = (FAR_M + FAR_SD * math.sqrt(P[k, k]) for k in (0, 2))
        for j, fix in enumerate(fixes[i]):
            if fix is None or abs(fix.place[0] - x[0]) > far_s or abs(fix.place[1] - x[2]) > far_d:
                continue
            y, S = innovation((x, P), fix)
            distance = float(y @ np.linalg.solve(S, y))
            if distance <= gate:
                costs[i, j] = distance + math.log(np.linalg.det(S))
    return costs


def assign(costs: Array) -> list[tuple[int, int]]:
    """Pairs (row, column) that match as many as can be matched at the least total cost; infinite entries are never paired.

    One more pair after the other, each by the path that adds least (Kuhn, Naval Research Logistics 2 (1955) 83): few are in doubt, and
    SciPy's answer to the same question takes a fifth of a second to load, within the first cycle that asks.
    """
    known = {(i, j): cost for i, row in enumerate(costs.tolist()) for j, cost in enumerate(row) if math.isfinite(cost)}
    of_row, of_column = Counter(i for i, _ in known), Counter(j for _, j in known)
    certain = [pair for pair in known if of_row[pair[0]] == of_column[pair[1]] == 1]
    doubtful = {pair: cost for pair, cost in known.items() if of_row[pair[0]] > 1 or of_column[pair[1]] > 1}
    row_of: dict[int, int] = {}  # by column
    while path := _cheapest_path(doubtful, row_of):
        row_of.update((j, i) for i, j in path)
    return sorted(certain + [(i, j) for j, i in row_of.items()])


def _cheapest_path(costs: dict[tuple[int, int], float], row_of: dict[int, int]) -> Path:
    """From a row without a partner to a column without one, at the least cost: each row on it takes the column, whose row moves on. Empty
    where there is none (Bellman and Ford)."""
    paired = set(row_of.values())
    reached: dict[int, tuple[float, Path]] = {i: (0.0, ()) for i, _ in costs if i not in paired}
    ends: list[tuple[float, Path]] = []
    for _ in range(len(row_of) + 1):
        ends, longer = [], dict(reached)
        for (i, j), cost in costs.items():
            if i not in reached or row_of.get(j) == i:
                continue
            total, path = reached[i][0] + cost, (*reached[i][1], (i, j))
            if j not in row_of:
                ends.append((total, path))
            elif total - costs[row_of[j], j] < longer.get(row_of[j], (math.inf, ()))[0] - _ROUNDING:
                longer[row_of[j]] = total - costs[row_of[j], j], path
        if longer == reached:
            break
        reached = longer
    return min(ends, default=(0.0, ()))[1]
