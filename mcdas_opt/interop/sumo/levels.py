"""Who passes over or under the route: on lanes that cross it where there is no junction. Few networks say how high a road is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.interop.sumo.connection import Connection
from mcdas_opt.interop.sumo.polylines import stations_m
from mcdas_opt.interop.sumo.road_frame import Section
from mcdas_opt.interop.sumo.route import Edge, lanes_inside

_CROSSES = 0.25  # the sine of the angle, at least, at which lanes cross and do not merge
_NEAR_M = 40.0  # of a junction with the route a lane lies on its level
_PASSED_M = 20.0  # behind a crossing of lanes it is of no matter any more


class _Crossing(NamedTuple):
    along_m: float  # of the lane that crosses
    edge: int  # of the route's edges the one that is crossed, or whose junction behind it
    share: float  # of that edge


class _Lane(NamedTuple):
    """`leaves` and `joins`: its edge begins at a junction of the route, ends at one. `ahead`: where it leads, if neither."""

    shape: Array
    leaves: bool
    joins: bool
    crossings: tuple[_Crossing, ...]
    ahead: tuple[str, ...]


class Levels:
    """Who is on another level than a route: worked out lane by lane, as somebody is seen there."""

    def __init__(self, sumo: Connection, edges: Sequence[Edge]) -> None:
        self._sumo = sumo
        lanes = [(k, lane, own) for k, edge in enumerate(edges) for one in edge.lanes for lane, own in self._with_inside(one.id, one.via)]
        self._crossed = [(k, self._shape(lane), own) for k, lane, own in lanes]
        self._junctions = {name for _, lane, _ in lanes for name in self._ends(lane)}
        self._known: dict[str, _Lane] = {}

    def on_another(self, lane: str, place: Array, host_s_m: float, sections: Sequence[Section]) -> bool:
        """Whether somebody on a lane, at that place (2,), is. Of lanes that leave the route or come to it, as a ramp does that crosses it,
        only where they are far from it along the lane: where they lead away, or before a crossing that the host has not passed either."""
        known = self._lane(lane)
        if not (known.leaves or known.joins):
            return bool(known.crossings) or any(self._before(self._lane(ahead), -np.inf, host_s_m, sections) for ahead in known.ahead)
        if not known.crossings:
            return False
        at_m, length_m = _along(known.shape, place)
        if (known.leaves and at_m < _NEAR_M) or (known.joins and at_m > length_m - _NEAR_M):
            return False
        return not known.joins or self._before(known, at_m, host_s_m, sections)

    def _before(self, lane: _Lane, at_m: float, host_s_m: float, sections: Sequence[Section]) -> bool:
        """Whether a crossing lies ahead of a place on a lane, and of the host."""
        for crossing in lane.crossings:
            section = sections[crossing.edge]
            there_m = section.begin_m + crossing.share * (section.end_m - section.begin_m)
            if at_m < crossing.along_m + _PASSED_M and (host_s_m < there_m + _PASSED_M or not lane.joins):
                return True
        return False

    def _lane(self, lane: str) -> _Lane:
        known = self._known.get(lane)
        if known is None:
            known = self._known[lane] = self._read(lane)
        return known

    def _read(self, lane: str) -> _Lane:
        shape, (first, last) = self._shape(lane), self._ends(lane)
        leaves, joins = first in self._junctions, last in self._junctions
        found: list[_Crossing] = []
        if not (first == last and leaves):  # a lane inside a junction of the route
            length_m = stations_m(shape)[-1]
            for k, crossed, own in self._crossed:
                for at_m, share in _crossings(shape, crossed):
                    if not (leaves and at_m < _NEAR_M) and not (joins and at_m > length_m - _NEAR_M):
                        found.append(_Crossing(at_m, k, share if own else 1.0))
        ahead = () if leaves or joins else tuple(str(link[0]) for link in self._sumo.lane.getLinks(lane))
        return _Lane(shape, leaves, joins, tuple(found), ahead)

    def _with_inside(self, lane: str, via: str) -> list[tuple[str, bool]]:
        return [(lane, True), *((inside, False) for inside in lanes_inside(self._sumo.lane, via))]

    def _ends(self, lane: str) -> tuple[str, str]:
        """The junctions at both ends of its edge; of a lane inside a junction that one, twice."""
        edge = lane.rpartition("_")[0]
        return self._sumo.edge.getFromJunction(edge), self._sumo.edge.getToJunction(edge)

    def _shape(self, lane: str) -> Array:
        return np.asarray(self._sumo.lane.getShape(lane), dtype=np.float64)[:, :2]


def _crossings(shape: Array, other: Array) -> list[tuple[float, float]]:
    """Where a polyline crosses another, but for where both lead the same way: (along the first [m], share of the other)."""
    if np.any(shape.max(axis=0) < other.min(axis=0)) or np.any(other.max(axis=0) < shape.min(axis=0)):
        return []
    a, b = np.diff(shape, axis=0)[:, None], np.diff(other, axis=0)[None]
    between = other[None, :-1] - shape[:-1, None]
    area = _area(a, b)
    steep = np.abs(area) > _CROSSES * np.hypot(a[..., 0], a[..., 1]) * np.hypot(b[..., 0], b[..., 1])
    own, theirs = (_area(between, c) / np.where(steep, area, 1.0) for c in (b, a))
    there = steep & (own >= 0.0) & (own <= 1.0) & (theirs >= 0.0) & (theirs <= 1.0)
    ends, others_ends = stations_m(shape), stations_m(other)
    return [
        (
            float(ends[i] + own[i, j] * (ends[i + 1] - ends[i])),
            float((others_ends[j] + theirs[i, j] * (others_ends[j + 1] - others_ends[j])) / others_ends[-1]),
        )
        for i, j in zip(*np.nonzero(there), strict=True)
    ]


def _along(shape: Array, place: Array) -> tuple[float, float]:
    """How far along a polyline a place beside it is, and how long it is."""
    way, ends = np.diff(shape, axis=0), stations_m(shape)
    share = np.clip(((place - shape[:-1]) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-9), 0.0, 1.0)
    k = int(np.argmin(np.hypot(*(shape[:-1] + share[:, None] * way - place).T)))
    return float(ends[k] + share[k] * (ends[k + 1] - ends[k])), float(ends[-1])


def _area(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
