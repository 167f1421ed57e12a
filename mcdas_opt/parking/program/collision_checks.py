"""Where a program checks for collisions: at nodes near an obstacle, between nodes that pass it closely, and where the clearance dipped."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import separating_lines
from mcdas_opt.parking.program.manoeuvre import Manoeuvre, node_poses
from mcdas_opt.parking.program.records import CORNERS, Checks
from mcdas_opt.parking.world import World, separation

PER_INTERVAL = 96  # points of an interval that is rolled out
Place = tuple[int, int, int]  # of a check: interval, polygon of the world, roll-out point of the interval
_CHECKS = 24  # per interval, the nearest
_CLOSE_M = 0.06  # passing nearer than this beyond the clearance asks for checks inside the interval ...
_SPACING_M = 0.1  # ... that the car passes at most so far apart
_DIP_M = 5e-5  # less clearance than asked by more than this is a dip
_AROUND_M = (0.0, 0.025, 0.06)  # where else to check where the clearance dips: the next solution dips a little farther on


class RollOut(NamedTuple):
    """n intervals at even fractions, both ends included."""

    poses: Array  # (n, points, 3)
    fractions: Array  # (points,)
    apart: Array  # (n, points, polygons) [m]

    @classmethod
    def of(cls, case: ParkingCase, world: World, manoeuvre: Manoeuvre) -> RollOut:
        poses, fractions = node_poses(case, manoeuvre, PER_INTERVAL)
        n, m = poses.shape[:2]
        apart = separation(world.whole, poses.reshape(-1, 3), world.body).reshape(n, m, len(world.whole.polygons))
        return cls(poses, fractions, apart)

    @property
    def end(self) -> Array:
        """(3,) the last pose."""
        return np.asarray(self.poses[-1, -1])

    @property
    def node_room(self) -> Array:
        """(n,) clearance [m] at each interval's first node."""
        return np.asarray(self.apart[:, 0].min(axis=1, initial=np.inf))


def places(manoeuvre: Manoeuvre, rolled: RollOut, asked_m: float, near_m: float, dips: set[Place]) -> list[Place]:
    """Where to check, in order of intervals: nodes less than `near_m` beyond the asked clearance, close passes, and `dips`.

    Close passes are added to `dips`: no check is dropped in a later round.
    """
    wanted: list[list[tuple[float, int, int]]] = [[] for _ in manoeuvre.steps]
    apart = rolled.apart
    for k, polygon in zip(*np.nonzero(apart[:, 0] < asked_m + _CLOSE_M + near_m), strict=True):
        if manoeuvre.gears[k] != 0.0:
            wanted[k].append((float(apart[k, 0, polygon]), int(polygon), 0))
    for k, polygon in zip(*np.nonzero(apart.min(axis=1) < asked_m + _CLOSE_M), strict=True):
        pieces = int(np.ceil(abs(manoeuvre.nodes[k : k + 2, 3]).mean() * manoeuvre.steps[k] / _SPACING_M))
        for piece in range(1, pieces):
            dips.add((int(k), int(polygon), round(piece * PER_INTERVAL / pieces)))
    for k, polygon, point in sorted(dips):
        wanted[k].append((float(apart[k, point, polygon]), polygon, point))
    return [(k, polygon, point) for k, entries in enumerate(wanted) for _, polygon, point in sorted(set(entries))[:_CHECKS]]


def dips_of(manoeuvre: Manoeuvre, rolled: RollOut, asked_m: float) -> set[Place]:
    """Where the clearance falls short of `asked_m`, and places around it."""
    found = set()
    worst, least = rolled.apart.argmin(axis=1), rolled.apart.min(axis=1)
    driven = manoeuvre.distances
    for k, polygon in zip(*np.nonzero(least < asked_m - _DIP_M), strict=True):
        at = int(k) * PER_INTERVAL + int(worst[k, polygon])
        each = max(float(driven[k]) / PER_INTERVAL, 1e-4)
        for offset in _AROUND_M:
            steps = max(1, round(offset / each)) if offset else 0
            for there in (at - steps, at + steps):
                if 0 < there < PER_INTERVAL * len(rolled.apart):
                    found.add((there // PER_INTERVAL, int(polygon), there % PER_INTERVAL))
    return found


def checks_at(world: World, where: list[Place], rolled: RollOut) -> Checks:
    """Separating lines and obstacle vertices at these places."""
    rows = np.array(where, dtype=np.int64).reshape(-1, 3)
    m = len(rows)
    angles, offsets, vertices = np.zeros(m), np.zeros(m), np.zeros((m, CORNERS, 2))
    for polygon in np.unique(rows[:, 1]):
        mine: NDArray[np.intp] = np.flatnonzero(rows[:, 1] == polygon)
        shape: Array = world.whole.polygons[int(polygon)]
        at = rolled.poses[rows[mine, 0], rows[mine, 2]]
        angles[mine], offsets[mine] = separating_lines(at, world.body, shape)
        depth = np.column_stack([np.cos(angles[mine]), np.sin(angles[mine])]) @ shape.T
        order = np.argsort(-depth, axis=1, kind="stable")[:, np.arange(CORNERS) % min(CORNERS, len(shape))]
        vertices[mine] = shape[order]
    return Checks(intervals=rows[:, 0], fractions=rolled.fractions[rows[:, 2]], vertices=vertices, angles=angles, offsets=offsets)
