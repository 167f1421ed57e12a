"""Intervals and pair tests against their definitions."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.statistics import Pairs, Share, quantiles


@given(st.integers(1, 400).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
@settings(max_examples=60)
def test_at_either_end_of_the_interval_the_count_is_just_not_surprising(kn: tuple[int, int]) -> None:
    """Clopper-Pearson inverts the two one-sided binomial tests at 2.5 % each."""
    k, n = kn
    low, high = Share(k=k, n=n).interval
    assert low <= k / n <= high
    assert low == 0.0 if k == 0 else math.isclose(binom.sf(k - 1, n, low), 0.025, rel_tol=1e-6)
    assert high == 1.0 if k == n else math.isclose(binom.cdf(k, n, high), 0.025, rel_tol=1e-6)


def test_nothing_of_nothing_is_no_rate() -> None:
    share = Share(k=0, n=0)
    assert share.rate is None
    assert share.interval == (0.0, 1.0)
    with pytest.raises(ParameterError):
        Share(k=2, n=1)


@given(st.integers(0, 40), st.integers(0, 40))
@settings(max_examples=60)
def test_mcnemar_is_the_exact_coin(b: int, c: int) -> None:
    pair = Pairs(first="one", second="two", n=100, only_first=b, only_second=c)
    n = b + c
    tail = sum(math.comb(n, k) for k in range(min(b, c) + 1)) / 2**n
    assert math.isclose(pair.p, min(1.0, 2.0 * tail), rel_tol=1e-9)
    assert math.isclose(pair.p, Pairs(first="two", second="one", n=100, only_first=c, only_second=b).p, rel_tol=1e-12)


def test_quantiles_say_when_there_is_nothing() -> None:
    assert quantiles([None, None])["n"] == 0
    assert quantiles([None, None])["p50"] is None
    found = quantiles([3.0, None, 1.0, 2.0])
    assert (found["n"], found["p50"], found["min"], found["max"], found["mean"]) == (3, 2.0, 1.0, 3.0, 2.0)
