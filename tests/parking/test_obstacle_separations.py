"""The obstacles from the car: the compiled separations are those of the array operations, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.geometry.clearance import Body, PolygonField
from mcdas_opt.native.form import SWITCH
from mcdas_opt.parking.world import clearance, separation

BODY = Body(-0.9, 3.6, 0.9)


def obstacles(rng: np.random.Generator, count: int) -> PolygonField:
    """Convex polygons of three to eight corners on ellipses."""
    found = []
    for _ in range(count):
        angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(3, 9))))
        found.append(rng.normal(0.0, 4.0, 2) + rng.uniform(0.2, 4.0, 2) * np.column_stack([np.cos(angles), np.sin(angles)]))
    return PolygonField.of(found)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 6), st.integers(0, 40))
def test_both_forms_give_the_same_bits(seed: int, count: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    field, poses = obstacles(rng, count), rng.normal(0.0, 4.0, (n, 3))
    each, least = separation(field, poses, BODY), clearance(field, poses, BODY)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        assert each.shape == (n, count)
        assert np.array_equal(each, separation(field, poses, BODY))
        assert np.array_equal(least, clearance(field, poses, BODY))
