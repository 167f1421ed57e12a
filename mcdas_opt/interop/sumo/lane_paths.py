"""Where the lanes of others lead: along the lane, through the junction, and on, as far as it is known which way somebody takes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.interop.sumo.connection import Connection
from mcdas_opt.interop.sumo.polylines import stations_m
from mcdas_opt.interop.sumo.route import lanes_inside

_RIGHT, _LEFT = 0x1, 0x2  # of SUMO's signals: the indicators
_TURNS = {_RIGHT: "rR", _LEFT: "lL"}  # SUMO's directions of links
_LEAST_M, _AHEAD_S = 20.0, 6.0  # how far is looked ahead
_BEHIND_M = 5.0
_SAME_M = 0.05  # of two places: one


class _Ahead(NamedTuple):
    via: str
    direction: str
    lane: str


class _Shape(NamedTuple):
    """The middle of a lane."""

    points: Array  # (n, 2) in SUMO's plane
    along_m: Array  # (n,) their stations
    every_m: Array  # (m,) stations a metre apart
    places: Array  # (m, 2) there

    @classmethod
    def of(cls, points: Array) -> _Shape:
        along = stations_m(points)
        every = np.arange(0.0, along[-1] + 0.5, 1.0)
        return cls(points, along, every, np.column_stack([np.interp(every, along, points[:, k]) for k in (0, 1)]))

    @property
    def length_m(self) -> float:
        return float(self.along_m[-1])

    def nearest_m(self, place: Array) -> float:
        """The station that is nearest to a place (2,), to half a metre."""
        return float(self.every_m[np.argmin(np.hypot(*(self.places - place).T))])


class LanePaths:
    """Of a network, lane by lane, each asked for once."""

    def __init__(self, sumo: Connection) -> None:
        self._sumo = sumo
        self._shapes: dict[str, _Shape] = {}
        self._links: dict[str, list[_Ahead]] = {}

    def of(self, vehicle: str, lane: str, place: Array, speed_mps: float) -> Array | None:
        """(n, 2) in SUMO's plane, of a vehicle at that place (2,) of a lane, from a little behind it on. Where several ways lead on, the
        one that its indicators show; where they do not tell, the path ends."""
        ahead_m = _LEAST_M + _AHEAD_S * speed_mps
        parts = [self._shape(lane)]
        at_m = parts[0].nearest_m(place)
        left_m = at_m + ahead_m - parts[0].length_m
        while left_m > 0.0 and (following := self._following(vehicle, lane)):
            for lane in following:
                parts.append(self._shape(lane))
                left_m -= parts[-1].length_m
        return _between(np.concatenate([part.points for part in parts]), at_m - _BEHIND_M, at_m + ahead_m)

    def _following(self, vehicle: str, lane: str) -> list[str]:
        """The lanes inside the junction, and behind it; none where it is not known."""
        links = self._ahead(lane)
        if len(links) > 1:
            signals = int(self._sumo.vehicle.getSignals(vehicle))
            shown = next((turns for flag, turns in _TURNS.items() if signals & flag), "s")
            links = [link for link in links if link.direction in shown]
        return [*lanes_inside(self._sumo.lane, links[0].via), links[0].lane] if len(links) == 1 else []

    def _shape(self, lane: str) -> _Shape:
        if lane not in self._shapes:
            self._shapes[lane] = _Shape.of(np.asarray(self._sumo.lane.getShape(lane), dtype=np.float64)[:, :2])
        return self._shapes[lane]

    def _ahead(self, lane: str) -> list[_Ahead]:
        if lane not in self._links:
            self._links[lane] = [_Ahead(str(link[4]), str(link[6]), str(link[0])) for link in self._sumo.lane.getLinks(lane)]
        return self._links[lane]


def _between(shape: Array, begin_m: float, end_m: float) -> Array | None:
    """Of a polyline what lies between two stations; None where that is nothing."""
    along = stations_m(shape)
    begin_m, end_m = max(begin_m, 0.0), min(end_m, float(along[-1]))
    at_m = np.array([begin_m, *along[(along > begin_m + _SAME_M) & (along < end_m - _SAME_M)], end_m])
    at_m = at_m[np.concatenate([[True], np.diff(at_m) > _SAME_M])]
    return np.column_stack([np.interp(at_m, along, shape[:, k]) for k in (0, 1)]) if at_m.size > 1 else None
