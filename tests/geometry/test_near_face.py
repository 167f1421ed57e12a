"""The half extent of a rectangle, and the road's window."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.road import Road
from mcdas_opt.geometry.near_face import half_extent, half_extent_and_slope
from mcdas_opt.geometry.window import REACH_M, frame_near

sizes = {"bearing": st.floats(-7.0, 7.0), "length": st.floats(0.5, 20.0), "width": st.floats(0.5, 3.0)}


@settings(deadline=None)
@given(**sizes)
def test_the_point_lies_on_the_edge(bearing: float, length: float, width: float) -> None:
    e = float(half_extent(bearing, length, width))
    x, y = abs(e * math.cos(bearing)) / (0.5 * length), abs(e * math.sin(bearing)) / (0.5 * width)
    assert max(x, y) == pytest.approx(1.0)


@settings(deadline=None)
@given(**sizes)
def test_bumpers_and_flanks(bearing: float, length: float, width: float) -> None:
    along, across = half_extent(np.array([0.0, math.pi / 2]), length, width)
    assert (along, across) == pytest.approx((0.5 * length, 0.5 * width))
    for other in (-bearing, bearing + math.pi):
        assert half_extent(other, length, width) == pytest.approx(half_extent(bearing, length, width))


@settings(deadline=None)
@given(**sizes)
def test_slope_is_the_finite_difference(bearing: float, length: float, width: float) -> None:
    corner = math.atan2(width, length)
    folded = abs(math.remainder(bearing, math.pi))
    assume(abs(folded - corner) > 1e-3)
    h = 1e-6
    difference = (half_extent(bearing + h, length, width) - half_extent(bearing - h, length, width)) / (2.0 * h)
    extent, slope = half_extent_and_slope(bearing, length, width)
    assert extent == pytest.approx(float(half_extent(bearing, length, width)))
    assert slope == pytest.approx(difference, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("s", [-3333.0, -10.0, 0.0, 240.0, 260.0, 9876.5])
def test_a_window_reaches_around_its_place_and_goes_there_and_back(s: float) -> None:
    road = Road(lanes_left=1, curvature=((0.0, 0.001), (500.0, -0.002), (1000.0, 0.0015)))
    frame = frame_near(road, s)
    there = s + np.array([-REACH_M, -100.0, 0.0, 30.0, REACH_M])
    x, y, yaw = frame.to_plane(there, np.full(5, 3.7), np.full(5, 0.1))
    back = frame.to_road(x[1:4], y[1:4], yaw[1:4], near_s_m=s)
    np.testing.assert_allclose(back, [there[1:4], np.full(3, 3.7), np.full(3, 0.1)], atol=1e-9)


def test_windows_differ_by_a_shift_only() -> None:
    road = Road(lanes_left=1, curvature=((0.0, 0.001), (500.0, -0.002)))
    s = np.array([1230.0, 1250.0, 1270.0])
    one, other = (np.array(frame_near(road, place).to_plane(s, 0.0 * s, 0.0 * s)) for place in (1249.0, 1251.0))
    assert frame_near(road, 1249.0) is not frame_near(road, 1251.0)
    np.testing.assert_allclose(np.diff(one, axis=1), np.diff(other, axis=1), atol=1e-9)
    assert frame_near(Road(), 0.0) is frame_near(Road(), 99999.0)
