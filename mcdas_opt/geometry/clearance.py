"""The car's rectangle against convex polygons: exact signed separation, for many poses in one pass. Numpy only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.polygon import convex_parts


class Body(NamedTuple):
    """The rectangle about the rear axle's midpoint [m]: from `rear` (negative) to `front`, `half_width` to either side."""

    rear: float
    front: float
    half_width: float

    @classmethod
    def of(cls, vehicle: Vehicle) -> Body:
        """The vehicle's rectangle."""
        return cls(-vehicle.rear_overhang_m, vehicle.wheelbase_m + vehicle.front_overhang_m, 0.5 * vehicle.width_m)

    @property
    def corners(self) -> Array:
        """(4, 2), counter-clockwise from front left."""
        r, f, w = self
        return np.array([[f, w], [r, w], [r, -w], [f, -w]])

    @property
    def reach(self) -> float:
        """Distance of the farthest corner from the rear axle's midpoint [m]."""
        return float(np.hypot(max(self.front, -self.rear), self.half_width))


def body_corners(poses: Array, body: Body) -> Array:
    """(n, 4, 2): corners of the body at poses (n, 3) = x, y, heading of the rear axle's midpoint."""
    x, y, psi = poses[:, 0], poses[:, 1], poses[:, 2]
    c, s = np.cos(psi)[:, None], np.sin(psi)[:, None]
    along, across = body.corners.T
    return np.stack([x[:, None] + c * along - s * across, y[:, None] + s * along + c * across], axis=-1)


@dataclass(frozen=True, slots=True)
class PolygonField:
    """Convex counter-clockwise polygons laid out flat, so that one matrix product serves them all."""

    polygons: tuple[Array, ...]
    edges: Array  # (9, edges), one polygon's after another's: vertex, normal, its offset, tangent, its start, length
    first: NDArray[np.intp]  # (polygons + 1,) where each polygon's edges begin, and how many there are
    _centres: Array
    _radii: Array

    @classmethod
    def of(cls, polygons: Sequence[Array]) -> PolygonField:
        polygons = tuple(polygons)
        vertices = np.concatenate(polygons) if polygons else np.zeros((0, 2))
        edges = np.concatenate([np.roll(p, -1, axis=0) - p for p in polygons]) if polygons else np.zeros((0, 2))
        lengths = np.linalg.norm(edges, axis=1)
        tangents = edges / np.maximum(lengths, 1e-12)[:, None]
        normals = np.column_stack([tangents[:, 1], -tangents[:, 0]])
        first = np.concatenate([[0], np.cumsum([len(p) for p in polygons])]).astype(np.intp)
        offsets, starts = (normals * vertices).sum(1), (tangents * vertices).sum(1)
        centres = np.array([p.mean(axis=0) for p in polygons]).reshape(-1, 2)
        radii = np.array([np.linalg.norm(p - c, axis=1).max() for p, c in zip(polygons, centres, strict=True)])
        edges = np.ascontiguousarray(np.vstack([vertices.T, normals.T, offsets, tangents.T, starts, lengths]))
        return cls(polygons, edges, first, centres, radii)

    def near(self, x: float, y: float, radius: float) -> NDArray[np.intp]:
        """Indices of the polygons whose bounding circle comes within `radius` [m] of (x, y)."""
        gap = np.hypot(self._centres[:, 0] - x, self._centres[:, 1] - y) - self._radii
        return np.flatnonzero(gap <= radius)

    def only(self, indices: NDArray[np.intp]) -> PolygonField:
        """The field of some of the polygons."""
        return PolygonField.of([self.polygons[int(i)] for i in indices])

    def separation(self, poses: Array, body: Body) -> Array:
        """(n, m) signed distance [m] of the body at poses (n, 3) to each of the m polygons.

        Apart: the Euclidean distance. Overlapping: minus the least push that parts them, which for convex shapes lies along a normal
        of an edge (separating axes; Gottschalk et al., SIGGRAPH 1996).
        """
        n, m = len(poses), len(self.polygons)
        if m == 0 or n == 0:
            return np.full((n, m), np.inf)
        px, py, nx, ny, offset, tx, ty, start, length = self.edges
        x, y = body_corners(poses, body).reshape(-1, 2).T
        outward = np.multiply.outer(x, nx) + np.multiply.outer(y, ny) - offset  # no matrix product: it may round otherwise
        along = np.multiply.outer(x, tx) + np.multiply.outer(y, ty) - start
        beyond = np.maximum(along - length, -along)
        np.maximum(beyond, 0.0, out=beyond)
        squared = (outward * outward + beyond * beyond).reshape(n, 4, -1).min(1)
        gap_edges = outward.reshape(n, 4, -1).min(1)
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        ahead = np.multiply.outer(c, px) + np.multiply.outer(s, py) - (c * poses[:, 0] + s * poses[:, 1])[:, None]
        left = np.multiply.outer(c, py) - np.multiply.outer(s, px) - (c * poses[:, 1] - s * poses[:, 0])[:, None]
        out_x = np.maximum(ahead - body.front, body.rear - ahead)
        out_y = np.abs(left) - body.half_width
        np.minimum(squared, np.maximum(out_x, 0.0) ** 2 + np.maximum(out_y, 0.0) ** 2, out=squared)
        first = self.first[:-1]
        squared = np.minimum.reduceat(squared, first, axis=1)
        gap = np.maximum.reduceat(gap_edges, first, axis=1)
        np.maximum(gap, np.minimum.reduceat(ahead, first, axis=1) - body.front, out=gap)
        np.maximum(gap, body.rear - np.maximum.reduceat(ahead, first, axis=1), out=gap)
        np.maximum(gap, np.minimum.reduceat(left, first, axis=1) - body.half_width, out=gap)
        np.maximum(gap, -body.half_width - np.maximum.reduceat(left, first, axis=1), out=gap)
        return np.asarray(np.where(gap > 0.0, np.sqrt(squared), gap))

    def clearance(self, poses: Array, body: Body) -> Array:
        """(n,) least signed distance to any polygon; infinite without polygons."""
        return np.asarray(self.separation(poses, body).min(axis=1, initial=np.inf))


