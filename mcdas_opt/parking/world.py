"""The obstacles of a case as the planners see them: tiles of the plane with the polygons that matter there; separations from them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body, PolygonField, obstacle_field
from mcdas_opt.native.library import library

_FEW = 6  # polygons: below this, tiles do not pay
_TILE_M = 2.0
_AROUND_M = 2.0  # of a path: polygons farther away do not matter to it
HORIZON_M = 1.2  # clearances beyond this are reported as this


def separation(field: PolygonField, poses: Array, body: Body) -> Array:
    """(n, m) signed distance [m] of the body at poses (n, 3) to each of the field's m polygons.

    Sines and cosines are numpy's in both forms, so that both give the same bits.
    """
    apart = _compiled(field, poses, body, least=False)
    return field.separation(poses, body) if apart is None else apart


def clearance(field: PolygonField, poses: Array, body: Body) -> Array:
    """(n,) least of the `separation`s; infinite without polygons."""
    apart = _compiled(field, poses, body, least=True)
    return field.clearance(poses, body) if apart is None else apart


def _compiled(field: PolygonField, poses: Array, body: Body, *, least: bool) -> Array | None:
    compiled = library()
    if compiled is None:
        return None
    poses = np.ascontiguousarray(poses, dtype=np.float64)
    n, m, heading = len(poses), len(field.polygons), np.ascontiguousarray(poses[:, 2])
    apart = np.empty(n if least else (n, m))
    given = poses, np.cos(heading), np.sin(heading), np.array(body), body.corners, field.edges
    compiled.mcdas_polygon_separations(n, m, least, field.first, *given, apart)
    return apart


@dataclass(slots=True)
class World:
    """Body and obstacles; `clearance` is exact up to `HORIZON_M` and capped there. Holds a cache of tiles, nothing else changes."""

    body: Body
    whole: PolygonField
    owner: list[int]
    _tiles: dict[tuple[int, int], PolygonField] = field(default_factory=dict)

    @classmethod
    def of(cls, case: ParkingCase) -> World:
        field, owner = obstacle_field(case.obstacles)
        return cls(Body.of(case.vehicle), field, owner)

    def clearance(self, poses: Array) -> Array:
        """(n,) signed distance [m] of the body to the nearest obstacle, at most `HORIZON_M`."""
        if len(self.whole.polygons) <= _FEW:
            return np.asarray(np.minimum(clearance(self.whole, poses, self.body), HORIZON_M))
        found = np.full(len(poses), HORIZON_M)
        tiles = np.floor(poses[:, :2] / _TILE_M).astype(np.int64)
        keys = tiles[:, 0] * 1_000_003 + tiles[:, 1]
        order = np.argsort(keys, kind="stable")
        cuts = np.flatnonzero(np.diff(keys[order])) + 1
        for group in np.split(order, cuts):
            if group.size == 0:
                continue
            local = self._tile((int(tiles[group[0], 0]), int(tiles[group[0], 1])))
            if local.polygons:
                found[group] = np.minimum(clearance(local, poses[group], self.body), HORIZON_M)
        return found

    def near(self, nodes: Array) -> NDArray[np.intp]:
        """Indices of the polygons around a path (n, >= 2): those that the body can come near to."""
        centre = 0.5 * (nodes[:, :2].max(0) + nodes[:, :2].min(0))
        spread = float(np.hypot(*(nodes[:, :2] - centre).T).max())
        return self.whole.near(float(centre[0]), float(centre[1]), spread + self.body.reach + _AROUND_M)

    def only(self, indices: NDArray[np.intp]) -> World:
        """The world of some of the polygons."""
        if indices.size == len(self.whole.polygons):
            return self
        return World(self.body, self.whole.only(indices), [self.owner[int(k)] for k in indices])

    def _tile(self, key: tuple[int, int]) -> PolygonField:
        local = self._tiles.get(key)
        if local is None:
            x, y = (key[0] + 0.5) * _TILE_M, (key[1] + 0.5) * _TILE_M
            local = self.whole.only(self.whole.near(x, y, self.body.reach + HORIZON_M + 0.7072 * _TILE_M))
            self._tiles[key] = local
        return local
