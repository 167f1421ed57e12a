"""Drives from bodies: the compiled separations are those of the array operations, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.geometry.rectangle import corners, separation
from mcdas_opt.native.compile_cache import SWITCH
from mcdas_opt.planning.separations import Poses, separations

HALF = (2.25, 0.9)
numbers = st.integers(0, 2**32 - 1)


def poses(rng: np.random.Generator, count: int, n: int) -> Poses:
    return rng.normal(0.0, 8.0, (count, n)), rng.normal(0.0, 2.0, (count, n)), rng.normal(0.0, 0.5, (count, n))


def both(mine: Poses, others: Poses, halves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    compiled = separations(mine, others, HALF, halves)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        return compiled, separations(mine, others, HALF, halves)


@settings(deadline=None)
@given(numbers, st.integers(1, 4), st.integers(0, 5), st.integers(1, 45))
def test_both_forms_give_the_same_bits(seed: int, count: int, many: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    halves = rng.uniform(0.3, 6.0, (many, 2))
    compiled, arrays = both(poses(rng, count, n), poses(rng, many, n), halves)
    assert compiled.shape == (count, many, n)
    assert compiled.tobytes() == np.ascontiguousarray(arrays).tobytes()


@given(numbers)
@settings(deadline=None, max_examples=30)
def test_what_is_no_number_stays_none_and_touches_nothing_else(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mine, others, halves = poses(rng, 2, 12), poses(rng, 3, 12), rng.uniform(0.3, 6.0, (3, 2))
    whole = both(mine, others, halves)[0]
    which, when = int(rng.integers(3)), int(rng.integers(12))
    mine[which][1, when] = np.nan
    compiled, arrays = both(mine, others, halves)
    np.testing.assert_array_equal(compiled, arrays)
    assert np.isnan(compiled[1, :, when]).all()
    compiled[1, :, when] = whole[1, :, when]
    assert compiled.tobytes() == whole.tobytes()


def test_they_are_the_separations_of_the_corners() -> None:
    rng = np.random.default_rng(3)
    mine, others, halves = poses(rng, 3, 41), poses(rng, 4, 41), rng.uniform(0.3, 6.0, (4, 2))
    one = corners(*mine, 2.0 * HALF[0], 2.0 * HALF[1])[:, None]
    other = corners(*others, 2.0 * halves[:, :1], 2.0 * halves[:, 1:])
    np.testing.assert_allclose(separations(mine, others, HALF, halves), separation(one, other), atol=1e-12)
