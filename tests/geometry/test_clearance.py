"""The body against polygons: shapely agrees, and so do the laws of distance."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.geometry.clearance import Body, PolygonField, body_corners, separating_lines
from mcdas_opt.geometry.polygon import convex_hull, convex_parts, is_convex, is_simple, signed_area

shapely = pytest.importorskip("shapely.geometry")
BODY = Body(-0.9, 3.6, 0.9)
pose = st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-4, 4))
grid = st.integers(-50, 50).map(lambda n: n / 10)
cloud = st.lists(st.tuples(grid, grid), min_size=3, max_size=8)


def hull_of(points: list[tuple[float, float]]) -> np.ndarray | None:
    hull = convex_hull(np.array(points))
    return hull if len(hull) >= 3 and signed_area(hull) > 0.05 else None


@settings(max_examples=100, deadline=None)
@given(cloud, cloud, pose)
def test_separation_is_shapelys_distance(first, second, where):
    polygons = [p for p in (hull_of(first), hull_of(second)) if p is not None]
    poses = np.array([where])
    found = PolygonField.of(polygons).separation(poses, BODY)[0]
    body = shapely.Polygon(body_corners(poses, BODY)[0])
    for apart, polygon in zip(found, polygons, strict=True):
        true = body.distance(shapely.Polygon(polygon))
        if true > 1e-9:
            assert apart == pytest.approx(true, abs=1e-9)
        else:
            assert apart <= 1e-9


@settings(max_examples=100, deadline=None)
@given(cloud, pose)
def test_pushing_out_by_the_depth_parts_the_bodies(points, where):
    polygon = hull_of(points)
    if polygon is None:
        return
    depth = -PolygonField.of([polygon]).separation(np.array([where]), BODY)[0, 0]
    if depth <= 1e-6:
        return
    ways = np.linspace(0, 2 * math.pi, 721)
    pushed = np.array([[where[0] + 1.001 * depth * math.cos(w), where[1] + 1.001 * depth * math.sin(w), where[2]] for w in ways])
    less = np.array([[where[0] + 0.98 * depth * math.cos(w), where[1] + 0.98 * depth * math.sin(w), where[2]] for w in ways])
    field = PolygonField.of([polygon])
    assert field.separation(pushed, BODY).max() >= -2e-3 * depth - 1e-9
    assert field.separation(less, BODY).max() <= 1e-9


@settings(max_examples=60, deadline=None)
@given(cloud, pose)
def test_the_separating_line_leaves_the_distance_between(points, where):
    polygon = hull_of(points)
    if polygon is None:
        return
    poses = np.array([where])
    apart = PolygonField.of([polygon]).separation(poses, BODY)[0, 0]
    angle, offset = separating_lines(poses, BODY, polygon)
    normal = np.array([math.cos(angle[0]), math.sin(angle[0])])
    assert (polygon @ normal).max() == pytest.approx(offset[0], abs=1e-9)
    assert (body_corners(poses, BODY)[0] @ normal).min() - offset[0] == pytest.approx(apart, abs=1e-7)


def test_convex_parts_cover_exactly_the_polygon():
    shape = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0], [5.0, 3.0], [5.0, 4.0], [0.0, 4.0]])
    parts = convex_parts(shape)
    assert all(is_convex(part) and signed_area(part) > 0.0 for part in parts)
    assert sum(signed_area(part) for part in parts) == pytest.approx(signed_area(shape))
    union = shapely.Polygon()
    for part in parts:
        union = union.union(shapely.Polygon(part))
    assert union.symmetric_difference(shapely.Polygon(shape)).area == pytest.approx(0.0, abs=1e-9)


def test_a_bow_tie_is_not_simple():
    assert not is_simple(np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]))
    assert is_simple(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]))
