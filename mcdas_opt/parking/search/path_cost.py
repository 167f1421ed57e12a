"""What a path of arcs costs, in seconds, roughly: enough to rank paths before anything is driven; and how far it is round the obstacles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body
from mcdas_opt.parking.path import Arc, top_curvature
from mcdas_opt.parking.search.reeds_shepp import WORD_TURNS, reeds_shepp
from mcdas_opt.parking.world import World

_GRID_M = 0.25
_BEYOND_M = 8.0  # how far around both ends a detour may lead
_NO_PATH_M = 60.0
_GEAR_S = 0.8
_STEERING_SHARE = 0.6  # of the time that steering takes at standstill
_SPEED_SHARE = 0.7  # of the mean speed limit


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


@dataclass(frozen=True, slots=True)
class PathCost:
    """Length over speed, a cost per gear change, and a share of the time that steering takes at standstill."""

    speed_mps: float
    steering_s_per_1pm: float  # for a change of curvature
    radius_m: float
    detours: Detours | None = None

    @classmethod
    def of(cls, case: ParkingCase, detours: Detours | None = None) -> PathCost:
        car, top = case.vehicle, top_curvature(case.vehicle)
        lock_s = car.steering_max_rad / car.steering_rate_max_radps
        speed = _SPEED_SHARE * 0.5 * (case.limits.forward_mps + case.limits.reverse_mps)
        return cls(speed, _STEERING_SHARE * lock_s / top, 1.0 / top, detours)

    def step(self, direction0: Array, kappa0: Array, direction: Array, kappa: Array, length: Array) -> Array:
        """Of an arc after another one (direction 0: after none)."""
        change = (direction0 != 0.0) & (direction0 != direction)
        steer = np.where(direction0 == 0.0, 0.0, np.abs(kappa - kappa0))
        return np.asarray(length / self.speed_mps + _GEAR_S * change + self.steering_s_per_1pm * steer)

    def words(self, lengths: Array, direction0: Array, kappa0: Array) -> Array:
        """(n, 44) of Reeds-Shepp words after an arc; infinite where a word does not exist."""
        total = np.abs(lengths).sum(-1)
        sign = np.sign(lengths)
        changes = (sign[..., 1:] * sign[..., :-1] < 0.0).sum(-1) + (sign[..., 0] * direction0[:, None] < 0.0)
        turns = np.abs(np.diff(WORD_TURNS, axis=1)) * (np.abs(lengths[..., 1:]) > 1e-9)
        first_turn = np.abs(WORD_TURNS[:, 0] - kappa0[:, None] * self.radius_m)
        steer = turns.sum(-1) + np.where(direction0[:, None] == 0.0, 0.0, first_turn)
        value = total / self.speed_mps + _GEAR_S * changes + self.steering_s_per_1pm / self.radius_m * steer
        return np.where(np.isnan(value), np.inf, value)

    def path(self, arcs: tuple[Arc, ...]) -> float:
        """Of arcs one after another, from rest."""
        value = 0.0
        gear, kappa = 0.0, 0.0
        for arc in arcs:
            value += float(self.step(*(np.asarray(q) for q in (gear, kappa, arc.gear, arc.curvature, abs(arc.length)))))
            gear, kappa = arc.gear, arc.curvature
        return value

    def estimate(self, poses: Array, target: Array) -> Array:
        """Of the rest of the path from poses (n, 3) to `target`: Reeds-Shepp without obstacles, or a point's path round them."""
        free = np.zeros(len(poses))
        value = self.words(reeds_shepp(poses, target, self.radius_m), free, free).min(axis=1)
        if self.detours is None:
            return np.asarray(value)
        return np.asarray(np.maximum(value, self.detours.lengths(poses) / self.speed_mps))
