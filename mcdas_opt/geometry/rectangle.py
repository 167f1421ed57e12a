"""Oriented rectangles: corners, signed separation, distance. Every function is vectorised over leading axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array


def corners(x: Any, y: Any, yaw: Any, length: Any, width: Any) -> Array:
    """(..., 4, 2): corners of rectangles centred at (x, y), counter-clockwise from front left."""
    x, y, yaw, length, width = np.broadcast_arrays(*(np.asarray(q, dtype=np.float64) for q in (x, y, yaw, length, width)))
    along = 0.5 * length[..., None] * np.array([1.0, -1.0, -1.0, 1.0])
    across = 0.5 * width[..., None] * np.array([1.0, 1.0, -1.0, -1.0])
    c, s = np.cos(yaw)[..., None], np.sin(yaw)[..., None]
    return np.stack([x[..., None] + c * along - s * across, y[..., None] + s * along + c * across], axis=-1)


def half_extent(yaw: Any, length: float, width: float) -> tuple[Array, Array]:
    """Half the shadows [m] on the x and the y axis of rectangles turned by yaw, each of yaw's shape."""
    c, s = np.abs(np.cos(yaw)), np.abs(np.sin(yaw))
    return 0.5 * (length * c + width * s), 0.5 * (length * s + width * c)


def separation(a: Array, b: Array) -> Array:
    """Signed separation [m] of two families of rectangles given by corners (..., 4, 2): the largest gap over the four edge normals.

    Positive: apart by at least that much (a lower bound of the distance). Negative: overlapping, by the least push that would part
    them. The separating-axis test (Gottschalk et al., SIGGRAPH 1996).
    """
    normals = []
    for r in (a, b):
        edges = np.stack([r[..., 0, :] - r[..., 1, :], r[..., 1, :] - r[..., 2, :]], axis=-2)
        normals.append(edges / np.linalg.norm(edges, axis=-1, keepdims=True))
    axes = np.concatenate(np.broadcast_arrays(*normals), axis=-2)
    pa = np.einsum("...kd,...cd->...kc", axes, a)
    pb = np.einsum("...kd,...cd->...kc", axes, b)
    gap = np.maximum(pb.min(-1) - pa.max(-1), pa.min(-1) - pb.max(-1))
    return np.asarray(gap.max(-1))


def separation_of_poses(x: Any, y: Any, yaw: Any, other_yaw: Any, half: tuple[Any, Any], other_half: tuple[Any, Any]) -> Array:
    """`separation` of rectangles (half length, half width) whose centres are (x, y) apart, without making their corners."""
    (long, wide), (other_long, other_wide) = half, other_half
    sine, cosine, other_sine, other_cosine = np.sin(yaw), np.cos(yaw), np.sin(other_yaw), np.cos(other_yaw)
    c, s = np.abs(cosine * other_cosine + sine * other_sine), np.abs(sine * other_cosine - cosine * other_sine)
    gap = np.abs(x * cosine + y * sine) - (long + other_long * c + other_wide * s)
    np.maximum(gap, np.abs(y * cosine - x * sine) - (wide + other_long * s + other_wide * c), out=gap)
    np.maximum(gap, np.abs(x * other_cosine + y * other_sine) - (other_long + long * c + wide * s), out=gap)
    return np.asarray(np.maximum(gap, np.abs(y * other_cosine - x * other_sine) - (other_wide + long * s + wide * c), out=gap))


def distance(a: Array, b: Array) -> Array:
    """Euclidean distance [m] of two families of rectangles given by corners (..., 4, 2); 0 when they touch or overlap."""
    a, b = np.broadcast_arrays(a, b)
    best = np.minimum(_corner_distance(a, b), _corner_distance(b, a))
    return np.asarray(np.where(separation(a, b) <= 0.0, 0.0, best))


def _corner_distance(points: Array, polygon: Array) -> Array:
    start = polygon[..., None, :, :]
    edge = np.roll(polygon, -1, axis=-2)[..., None, :, :] - start
    offset = points[..., :, None, :] - start
    along = np.clip((offset * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    return np.asarray(np.linalg.norm(offset - along[..., None] * edge, axis=-1).min((-1, -2)))
