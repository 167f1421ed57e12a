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
    sides = np.concatenate([r[..., :2, :] - r[..., 1:3, :] for r in (a_start, a_end, b_start, b_end)], axis=-2)
    moved_a, moved_b = a_end - a_start, b_end - b_start
    drift_a = moved_a - moved_b.mean(axis=-2, keepdims=True)
    drift_b = moved_b - moved_a.mean(axis=-2, keepdims=True)
    along = np.concatenate([sides, drift_a, drift_b], axis=-2)
    size = np.sqrt((along * along).sum(-1))
    resting = size < 1e-12
    axes = np.stack([-along[..., 1], along[..., 0]], axis=-1) / np.where(resting, 1.0, size)[..., None]
    low, high = [], []
    for r in (a_start, a_end, b_start, b_end):
        shadow = axes @ np.swapaxes(r, -1, -2)
        low.append(shadow.min(-1))
        high.append(shadow.max(-1))
    b_ahead = np.minimum(low[2] - high[0], low[3] - high[1])
    a_ahead = np.minimum(low[0] - high[2], low[1] - high[3])
    gap = np.where(resting, -np.inf, np.maximum(b_ahead, a_ahead))
    return np.asarray(gap.max(-1))
