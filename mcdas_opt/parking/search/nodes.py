"""The search's nodes, columns that grow; and which of them are expanded next: three queues share every batch."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.path import Arc

Rows = np.ndarray[tuple[int], np.dtype[np.int64]]
_CAPACITY = 4096  # to begin with
_Value = TypeVar("_Value", bound=np.generic)
_BATCH = 64
_SHARES = (0.6, 0.15, 0.25)  # of a batch, for the three queues
_CELL_FACTORS = np.array([1_000_003, 7_919_000_017, 104_395_303_000_009, 15_485_863, 32_452_843])


class Nodes:
    """Pose, parent, and the arc that led here from it: curvature, direction (+1 forward, -1 in reverse) and length. Row 0 is the root.

    The root has the direction 0. `g` is the cost from the root, `room` the clearance, `contact` whether the arc ended in contact.
    """

    def __init__(self, root: Array) -> None:
        self.count, capacity = 1, _CAPACITY
        self.pose = np.zeros((capacity, 3))
        self.pose[0] = root
        self.parent = np.full(capacity, -1, dtype=np.int64)
        self.kappa, self.direction, self.length, self.g, self.room = (np.zeros(capacity) for _ in range(5))
        self.contact, self.closed = (np.zeros(capacity, dtype=np.bool_) for _ in range(2))

    def add(self, pose: Array, parent: Rows, kappa: Array, direction: Array, length: Array, g: Array, room: Array, contact: Array) -> None:
        n = len(pose)
        while self.count + n > len(self.g):
            self._double()
        rows = slice(self.count, self.count + n)
        self.pose[rows], self.parent[rows], self.kappa[rows], self.direction[rows] = pose, parent, kappa, direction
        self.length[rows], self.g[rows], self.room[rows], self.contact[rows] = length, g, room, contact
        self.count += n

    def trail(self, node: int) -> list[Arc]:
        """The arcs from the root to a node."""
        arcs: list[Arc] = []
        while node > 0:
            arcs.append(Arc(float(self.kappa[node]), float(self.direction[node] * self.length[node])))
            node = int(self.parent[node])
        return arcs[::-1]

    def _double(self) -> None:
        self.pose, self.parent, self.kappa = _doubled(self.pose), _doubled(self.parent), _doubled(self.kappa)
        self.direction, self.length, self.g = _doubled(self.direction), _doubled(self.length), _doubled(self.g)
        self.room, self.contact, self.closed = _doubled(self.room), _doubled(self.contact), _doubled(self.closed)


def _doubled(column: NDArray[_Value]) -> NDArray[_Value]:
    return np.concatenate([column, np.zeros_like(column)])


def cheapest_of_each_cell(cells: Array, costs: Sequence[float], seen: dict[int, float]) -> dict[int, int]:
    """By the key of a cell, which five whole numbers a row say, the row that is cheaper than all before it there; `seen`, the least cost of
    each cell so far, is brought up to date."""
    keys: list[int] = (cells.astype(np.int64) @ _CELL_FACTORS).tolist()
    chosen: dict[int, int] = {}
    for row, (key, cost) in enumerate(zip(keys, costs, strict=True)):
        if cost < seen.get(key, np.inf) - 1e-9:
            seen[key] = cost
            chosen[key] = row
    return chosen


class Frontier:
    """All poses by cost and estimate; tight ones by how far they have come from the root; roomy ones by cost and estimate.

    The second queue leads out of a slot that the estimate knows nothing of. The third keeps poses outside from waiting for those inside.
    """

    def __init__(self) -> None:
        self._queues: tuple[list[tuple[float, int]], ...] = ([(0.0, 0)], [], [])

    def __bool__(self) -> bool:
        return any(self._queues)

    def restart(self, values: Array, nodes: list[int]) -> None:
        """Go on from these nodes alone."""
        for queue in self._queues:
            queue.clear()
        for value, node in zip(values.tolist(), nodes, strict=True):
            heapq.heappush(self._queues[0], (value, node))

    def push(self, first: int, estimated: Array, outward: Array, tight: Array) -> None:
        """Nodes from `first` on: cost and estimate, the order in which tight ones lead out, and whether a node is tight."""
        rows = zip(estimated.tolist(), outward.tolist(), tight.tolist(), strict=True)
        for node, (value, out, inside) in enumerate(rows, start=first):
            heapq.heappush(self._queues[0], (value, node))
            heapq.heappush(self._queues[1 if inside else 2], (out if inside else value, node))

    def pop(self, nodes: Nodes) -> Rows:
        """The next batch; its nodes are closed."""
        batch: list[int] = []
        for queue, share in zip(self._queues, _SHARES, strict=True):
            room = len(batch) + int(share * _BATCH)
            while queue and len(batch) < room:
                _, node = heapq.heappop(queue)
                if not nodes.closed[node]:
                    nodes.closed[node] = True
                    batch.append(node)
        return np.array(batch, dtype=np.int64)
