"""Rectangles against shapely."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import affinity

from mcdas_opt.geometry.rectangle import corners, distance, half_extent, separation

poses = st.tuples(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), st.floats(-4.0, 4.0), st.floats(0.1, 12.0), st.floats(0.1, 4.0))


def shape(x, y, yaw, length, width):
    box = shapely.box(-0.5 * length, -0.5 * width, 0.5 * length, 0.5 * width)
    return affinity.translate(affinity.rotate(box, yaw, origin=(0.0, 0.0), use_radians=True), x, y)


@given(pose=poses)
def test_corners_are_shapelys_counter_clockwise_from_front_left(pose):
    ours = corners(*pose)
    assert ours.shape == (4, 2)
    theirs = shape(*pose)
    assert shapely.hausdorff_distance(shapely.Polygon(ours), theirs) == pytest.approx(0.0, abs=1e-9)
    assert shapely.Polygon(ours).exterior.is_ccw
    x, y, yaw, length, width = pose
    front_left = (
        x + 0.5 * length * math.cos(yaw) - 0.5 * width * math.sin(yaw),
        y + 0.5 * length * math.sin(yaw) + 0.5 * width * math.cos(yaw),
    )
    assert ours[0] == pytest.approx(front_left)


@given(one=poses, other=poses)
def test_distance_is_shapelys(one, other):
    ours = float(distance(corners(*one), corners(*other)))
    assert ours == pytest.approx(shape(*one).distance(shape(*other)), abs=1e-9)


@given(one=poses, other=poses)
def test_separation_has_the_sign_of_shapelys_overlap_and_bounds_the_distance(one, other):
    a, b = corners(*one), corners(*other)
    apart = float(separation(a, b))
    overlap = shape(*one).intersection(shape(*other)).area
    assert apart == pytest.approx(float(separation(b, a)), abs=1e-9)
    if overlap > 1e-6:
        assert apart < 0.0
    if apart > 1e-9:
        assert overlap == 0.0
        assert apart <= float(distance(a, b)) + 1e-9


@given(one=poses, other=poses)
def test_pushed_by_the_depth_along_its_axis_an_overlap_ends(one, other):
    a, b = corners(*one), corners(*other)
    depth = -float(separation(a, b))
    if depth > 1e-6:
        angles = [yaw + k * math.pi / 2 for yaw in (one[2], other[2]) for k in range(4)]
        pushed = [b + (depth + 1e-6) * np.array([math.cos(t), math.sin(t)]) for t in angles]
        assert max(float(separation(a, p)) for p in pushed) >= -1e-9


@given(pose=poses)
def test_half_extent_is_half_the_bounding_box(pose):
    x_low, y_low, x_high, y_high = shape(*pose).bounds
    ahead, aside = half_extent(pose[2], pose[3], pose[4])
    assert (2.0 * ahead, 2.0 * aside) == pytest.approx((x_high - x_low, y_high - y_low))


def test_many_pairs_at_once_are_each_pair_alone():
    rng = np.random.default_rng(3)
    a = corners(*rng.uniform(-4.0, 4.0, (3, 20)), rng.uniform(1.0, 5.0, 20), rng.uniform(0.5, 2.0, 20))
    b = corners(*rng.uniform(-4.0, 4.0, (3, 20)), 4.5, 1.8)
    for f in (separation, distance):
        assert f(a, b) == pytest.approx([float(f(p, q)) for p, q in zip(a, b, strict=True)], abs=1e-12)
        assert f(a, b[0]) == pytest.approx([float(f(p, b[0])) for p in a], abs=1e-12)
