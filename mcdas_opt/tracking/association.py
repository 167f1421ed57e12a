"""Which detection belongs to which track: Mahalanobis gate, then the global nearest neighbour."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.tracking.fix import Fix

Belief = tuple[Array, Array]  # state (4,), covariance (4, 4)
_NEVER = 1e9


def innovation(belief: Belief, fix: Fix) -> tuple[Array, Array]:
    """(z - H x, its covariance H P H' + R)."""
    x, P = belief
    H = fix.H
    return fix.z - H @ x, H @ P @ H.T + fix.noise(x)


def gated_costs(beliefs: Sequence[Belief], fixes: Sequence[Sequence[Fix | None]], gate: float) -> Array:
    """(tracks, detections): d^2 + ln det S inside the gate, infinite outside; `fixes[i][j]` is detection j as track i reads it, if it can.

    d^2 + ln det S is minus twice the log-likelihood up to a constant: a vague track does not win a detection from a sharp one.
    """
    costs = np.full((len(beliefs), len(fixes[0]) if fixes else 0), np.inf)
    for i, belief in enumerate(beliefs):
        for j, fix in enumerate(fixes[i]):
            if fix is None:
                continue
            y, S = innovation(belief, fix)
            if (y * y > gate * S.diagonal()).any():  # d^2 is at least that of any one component
                continue
            distance = float(y @ np.linalg.solve(S, y))
            if distance <= gate:
                costs[i, j] = distance + float(np.linalg.slogdet(S)[1])
    return costs


def assign(costs: Array) -> list[tuple[int, int]]:
    """Pairs (row, column) that match as many as can be matched at the least total cost; infinite entries are never paired."""
    possible = np.isfinite(costs)
    if not possible.any():
        return []
    if possible.sum() == 1 or ((possible.sum(axis=0) <= 1).all() and (possible.sum(axis=1) <= 1).all()):
        return [(int(i), int(j)) for i, j in np.argwhere(possible)]
    from scipy.optimize import linear_sum_assignment

    rows, columns = linear_sum_assignment(np.where(possible, costs, _NEVER))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if possible[i, j]]
