"""Which nodes of the search are expanded next: three queues share every batch."""

from __future__ import annotations

import heapq

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.search.nodes import Nodes, Rows

_BATCH = 64
_SHARES = (0.6, 0.15, 0.25)  # of a batch, for the three queues


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
