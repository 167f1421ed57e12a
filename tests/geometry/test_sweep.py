"""The swept test against shapely, looked at in forty instants of the step."""

from __future__ import annotations

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.geometry.rectangle import corners, separation
from mcdas_opt.geometry.sweep import swept_separation

places = st.tuples(st.floats(-6.0, 6.0), st.floats(-6.0, 6.0), st.floats(-3.2, 3.2))
sizes = st.tuples(st.floats(0.05, 6.0), st.floats(0.05, 2.5))
ways = st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))


def moved(place, size, way, turn):
    x, y, yaw = place
    return corners(x, y, yaw, *size), corners(x + way[0], y + way[1], yaw + turn, *size)


@settings(max_examples=150, deadline=None)
@given(a=places, b=places, size_a=sizes, size_b=sizes, way=ways, turn_a=st.floats(-0.03, 0.03), turn_b=st.floats(-0.03, 0.03))
def test_whoever_meets_within_the_step_is_not_separated(a, b, size_a, size_b, way, turn_a, turn_b):
    a0, a1 = moved(a, size_a, (0.3, 0.0), turn_a)
    b0, b1 = moved(b, size_b, way, turn_b)
    gap = float(swept_separation(a0, a1, b0, b1))
    share = np.linspace(0.0, 1.0, 41)[:, None, None]
    one, other = a0 + share * (a1 - a0), b0 + share * (b1 - b0)
    one, other = shapely.polygons(one), shapely.polygons(other)
    assert gap <= shapely.distance(one, other).min() + 1e-9
    if shapely.area(shapely.intersection(one, other)).max() > 1e-6:
        assert gap < 0.0


@settings(max_examples=150, deadline=None)
@given(a=places, b=places, size_a=sizes, size_b=sizes, way=ways)
def test_without_turning_it_is_exact(a, b, size_a, size_b, way):
    """Two bodies that only slide: separated exactly when the hull that b sweeps relative to a is clear of a."""
    a0, a1 = moved(a, size_a, (0.3, -0.1), 0.0)
    b0, b1 = moved(b, size_b, way, 0.0)
    gap = float(swept_separation(a0, a1, b0, b1))
    relative = b1 - (a1 - a0)
    hull = shapely.MultiPoint(np.concatenate([b0, relative])).convex_hull
    apart = hull.distance(shapely.Polygon(a0))
    if apart > 1e-6:
        assert 0.0 < gap <= apart + 1e-9
    elif hull.intersection(shapely.Polygon(a0)).area > 1e-6:
        assert gap < 0.0


def test_a_thin_fast_body_does_not_tunnel():
    host = corners(0.0, 0.0, 0.0, 4.5, 1.8)
    before, after = corners(0.5, 8.0, 0.0, 0.1, 0.1), corners(-0.5, -8.0, 0.0, 0.1, 0.1)
    assert separation(host, before) > 0.0
    assert separation(host, after) > 0.0
    assert swept_separation(host, host, before, after) < 0.0


def test_standing_bodies_keep_their_separation():
    a, b = corners(0.0, 0.0, 0.3, 4.5, 1.8), corners(7.0, 1.0, -0.2, 4.5, 1.8)
    assert abs(swept_separation(a, a, b, b) - separation(a, b)) < 1e-12
