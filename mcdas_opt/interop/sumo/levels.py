"""Lanes that pass over or under the route: they cross it where there is no junction. Few networks say how high a road is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.interop.sumo.connection import Connection
from mcdas_opt.interop.sumo.route import Edge, lanes_inside

_CROSSES = 0.25  # the sine of the angle, at least, at which lanes cross and do not merge


class Levels:
    """Which lanes are on another level than a route where they meet it: worked out lane by lane, as somebody is seen there. None of an edge
    that leaves the route or comes to it, as a ramp that crosses it does: whoever is there may be beside the vehicle."""

    def __init__(self, sumo: Connection, edges: Sequence[Edge]) -> None:
        self._sumo = sumo
        lanes = [lane for edge in edges for one in edge.lanes for lane in (one.id, *lanes_inside(sumo.lane, one.via))]
        self._shapes = [self._shape(lane) for lane in lanes]
        self._junctions = {name for lane in lanes for name in self._ends(lane)}
        self._known: dict[str, bool] = {}

    def on_another(self, lane: str) -> bool:
        """Whether a lane crosses the route where there is no junction, or leads to one that does."""
        known = self._known.get(lane)
        if known is None:
            known = self._known[lane] = self._crosses(lane) or (not self._joins(lane) and any(map(self._crosses, self._ahead(lane))))
        return known

    def _crosses(self, lane: str) -> bool:
        return not self._joins(lane) and any(_cross(self._shape(lane), shape) for shape in self._shapes)

    def _joins(self, lane: str) -> bool:
        return not self._junctions.isdisjoint(self._ends(lane))

    def _ahead(self, lane: str) -> Iterator[str]:
        return (str(link[0]) for link in self._sumo.lane.getLinks(lane))

    def _ends(self, lane: str) -> tuple[str, str]:
        """The junctions at both ends of its edge; of a lane inside a junction that one, twice."""
        edge = lane.rpartition("_")[0]
        return self._sumo.edge.getFromJunction(edge), self._sumo.edge.getToJunction(edge)

    def _shape(self, lane: str) -> Array:
        return np.asarray(self._sumo.lane.getShape(lane), dtype=np.float64)[:, :2]


def _cross(shape: Array, other: Array) -> bool:
    """Whether a polyline crosses another, but for where both lead the same way."""
    if np.any(shape.max(axis=0) < other.min(axis=0)) or np.any(other.max(axis=0) < shape.min(axis=0)):
        return False
    a, b = np.diff(shape, axis=0)[:, None], np.diff(other, axis=0)[None]
    between = other[None, :-1] - shape[:-1, None]
    area = _area(a, b)
    steep = np.abs(area) > _CROSSES * np.hypot(a[..., 0], a[..., 1]) * np.hypot(b[..., 0], b[..., 1])
    own, theirs = (_area(between, c) / np.where(steep, area, 1.0) for c in (b, a))
    return bool(np.any(steep & (own >= 0.0) & (own <= 1.0) & (theirs >= 0.0) & (theirs <= 1.0)))


def _area(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
