"""Road edges and the road's end, to a centimetre."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.road import Road
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners
from tests.verification.rollouts import WIDE, WIDE_CURVED, legal, names, straight_on

both_roads = pytest.mark.parametrize("road", [WIDE, WIDE_CURVED], ids=["straight", "curved"])
family = settings(max_examples=25, deadline=None)


def reach(drive):
    """Least and largest d and largest s of the body's corners at the samples, each corner's foot sought by itself."""
    x = drive.trajectory
    frame = FrenetFrame(road=drive.road, s_min_m=-100.0, s_max_m=300.0)
    points = corners(*frame.to_plane(x.s_m, x.d_m, x.heading_rad), drive.vehicle.length_m, drive.vehicle.width_m)
    s, d, _ = frame.to_road(points[..., 0], points[..., 1], np.zeros(points.shape[:-1]))
    return d.min(), d.max(), s.max()


@family
@given(seed=st.integers(0, 10**9), margin=st.floats(0.015, 0.5))
@both_roads
def test_a_corner_over_either_edge(road, seed, margin):
    road = replace(road, lane_width_m=0.2)  # the shoulders are the road
    drive = legal(seed, road)
    low, high, _ = reach(drive)
    left = replace(road, shoulder_left_m=float(max(high - 0.1 - margin, 0.0)))
    right = replace(road, shoulder_right_m=float(max(-low - 0.1 - margin, 0.0)))
    for narrow, name, value in ((left, "left road edge", high), (right, "right road edge", low)):
        if abs(value) - margin > 0.1:
            found = drive.verdict(road=narrow).violations
            assert [v.name for v in found] == [name]
            assert abs(found[0].value) >= abs(value) - 1e-6
            assert found[0].value == pytest.approx(value, abs=0.05)  # between the samples it may go a little farther
    # the extreme between samples lies at most that far beyond the samples' own
    enough = replace(road, shoulder_left_m=float(max(high, 0.0) + 0.05), shoulder_right_m=float(max(-low, 0.0) + 0.05))
    assert drive.verdict(road=enough).passed


@family
@given(seed=st.integers(0, 10**9), margin=st.floats(0.015, 3.0))
@both_roads
def test_the_front_bumper_over_the_end(road, seed, margin):
    drive = legal(seed, road)
    _, _, end = reach(drive)
    found = drive.verdict(road=replace(road, road_end_s_m=float(end - margin))).violations
    assert [v.name for v in found] == ["road end"]
    assert found[0].value == pytest.approx(margin, abs=0.05)
    assert drive.verdict(road=replace(road, road_end_s_m=float(end + 0.05))).passed


@both_roads
def test_far_beside_the_road_is_off_the_road(road):
    """So far inside a bend that the frame folds over: the samples' own d tells."""
    drive = straight_on(5.0)
    drive = drive.with_columns(d_m=drive.trajectory.d_m + 300.0)
    assert "left road edge" in names(drive.verdict(road=road))


def test_lanes_and_shoulders_bound_the_road():
    drive = straight_on(10.0)
    centred = Road(lane_width_m=1.8)
    assert drive.verdict(road=centred).passed
    assert names(drive.verdict(road=replace(centred, lane_width_m=1.7))) == ["left road edge", "right road edge"]
    aside = drive.with_columns(d_m=drive.trajectory.d_m + 1.8)
    aside = replace(aside, start=replace(aside.start, d_m=1.8))
    assert names(aside.verdict(road=centred)) == ["left road edge"]
    assert aside.verdict(road=replace(centred, lanes_left=1)).passed
    assert aside.verdict(road=replace(centred, shoulder_left_m=1.8)).passed
