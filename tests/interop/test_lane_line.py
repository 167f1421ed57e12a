"""A polyline becomes a road of piecewise linear curvature: close to it, and placed where it is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.road import Road
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.commonroad.lane_line import Placement, fit

places = st.builds(Placement, x_m=st.floats(-500.0, 500.0), y_m=st.floats(-500.0, 500.0), yaw_rad=st.floats(-math.pi, math.pi))


@given(place=places, x=st.floats(-100.0, 100.0), y=st.floats(-100.0, 100.0), yaw=st.floats(-3.0, 3.0))
def test_a_placement_goes_there_and_back(place: Placement, x: float, y: float, yaw: float) -> None:
    there = place.to_plane(np.array(x), np.array(y), np.array(yaw))
    assert [float(q) for q in place.to_frame(*there)] == pytest.approx([x, y, yaw], abs=1e-9)


@settings(max_examples=12)
@given(place=places, kappa=st.floats(-0.03, 0.03), change=st.floats(-3e-4, 3e-4), begun=st.floats(10.0, 60.0))
def test_a_clothoid_is_found_again(place: Placement, kappa: float, change: float, begun: float) -> None:
    """Points of a road of ours come back as a road within 5 cm of it, its foot under the point that was asked for."""
    road = Road(curvature=((0.0, kappa), (80.0, kappa + 80.0 * change)))
    s = np.linspace(0.0, 80.0, 41)
    x, y, yaw = place.to_plane(*FrenetFrame(road=road).to_plane(s, np.zeros(41), np.zeros(41)))
    foot = int(np.argmin(np.abs(s - begun)))
    line = fit(np.column_stack([x, y]), np.array([x[foot], y[foot]]))
    assert line.off_m < 0.05
    assert line.length_m == pytest.approx(80.0 - s[foot], abs=0.6)
    assert math.hypot(line.placement.x_m - x[foot], line.placement.y_m - y[foot]) < 0.6
    assert abs(math.remainder(line.placement.yaw_rad - yaw[foot], math.tau)) < 0.05
    ahead = FrenetFrame(road=Road(curvature=line.curvature))
    fx, fy, _ = line.placement.to_plane(
        *ahead.to_plane(np.arange(0.0, 80.0 - s[foot], 2.0), *np.zeros((2, len(np.arange(0.0, 80.0 - s[foot], 2.0)))))
    )
    fine = np.linspace(0.0, 80.0, 4001)
    tx, ty, _ = place.to_plane(*FrenetFrame(road=road).to_plane(fine, np.zeros(4001), np.zeros(4001)))
    assert max(float(np.hypot(tx - a, ty - b).min()) for a, b in zip(fx, fy, strict=True)) < 0.08


def test_a_straight_line_stays_straight_and_repeated_points_do_no_harm() -> None:
    points = np.array([[0.0, 0.0], [0.0, 0.0], [3.0, 4.0], [30.0, 40.0], [30.0, 40.0]])
    line = fit(points, np.array([6.0, 8.0]))
    assert max(abs(kappa) for _, kappa in line.curvature) < 1e-9
    assert line.placement.yaw_rad == pytest.approx(math.atan2(4.0, 3.0))
    assert line.off_m < 1e-6
