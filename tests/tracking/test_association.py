"""Gating, and the assignment that is best as a whole."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcdas_opt.domain.rules import Array
from mcdas_opt.tracking.association import assign, gated_costs
from mcdas_opt.tracking.fix import BodyFix


def best_by_trying(costs: Array) -> tuple[int, float]:
    """(most pairs, their least total cost) over every way to pair rows with columns."""
    rows, columns = costs.shape
    best = (0, 0.0)
    for count in range(1, min(rows, columns) + 1):
        for chosen in itertools.combinations(range(rows), count):
            for partners in itertools.permutations(range(columns), count):
                total = sum(costs[i, j] for i, j in zip(chosen, partners, strict=True))
                if np.isfinite(total) and (count > best[0] or (count == best[0] and total < best[1])):
                    best = (count, total)
    return best


@settings(deadline=None, max_examples=80)
@given(
    costs=st.tuples(st.integers(1, 4), st.integers(1, 4)).flatmap(
        lambda shape: arrays(np.float64, shape, elements=st.one_of(st.floats(-20.0, 20.0), st.just(np.inf)))
    )
)
def test_assignment_is_the_best_of_all(costs: Array) -> None:
    pairs = assign(costs)
    assert len({i for i, _ in pairs}) == len({j for _, j in pairs}) == len(pairs)
    count, total = best_by_trying(costs)
    assert len(pairs) == count
    assert abs(sum(costs[i, j] for i, j in pairs) - total) < 1e-6


def fix(s: float, d: float) -> BodyFix:
    return BodyFix(state=np.array([s, 0.0, d, 0.0]), variance=np.full(4, 0.01))


def belief(s: float, d: float, sd: float) -> tuple[Array, Array]:
    return np.array([s, 0.0, d, 0.0]), sd**2 * np.eye(4)


def test_what_lies_outside_the_gate_is_never_paired() -> None:
    costs = gated_costs([belief(0.0, 0.0, 1.0)], [[fix(3.0, 0.0), fix(5.0, 0.0), fix(1e6, 0.0), None]], gate=16.0)
    assert np.isfinite(costs).tolist() == [[True, False, False, False]]
    assert gated_costs([], [], 16.0).shape == (0, 0)
    assert assign(gated_costs([], [], 16.0)) == []


def test_nearest_neighbour_is_global() -> None:
    """The first track's nearest detection is the second one's only one: taking it greedily would lose the second track."""
    beliefs = [belief(0.0, 0.0, 1.0), belief(4.0, 0.0, 1.0)]
    fixes = [fix(1.5, 0.0), fix(-2.5, 0.0)]
    costs = gated_costs(beliefs, [fixes, fixes], gate=9.0)
    assert np.argmin(costs[0]) == 0
    assert sorted(assign(costs)) == [(0, 1), (1, 0)]


def test_a_vague_track_does_not_rob_a_sharp_one() -> None:
    """By distance alone the vague track would win the detection that lies beside the sharp one."""
    beliefs = [belief(10.0, 0.0, 8.0), belief(0.0, 0.0, 0.3)]
    found = [fix(0.5, 0.0)]
    costs = gated_costs(beliefs, [found, found], gate=16.0)
    assert assign(costs) == [(1, 0)]
