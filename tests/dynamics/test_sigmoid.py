"""The sigmoid's ends, symmetry and slopes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.dynamics.sigmoid import hump, renormalised, sigmoid

slopes = st.floats(-2.0, -0.02)
sharpness = st.floats(2.0, 200.0)


@given(a=slopes, b=sharpness, share=st.floats(-3.0, 3.0))
def test_is_the_papers_curve(a, b, share):
    x = share * -2.0 * math.log(b) / a
    assert sigmoid(x, a, b, math) == pytest.approx(1.0 / (1.0 + b * math.exp(a * x)), abs=1e-13)


@given(a=slopes, b=sharpness)
def test_renormalised_begins_at_0_and_ends_at_1(a, b):
    end = -2.0 * math.log(b) / a
    assert renormalised(0.0, a, b, math) == pytest.approx(0.0, abs=1e-12)
    assert renormalised(end, a, b, math) == pytest.approx(1.0, abs=1e-12)


@given(a=slopes, b=sharpness, share=st.floats(0.0, 1.0))
def test_is_its_own_mirror_about_its_middle(a, b, share):
    end = -2.0 * math.log(b) / a
    x = share * end
    assert renormalised(x, a, b, math) + renormalised(end - x, a, b, math) == pytest.approx(1.0, abs=1e-11)


@given(a=slopes, b=sharpness, share=st.floats(0.0, 1.0))
def test_slope_is_the_finite_difference(a, b, share):
    x = share * -2.0 * math.log(b) / a
    h = 1e-4 / abs(a)
    s = sigmoid(x, a, b, math)
    numeric = (sigmoid(x + h, a, b, math) - sigmoid(x - h, a, b, math)) / (2.0 * h)
    assert numeric == pytest.approx(-a * s * (1.0 - s), rel=1e-6, abs=1e-9)


def test_rises_everywhere_and_cannot_overflow():
    x = np.linspace(0.0, 60.0, 400)
    assert np.all(np.diff(renormalised(x, -0.4, 50.0, np)) > 0.0)
    assert sigmoid(np.array([-1e6, 1e6]), -0.4, 50.0, np) == pytest.approx([0.0, 1.0])


@given(x=st.floats(-100.0, 100.0), width=st.floats(1.0, 50.0))
def test_hump_is_even_and_highest_beside_the_front_vehicle(x, width):
    assert hump(0.0, width, math) == 1.0
    assert hump(x, width, math) == hump(-x, width, math) <= 1.0
