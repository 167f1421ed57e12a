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


class LanePaths:
    """Of a network, lane by lane, each asked for once."""

    def __init__(self, sumo: Connection) -> None:
        self._sumo = sumo
        self._shapes: dict[str, Array] = {}
        self._links: dict[str, list[_Ahead]] = {}

    def of(self, vehicle: str, lane: str, place: Array, speed_mps: float) -> Array | None:
        """(n, 2) in SUMO's plane, of a vehicle at that place (2,) of a lane, from a little behind it on. Where several ways lead on, the
        one that its indicators show; where they do not tell, the path ends."""
        ahead_m = _LEAST_M + _AHEAD_S * speed_mps
        parts, shape = [self._shape(lane)], self._shape(lane)
        at_m = _nearest_m(shape, place)
        left_m = at_m + ahead_m - float(stations_m(shape)[-1])
        while left_m > 0.0 and (following := self._following(vehicle, lane)):
            for lane in following:
                parts.append(self._shape(lane))
                left_m -= float(stations_m(parts[-1])[-1])
        return _between(np.concatenate(parts), at_m - _BEHIND_M, at_m + ahead_m)

    def _following(self, vehicle: str, lane: str) -> list[str]:
        """The lanes inside the junction, and behind it; none where it is not known."""
        links = self._ahead(lane)
        if len(links) > 1:
            signals = int(self._sumo.vehicle.getSignals(vehicle))
            shown = next((turns for flag, turns in _TURNS.items() if signals & flag), "s")
            links = [link for link in links if link.direction in shown]
        return [*lanes_inside(self._sumo.lane, links[0].via), links[0].lane] if len(links) == 1 else []

    def _shape(self, lane: str) -> Array:
        if lane not in self._shapes:
            self._shapes[lane] = np.asarray(self._sumo.lane.getShape(lane), dtype=np.float64)[:, :2]
        return self._shapes[lane]

    def _ahead(self, lane: str) -> list[_Ahead]:
        if lane not in self._links:
            self._links[lane] = [_Ahead(str(link[4]), str(link[6]), str(link[0])) for link in self._sumo.lane.getLinks(lane)]
        return self._links[lane]


def _nearest_m(shape: Array, place: Array) -> float:
    """The station of a polyline that is nearest to a place (2,), to half a metre."""
    along = stations_m(shape)
    at_m = np.arange(0.0, along[-1] + 0.5, 1.0)
    x, y = (np.interp(at_m, along, shape[:, k]) for k in (0, 1))
    return float(at_m[np.argmin(np.hypot(x - place[0], y - place[1]))])


def _between(shape: Array, begin_m: float, end_m: float) -> Array | None:
    """Of a polyline what lies between two stations; None where that is nothing."""
    along = stations_m(shape)
    begin_m, end_m = max(begin_m, 0.0), min(end_m, float(along[-1]))
    at_m = np.array([begin_m, *along[(along > begin_m + _SAME_M) & (along < end_m - _SAME_M)], end_m])
    at_m = at_m[np.concatenate([[True], np.diff(at_m) > _SAME_M])]
    return np.column_stack([np.interp(at_m, along, shape[:, k]) for k in (0, 1)]) if at_m.size > 1 else None
