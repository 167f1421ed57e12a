"""How far it is round the obstacles: shortest paths of a disc that fits inside the body, on a grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body
from mcdas_opt.parking.world import World

_GRID_M = 0.25
_BEYOND_M = 8.0  # how far around both ends a detour may lead
_NO_PATH_M = 60.0


@dataclass(frozen=True, slots=True)
class Detours:
    """Shortest lengths (cells along x, cells along y) [m] from the case's start; `corner` is the first cell's centre."""

    table: Array
    corner: Array

    @classmethod
    def of(cls, case: ParkingCase, world: World) -> Detours:
        from scipy.sparse import csr_matrix
        from scipy.sparse.csgraph import dijkstra

        ends = np.array([case.start[:2], case.goal[:2]])
        corner = ends.min(0) - _BEYOND_M
        shape = tuple(int(q) for q in np.ceil((ends.max(0) + _BEYOND_M - corner) / _GRID_M).astype(int) + 1)
        x, y = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
        points = np.column_stack([corner[0] + _GRID_M * x.ravel(), corner[1] + _GRID_M * y.ravel(), np.zeros(x.size)])
        radius = min(world.body.half_width, -world.body.rear) + case.limits.clearance_m - _GRID_M
        free = world.whole.clearance(points, Body(-1e-6, 1e-6, 1e-6)) >= radius
        number = np.arange(x.size).reshape(shape)
        rows, columns, lengths = [], [], []
        for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
            a = number[: shape[0] - dx, max(0, -dy) : shape[1] - max(0, dy)].ravel()
            b = number[dx:, max(0, dy) : shape[1] + min(0, dy)].ravel()
            joined = free[a] & free[b]
            rows.append(a[joined])
            columns.append(b[joined])
            lengths.append(np.full(int(joined.sum()), _GRID_M * float(np.hypot(dx, dy))))
        graph = csr_matrix((np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))), shape=(x.size, x.size))
        cell = np.round((case.start[:2] - corner) / _GRID_M).astype(int)
        away = dijkstra(graph, directed=False, indices=np.array([number[cell[0], cell[1]]]))[0]
        return cls(np.asarray(away).reshape(shape), corner)

    def lengths(self, poses: Array) -> Array:
        """(n,) [m] from poses (n, 3) to the case's start; 60 m where there is no path, and outside the grid."""
        cell = np.round((poses[:, :2] - self.corner) / _GRID_M).astype(np.int64)
        inside = np.all((cell >= 0) & (cell < np.array(self.table.shape)), axis=1)
        cell[~inside] = 0
        away = np.where(inside, self.table[cell[:, 0], cell[:, 1]], np.inf)
        return np.where(np.isfinite(away), away, _NO_PATH_M)
