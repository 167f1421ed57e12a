"""Moving rectangles: do they stay apart throughout a step?"""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array


def swept_separation(a_start: Array, a_end: Array, b_start: Array, b_end: Array) -> Array:
    """Signed separation [m] kept throughout a step by two families of moving rectangles, corners (..., 4, 2) at its start and end.

    Corners move on straight lines at constant speed. Along a fixed axis the gap of two such bodies is a concave function of time, so
    that it never falls below the smaller of its two end values: the answer is the best of those over the edge normals of all four
    rectangles and the normals of the way of every corner relative to the other body. That is the separating-axis test on the swept
    hulls: fast or thin bodies do not slip through. Negative where no axis parts them all the time.
    """
    ways = [np.ascontiguousarray(np.moveaxis(corners, (-1, -2), (0, 1))) for corners in (a_start, a_end, b_start, b_end)]  # (2, 4, ...)
    a_moves, b_moves = ways[1] - ways[0], ways[3] - ways[2]
    drifts = (a_moves - b_moves.mean(axis=1, keepdims=True), b_moves - a_moves.mean(axis=1, keepdims=True))
    along = np.concatenate([*(way[:, :2] - way[:, 1:3] for way in ways), *drifts], axis=1)
    size = np.sqrt(along[0] * along[0] + along[1] * along[1])
    resting = size < 1e-12
    scale = np.where(resting, 1.0, size)
    axis_x, axis_y = (-along[1] / scale)[:, None], (along[0] / scale)[:, None]
    shadows = [axis_x * x + axis_y * y for x, y in ways]  # (axes, 4, ...)
    low, high = [shadow.min(axis=1) for shadow in shadows], [shadow.max(axis=1) for shadow in shadows]
    b_ahead = np.minimum(low[2] - high[0], low[3] - high[1])
    a_ahead = np.minimum(low[0] - high[2], low[1] - high[3])
    return np.asarray(np.where(resting, -np.inf, np.maximum(b_ahead, a_ahead)).max(axis=0))
