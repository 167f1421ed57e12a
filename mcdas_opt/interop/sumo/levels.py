"""Lanes that pass over or under the route: they cross it where there is no junction. Few networks say how high a road is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.interop.sumo.connection import Connection
from mcdas_opt.interop.sumo.route import Edge, lanes_inside

_CROSSES = 0.25  # the sine of the angle, at least, at which lanes cross and do not merge
_JOINED_M = 40.0  # from a junction that both come to: nearer, lanes may overlap on one level


class _Piece(NamedTuple):
    """A lane of the route, or one inside a junction; `ends` are its junctions, and where they are."""

    edge: str
    shape: Array
    ends: tuple[tuple[str, Array], tuple[str, Array]]


class Levels:
    """Which lanes are on another level than a route where they meet it: worked out lane by lane, as somebody is seen there."""

    def __init__(self, sumo: Connection, edges: Sequence[Edge]) -> None:
        self._sumo = sumo
        self._pieces = [self._piece(lane) for edge in edges for one in edge.lanes for lane in (one.id, *lanes_inside(sumo.lane, one.via))]
        self._junctions = {name for piece in self._pieces for name, _ in piece.ends}
        self._known: dict[str, bool] = {}

    def on_another(self, lane: str) -> bool:
        """Whether a lane crosses the route where there is no junction, or leads to one that does and not to the route."""
        known = self._known.get(lane)
        if known is None:
            known = self._known[lane] = self._crosses(lane) or any(map(self._crosses, self._ahead(lane)))
        return known

    def _ahead(self, lane: str) -> Iterator[str]:
        """The lanes that it leads to."""
        if self._sumo.edge.getToJunction(_edge_of(lane)) not in self._junctions:
            for link in self._sumo.lane.getLinks(lane):
                yield str(link[0])

    def _crosses(self, lane: str) -> bool:
        other = self._piece(lane)
        return any(self._is_over(other, piece) for piece in self._pieces if piece.edge != other.edge)

    @staticmethod
    def _is_over(other: _Piece, piece: _Piece) -> bool:
        names = {name for name, _ in other.ends}
        joints = [place for name, place in piece.ends if name in names]
        places = _crossings(other.shape, piece.shape)
        return any(all(np.hypot(*(place - joint)) > _JOINED_M for joint in joints) for place in places)

    def _piece(self, lane: str) -> _Piece:
        edge = _edge_of(lane)
        shape = np.asarray(self._sumo.lane.getShape(lane), dtype=np.float64)[:, :2]
        first, last = self._sumo.edge.getFromJunction(edge), self._sumo.edge.getToJunction(edge)
        return _Piece(edge, shape, ((first, shape[0]), (last, shape[-1])))


def _edge_of(lane: str) -> str:
    return lane.rpartition("_")[0]


def _crossings(shape: Array, other: Array) -> Array:
    """Where a polyline crosses another (n, 2), but for where both lead the same way."""
    if np.any(shape.max(axis=0) < other.min(axis=0)) or np.any(other.max(axis=0) < shape.min(axis=0)):
        return np.empty((0, 2))
    a, b = np.diff(shape, axis=0)[:, None], np.diff(other, axis=0)[None]
    between = other[None, :-1] - shape[:-1, None]
    area = _cross(a, b)
    steep = np.abs(area) > _CROSSES * np.hypot(a[..., 0], a[..., 1]) * np.hypot(b[..., 0], b[..., 1])
    own, theirs = (_cross(between, c) / np.where(steep, area, 1.0) for c in (b, a))
    met = steep & (own >= 0.0) & (own <= 1.0) & (theirs >= 0.0) & (theirs <= 1.0)
    i, _ = np.nonzero(met)
    return np.asarray(shape[i] + own[met][:, None] * a[i, 0])


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
