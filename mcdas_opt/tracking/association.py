"""Which detection belongs to which track: Mahalanobis gate, then the global nearest neighbour."""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib import import_module

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.tracking.fix import Belief, Fix

_NEVER = 1e9
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


def load_assignment() -> None:
    """Imports SciPy's assignment (a fifth of a second) now, not in the first cycle in which somebody's detections are in doubt."""
    import_module("scipy.optimize")


def assign(costs: Array) -> list[tuple[int, int]]:
    """Pairs (row, column) that match as many as can be matched at the least total cost; infinite entries are never paired."""
    pairs = [(i, j) for i, row in enumerate(costs.tolist()) for j, cost in enumerate(row) if math.isfinite(cost)]
    if len({i for i, _ in pairs}) == len({j for _, j in pairs}) == len(pairs):
        return pairs
    from scipy.optimize import linear_sum_assignment

    possible = np.isfinite(costs)
    rows, columns = linear_sum_assignment(np.where(possible, costs, _NEVER))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if possible[i, j]]
