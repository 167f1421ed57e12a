"""Rare events: known probabilities are met, the cheap baseline's crude count too, within what the estimates say of themselves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from benchmarks.braking_lead import DIMENSIONS, BrakingLead
from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.rare_events import crude, importance_sampling, subset_simulation


def plane(beta: float) -> object:
    def gap(u: Array) -> Array:
        return beta - u.sum(axis=1) / np.sqrt(u.shape[1])

    return gap


@pytest.mark.parametrize("beta", [2.5, 3.5, 4.5])
@pytest.mark.parametrize("dimensions", [2, 8])
def test_a_half_space_has_the_probability_of_its_distance(beta: float, dimensions: int) -> None:
    truth = float(norm.sf(beta))
    subset = subset_simulation(plane(beta), dimensions, seed=3, per_level=2000)
    assert abs(subset.probability / truth - 1.0) < 3.0 * subset.variation + 0.05
    assert 0.02 < subset.variation < 0.3
    assert list(subset.levels_m) == sorted(subset.levels_m, reverse=True)
    weighted = importance_sampling(plane(beta), subset.crashes, 4000, seed=4)
    assert abs(weighted.probability / truth - 1.0) < 4.0 * weighted.variation
    assert weighted.effective_sample_size is not None
    assert weighted.effective_sample_size > 100.0


def test_both_agree_with_crude_monte_carlo_on_the_cheap_baseline() -> None:
    gap = BrakingLead().baseline_gap
    counted = crude(gap, DIMENSIONS, 150_000, seed=5)
    assert 1e-5 < counted.probability < 1e-3
    subset = subset_simulation(gap, DIMENSIONS, seed=6, per_level=2000)
    weighted = importance_sampling(gap, subset.crashes, 2000, seed=7)
    assert weighted.effective_sample_size is not None
    assert weighted.effective_sample_size >= 100.0
    for one in (subset, weighted):
        assert abs(one.probability / counted.probability - 1.0) < 0.3 + 2.0 * counted.variation
    assert abs(weighted.probability / subset.probability - 1.0) < 0.3


def test_the_spread_over_seeds_is_what_is_claimed() -> None:
    runs = [subset_simulation(plane(3.0), 4, seed=seed, per_level=500) for seed in range(20)]
    found = np.array([one.probability for one in runs])
    claimed = float(np.mean([one.variation for one in runs]))
    assert 0.4 < found.std() / found.mean() / claimed < 2.5
    assert abs(found.mean() / float(norm.sf(3.0)) - 1.0) < 0.25


def test_the_same_seed_gives_the_same_bytes() -> None:
    first, second = (subset_simulation(BrakingLead().baseline_gap, DIMENSIONS, seed=8, per_level=200) for _ in range(2))
    assert first == second
    assert np.array_equal(first.crashes, second.crashes)


def test_more_headway_never_brings_the_baseline_nearer() -> None:
    rng = np.random.default_rng(9)
    u = rng.standard_normal((200, DIMENSIONS))
    more = u + np.array([0.0, 0.5, 0.0, 0.0])
    assert np.all(BrakingLead().baseline_gap(more) >= BrakingLead().baseline_gap(u) - 1e-9)


def test_the_loop_drives_the_same_scenes() -> None:
    study, calm, hopeless = BrakingLead(), np.zeros(DIMENSIONS), np.array([0.0, -12.0, 4.0, 0.0])
    gaps = study.driven_gap(np.array([calm, hopeless]), planner="aeb")
    assert gaps[0] > 0.0 > gaps[1]
    assert study.scene(calm).neighbour[0].s_m == pytest.approx(2.0 * 25.0 + 4.5)


def test_bad_input_is_refused() -> None:
    with pytest.raises(ParameterError, match="per_level"):
        subset_simulation(plane(3.0), 2, seed=1, per_level=50)
    with pytest.raises(ParameterError, match="crashes"):
        importance_sampling(plane(3.0), np.zeros((3, 2)), 100, seed=1)
