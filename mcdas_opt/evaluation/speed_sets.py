"""Sets of (place, speed) that a car under bounded acceleration may be in: convex polygons, moved and cut."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.polygon import convex_hull

EMPTY: Array = np.zeros((0, 2))
_ROUND = 9  # decimals below which two corners are one


def moved(corners: Array, step_s: float, least_mps2: float, most_mps2: float, short_mps: Array | float = 0.0, faster: float = 0.0) -> Array:
    """The corners (m, 2) of (s, v) after a step, whatever the acceleration between its bounds has been within it.

    The pairs (gain in s, gain in v) that such an acceleration can make lie between two parabolas; they are replaced by the
    parallelogram of the parabolas' tangents at the ends, which errs outwards. `short_mps` is by how much ds/dt may fall short of the
    speed, for each corner (convex in the speed between any two of them), `faster` the share by which it may exceed it.
    """
    h, span = step_s, most_mps2 - least_mps2
    held = corners + np.column_stack([corners[:, 1] * h, np.zeros(len(corners))]) + np.array([0.5 * least_mps2 * h * h, least_mps2 * h])
    late, early = np.array([0.0, 0.5 * span * h]), np.array([0.5 * span * h * h, 0.5 * span * h])
    cloud = np.concatenate([held, held + late, held + early, held + late + early])
    parts = [cloud]
    if np.any(short_mps):
        parts.append(cloud - np.column_stack([np.tile(short_mps * np.ones(len(corners)), 4) * h, np.zeros(len(cloud))]))
    if faster:
        forward = np.maximum(corners[:, 1], 0.0) + max(most_mps2, 0.0) * h
        parts.append(cloud + np.column_stack([np.tile(faster * forward, 4) * h, np.zeros(len(cloud))]))
    return hull(np.concatenate(parts))


def with_speed(corners: Array, speed_mps: float) -> Array:
    """The polygon with corners also where its sides cross a speed."""
    nxt = np.roll(corners, -1, axis=0)
    crossing = (corners[:, 1] - speed_mps) * (nxt[:, 1] - speed_mps) < 0.0
    if not crossing.any():
        return corners
    a, b = corners[crossing], nxt[crossing]
    share = (speed_mps - a[:, 1]) / (b[:, 1] - a[:, 1])
    return np.concatenate([corners, np.column_stack([a[:, 0] + share * (b[:, 0] - a[:, 0]), np.full(len(a), speed_mps)])])


def hull(points: Array) -> Array:
    """Corners of the convex hull, counter-clockwise; one or two points are their own hull."""
    return convex_hull(np.round(points, _ROUND))


def at_most(corners: Array, column: int, value: float) -> Array:
    """What of the polygon has its place (column 0) or its speed (column 1) at most at `value`."""
    return _cut(corners, corners[:, column] - value) if len(corners) else corners


def at_least(corners: Array, column: int, value: float) -> Array:
    """What of the polygon has its place (column 0) or its speed (column 1) at least at `value`."""
    return _cut(corners, value - corners[:, column]) if len(corners) else corners


def _cut(corners: Array, beyond: Array) -> Array:
    """The part where `beyond` (one value a corner, affine) is not positive (Sutherland and Hodgman 1974)."""
    inside = beyond <= 0.0
    if inside.all():
        return corners
    if not inside.any():
        return EMPTY
    out: list[Array] = []
    for i in range(len(corners)):
        j = (i + 1) % len(corners)
        if inside[i]:
            out.append(corners[i])
        if inside[i] != inside[j]:
            share = beyond[i] / (beyond[i] - beyond[j])
            out.append(corners[i] + share * (corners[j] - corners[i]))
    return np.array(out)
