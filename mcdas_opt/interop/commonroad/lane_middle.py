"""The middle and the width of a lanelet, whatever vertices its two sides are drawn with."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array

_FACING = 1.1  # vertices of one number face one another if they are no further apart than so many times the lane is wide there
_EVERY_M = 1.0
_SAME_M = 1e-6  # points that are no further apart are one


def lane_middle(lanelet: Any) -> tuple[Array, Array]:
    """Points (n, 2) along the middle, and the width (n,) at each [m].

    The two sides of a lanelet have equally many vertices, and on many maps those of one number do not lie opposite each other: then
    "half of both" is not the middle, and their distance not the width. There every metre of a side is paired with the nearest point
    of the other.
    """
    left, right = (np.asarray(side, dtype=np.float64) for side in (lanelet.left_vertices, lanelet.right_vertices))
    apart = np.hypot(*(left - right).T)
    if (apart <= _FACING * np.maximum(_off(left, right), _off(right, left)) + _SAME_M).all():
        return np.asarray(lanelet.center_vertices, dtype=np.float64), apart
    left, right = _paired(left, right)
    middle = 0.5 * (left + right)
    kept = np.concatenate([[True], np.hypot(*np.diff(middle, axis=0).T) > _SAME_M])
    return middle[kept], np.hypot(*(left - right).T)[kept]


def _off(points: Array, line: Array) -> Array:
    import shapely

    return np.asarray(shapely.distance(shapely.points(points), shapely.LineString(line)))


def _paired(left: Array, right: Array) -> tuple[Array, Array]:
    """Points of both sides that lie opposite each other, from the first to the last of both."""
    import shapely

    one, other = shapely.LineString(left), shapely.LineString(right)

    def facing(line: Any, towards: Any) -> tuple[Array, Array]:
        along = np.linspace(0.0, line.length, max(round(line.length / _EVERY_M), 1) + 1)
        nearest = np.asarray(shapely.line_locate_point(towards, shapely.line_interpolate_point(line, along)))
        nearest[0], nearest[-1] = 0.0, towards.length
        return along, np.maximum.accumulate(nearest)

    by_left, by_right = facing(one, other), facing(other, one)
    on_left, on_right = np.concatenate([by_left[0], by_right[1]]), np.concatenate([by_left[1], by_right[0]])
    order = np.argsort(on_left + on_right, kind="stable")
    both = (np.maximum.accumulate(on_left[order]), np.maximum.accumulate(on_right[order]))
    found = [shapely.get_coordinates(shapely.line_interpolate_point(line, at)) for line, at in zip((one, other), both, strict=True)]
    return found[0], found[1]
