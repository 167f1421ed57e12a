"""The obstacles of a case as the planners see them: tiles of the plane with the polygons that matter there."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body, PolygonField, obstacle_field
from mcdas_opt.parking.obstacle_separations import clearance

_FEW = 6  # polygons: below this, tiles do not pay
_TILE_M = 2.0
HORIZON_M = 1.2  # clearances beyond this are reported as this


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

    def _tile(self, key: tuple[int, int]) -> PolygonField:
        local = self._tiles.get(key)
        if local is None:
            x, y = (key[0] + 0.5) * _TILE_M, (key[1] + 0.5) * _TILE_M
            local = self.whole.only(self.whole.near(x, y, self.body.reach + HORIZON_M + 0.7072 * _TILE_M))
            self._tiles[key] = local
        return local


def turned_round(case: ParkingCase) -> ParkingCase:
    """The case driven backwards in time: start and goal change places, and so do the speed limits of the two gears."""
    limits = replace(case.limits, forward_mps=case.limits.reverse_mps, reverse_mps=case.limits.forward_mps)
    return replace(case, start=case.goal, goal=case.start, limits=limits, start_steering_rad=0.0)
