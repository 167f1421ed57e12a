"""What a path of arcs costs, in seconds, roughly: enough to rank paths before anything is driven."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body, PolygonField
from mcdas_opt.parking.path import Arc
from mcdas_opt.parking.search.reeds_shepp import WORD_TURNS, reeds_shepp

_GRID_M = 0.25
_BEYOND_M = 8.0  # how far around both ends a detour may lead


@dataclass(slots=True)
class PathCost:
    """Length over speed, a price per gear change, and a share of the time that steering takes at standstill."""

    speed_mps: float
    gear_s: float
    steering_s_per_1pm: float  # for a change of curvature
    radius_m: float
    _grid: Array | None = field(default=None, repr=False)
    _corner: Array = field(default_factory=lambda: np.zeros(2), repr=False)

    @classmethod
    def of(cls, case: ParkingCase, gear_s: float = 0.8, steering_share: float = 0.6) -> PathCost:
        car = case.vehicle
        top = float(np.tan(car.steering_max_rad)) / car.wheelbase_m
        lock_s = car.steering_max_rad / car.steering_rate_max_radps
        speed = 0.7 * 0.5 * (case.limits.forward_mps + case.limits.reverse_mps)
        return cls(speed, gear_s, steering_share * lock_s / top, 1.0 / top)

    def step(self, way0: Array, kappa0: Array, way: Array, kappa: Array, length: Array) -> Array:
        """Of an arc after another one (way 0: after none)."""
        change = (way0 != 0.0) & (way0 != way)
        steer = np.where(way0 == 0.0, 0.0, np.abs(kappa - kappa0))
        return np.asarray(length / self.speed_mps + self.gear_s * change + self.steering_s_per_1pm * steer)

    def words(self, lengths: Array, way0: Array, kappa0: Array) -> Array:
        """(n, 44) of Reeds-Shepp words after an arc; infinite where a word does not exist."""
        total = np.abs(lengths).sum(-1)
        sign = np.sign(lengths)
        changes = (sign[..., 1:] * sign[..., :-1] < 0.0).sum(-1) + (sign[..., 0] * way0[:, None] < 0.0)
        turns = np.abs(np.diff(WORD_TURNS, axis=1)) * (np.abs(lengths[..., 1:]) > 1e-9)
        steer = turns.sum(-1) + np.where(way0[:, None] == 0.0, 0.0, np.abs(WORD_TURNS[:, 0] - kappa0[:, None] * self.radius_m))
        value = total / self.speed_mps + self.gear_s * changes + self.steering_s_per_1pm / self.radius_m * steer
        return np.where(np.isnan(value), np.inf, value)

    def path(self, arcs: tuple[Arc, ...]) -> float:
        value = 0.0
        way, kappa = 0.0, 0.0
        for arc in arcs:
            now = 1.0 if arc.length > 0.0 else -1.0
            value += float(self.step(*(np.asarray(q) for q in (way, kappa, now, arc.curvature, abs(arc.length)))))
            way, kappa = now, arc.curvature
        return value

    def estimate(self, poses: Array, target: Array) -> Array:
        """Of the rest of the way from poses (n, 3) to `target`: Reeds-Shepp without obstacles, or a point's way round them."""
        free = np.zeros(len(poses))
        value = self.words(reeds_shepp(poses, target, self.radius_m), free, free).min(axis=1)
        if self._grid is not None:
            cell = np.round((poses[:, :2] - self._corner) / _GRID_M).astype(np.int64)
            inside = np.all((cell >= 0) & (cell < np.array(self._grid.shape)), axis=1)
            cell[~inside] = 0
            way = np.where(inside, self._grid[cell[:, 0], cell[:, 1]], np.inf)
            value = np.maximum(value, np.where(np.isfinite(way), way, 60.0) / self.speed_mps)
        return np.asarray(value)

    def learn_detours(self, case: ParkingCase, obstacles: PolygonField, body: Body) -> None:
        """Fill the table of a disc's shortest ways to the start around the obstacles (the disc fits inside the body)."""
        from scipy.sparse import csr_matrix
        from scipy.sparse.csgraph import dijkstra

        ends = np.array([case.start[:2], case.goal[:2]])
        self._corner = ends.min(0) - _BEYOND_M
        shape = tuple(int(q) for q in np.ceil((ends.max(0) + _BEYOND_M - self._corner) / _GRID_M).astype(int) + 1)
        x, y = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
        points = np.column_stack([self._corner[0] + _GRID_M * x.ravel(), self._corner[1] + _GRID_M * y.ravel(), np.zeros(x.size)])
        radius = min(body.half_width, -body.rear) + case.limits.clearance_m - _GRID_M
        open_ = obstacles.clearance(points, Body(-1e-6, 1e-6, 1e-6)) >= radius
        number = np.arange(x.size).reshape(shape)
        rows, columns, lengths = [], [], []
        for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
            a = number[: shape[0] - dx, max(0, -dy) : shape[1] - max(0, dy)].ravel()
            b = number[dx:, max(0, dy) : shape[1] + min(0, dy)].ravel()
            good = open_[a] & open_[b]
            rows.append(a[good])
            columns.append(b[good])
            lengths.append(np.full(int(good.sum()), _GRID_M * float(np.hypot(dx, dy))))
        graph = csr_matrix((np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))), shape=(x.size, x.size))
        cell = np.round((case.start[:2] - self._corner) / _GRID_M).astype(int)
        away = dijkstra(graph, directed=False, indices=np.array([number[cell[0], cell[1]]]))[0]
        self._grid = np.asarray(away).reshape(shape)
