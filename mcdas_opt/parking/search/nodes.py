"""The search's nodes: columns that grow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.path import Arc

_Rows = np.ndarray[tuple[int], np.dtype[np.int64]]


class Nodes:
    """Pose, parent, and the arc that led here from it. Row 0 is the root, which came from nowhere (way 0)."""

    def __init__(self, root: Array, capacity: int = 4096) -> None:
        self.count = 1
        self.pose = np.zeros((capacity, 3))
        self.pose[0] = root
        self.parent = np.full(capacity, -1, dtype=np.int64)
        self.kappa, self.way, self.length, self.g, self.room = (np.zeros(capacity) for _ in range(5))
        self.contact, self.closed = (np.zeros(capacity, dtype=np.bool_) for _ in range(2))

    def add(self, pose: Array, parent: _Rows, kappa: Array, way: Array, length: Array, g: Array, room: Array, contact: Array) -> None:
        n = len(pose)
        while self.count + n > len(self.g):
            for name in ("pose", "parent", "kappa", "way", "length", "g", "room", "contact", "closed"):
                column = getattr(self, name)
                setattr(self, name, np.concatenate([column, np.zeros_like(column)]))
        rows = slice(self.count, self.count + n)
        self.pose[rows], self.parent[rows], self.kappa[rows], self.way[rows] = pose, parent, kappa, way
        self.length[rows], self.g[rows], self.room[rows], self.contact[rows] = length, g, room, contact
        self.count += n

    def trail(self, node: int) -> list[Arc]:
        """The arcs from the root to a node."""
        arcs: list[Arc] = []
        while node > 0:
            arcs.append(Arc(float(self.kappa[node]), float(self.way[node] * self.length[node])))
            node = int(self.parent[node])
        return arcs[::-1]


def cheapest_of_each_cell(keys: Sequence[int], costs: Sequence[float], seen: dict[int, float]) -> dict[int, int]:
    """By cell, the row that is cheaper than all before it there; `seen`, the least cost of each cell so far, is brought up to date."""
    chosen: dict[int, int] = {}
    for row, (key, cost) in enumerate(zip(keys, costs, strict=True)):
        if cost < seen.get(key, np.inf) - 1e-9:
            seen[key] = cost
            chosen[key] = row
    return chosen