def obstacle_field(outlines: Sequence[Array]) -> tuple[PolygonField, list[int]]:
    """(field, owner): simple polygons cut into convex parts, and the index of the polygon that each part belongs to."""
    parts = [(k, part) for k, outline in enumerate(outlines) for part in convex_parts(outline)]
    return PolygonField.of([part for _, part in parts]), [k for k, _ in parts]


def separating_lines(poses: Array, body: Body, polygon: Array) -> tuple[Array, Array]:
    """(angles (n,), offsets (n,)): for each pose the line that parts the body from one convex polygon best.

    The normal (cos, sin of the angle) points from the polygon to the body; the polygon lies at most at the offset along it. Apart, it is
    the direction between the nearest points; overlapping, the edge normal of least push.
    """
    corners = body_corners(poses, body)
    start, edge = polygon, np.roll(polygon, -1, axis=0) - polygon
    offset = corners[:, :, None, :] - start
    share = np.clip((offset * edge).sum(-1) / np.maximum((edge * edge).sum(-1), 1e-18), 0.0, 1.0)
    from_edges = (offset - share[..., None] * edge).reshape(len(poses), -1, 2)
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    dx, dy = polygon[:, 0] - poses[:, :1], polygon[:, 1] - poses[:, 1:2]
    ahead, left = c * dx + s * dy, c * dy - s * dx
    bx = np.clip(ahead, body.rear, body.front) - ahead
    by = np.clip(left, -body.half_width, body.half_width) - left
    from_body = np.stack([c * bx - s * by, s * bx + c * by], axis=-1)
    way = np.concatenate([from_edges, from_body], axis=1)
    size = np.linalg.norm(way, axis=-1)
    best = size.argmin(axis=1)
    row = np.arange(len(poses))
    normal = way[row, best] / np.maximum(size[row, best], 1e-12)[:, None]
    edge_normals = np.column_stack([edge[:, 1], -edge[:, 0]]) / np.maximum(np.linalg.norm(edge, axis=1), 1e-12)[:, None]
    own = np.stack([np.column_stack([c, s]), np.column_stack([-s, c]), np.column_stack([-c, -s]), np.column_stack([s, -c])], axis=1)
    axes = np.concatenate([np.broadcast_to(edge_normals, (len(poses), *edge_normals.shape)), own], axis=1)
    gap = np.einsum("nad,ncd->nac", axes, corners).min(-1) - (axes @ polygon.T).max(-1)
    widest = gap.argmax(axis=1)
    touching = (gap[row, widest] <= 1e-9) | (size[row, best] <= 1e-9)
    normal = np.where(touching[:, None], axes[row, widest], normal)
    return np.arctan2(normal[:, 1], normal[:, 0]), (normal @ polygon.T).max(axis=1)
