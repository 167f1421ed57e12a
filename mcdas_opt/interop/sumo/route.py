"""The lanes along a vehicle's route, told apart across edges by the column that they continue."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import InputError
from mcdas_opt.interop.sumo.connection import Connection, LaneDomain
from mcdas_opt.interop.sumo.links import Link, links_along, may_use

_GOES_ON = attrgetter("goes_on")
_EVERY_M, _NEAR_M = 4.0, 8.0
_BESIDE_M, _OPPOSED, _MOST = 0.4, 0.9, 0.7  # how a lane of oncoming traffic lies beside another, and for how much of its way


@dataclass(frozen=True, slots=True, kw_only=True)
class Lane:
    """A lane that the vehicle may use: `shape` (n, 2) is its middle; `goes_on` when it leads to the route's next edge, through `via`, and
    there `leads_over` so many columns to the left of where `via` comes to."""

    id: str
    column: int  # 0 is the one that the route was read from; counted to the left, the same along links
    shape: Array
    width_m: float
    limit_mps: float
    goes_on: bool
    via: str
    leads_over: int = 0


class OncomingLane(NamedTuple):
    """The column that it would have, and its width [m]."""

    column: int
    width_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Edge:
    """One edge of the route with its usable lanes, from right to left, nothing missing in between; `oncoming`, if there is one, is the lane
    of oncoming traffic beside the innermost."""

    id: str
    lanes: tuple[Lane, ...]
    oncoming: OncomingLane | None = None

    @property
    def columns(self) -> range:
        return range(self.lanes[0].column, self.lanes[-1].column + 1)

    def lane(self, column: int) -> Lane | None:
        return self.lanes[column - self.columns.start] if column in self.columns else None

    def nearest(self, column: int) -> Lane:
        """The lane of that column, else the one beside which it would lie."""
        return self.lanes[min(max(column, self.columns.start), self.columns.stop - 1) - self.columns.start]

    def leading_near(self, column: int) -> Lane:
        """The lane nearest to that column that goes on along the route; where none does, the nearest."""
        nearest = self.nearest(column)
        return nearest if nearest.goes_on else min(filter(_GOES_ON, self.lanes), key=lambda one: abs(one.column - column), default=nearest)


def keeps_left(sumo: Connection, route: Sequence[str], vehicle_class: str = "passenger") -> bool:
    """Whether the network's traffic keeps left. SUMO counts lanes from the side that traffic keeps to: lane 1 then lies to the right of
    lane 0. Where no edge of the route has two lanes, a lane of oncoming traffic tells; False where there is none either."""
    for name in route:
        if sumo.edge.getLaneNumber(name) > 1:
            outer, inner = (_shape(sumo.lane, f"{name}_{i}") for i in (0, 1))
            way, beside = outer[1] - outer[0], inner[0] - outer[0]
            return bool(way[0] * beside[1] < way[1] * beside[0])
    shapes = _shapes(sumo.lane, vehicle_class)
    widths_m = ((_shape(sumo.lane, f"{name}_0"), float(sumo.lane.getWidth(f"{name}_0"))) for name in route)
    sides = (next((side for side in (1, -1) if _width_beside_m(*one, side, sumo.lane, shapes)), 0) for one in widths_m)
    return next((side < 0 for side in sides if side), False)


def read_route(sumo: Connection, route: Sequence[str], lane_index: int, vehicle_class: str) -> tuple[Edge, ...]:
    """The route's edges from the first of `route` on; column 0 is its lane `lane_index`, as SUMO counts.

    Lanes beside the route's that others alone may use are left out. Raises `InputError` for a route that no lane goes along.
    """
    found: list[Edge] = []
    to_left = -1 if keeps_left(sumo, route, vehicle_class) else 1  # of the column, from one index to the next
    offset = -to_left * lane_index
    shapes = _shapes(sumo.lane, vehicle_class)
    for (k, name), links in zip(enumerate(route), links_along(sumo, route, vehicle_class), strict=True):
        last = k + 1 == len(route)
        shifts = Counter(i - link.to for i, ahead in links.items() for link in ahead)
        behind = shifts.most_common(1)[0][0] if shifts else 0
        taken = {i: min(ahead, key=lambda link: abs(i - link.to - behind), default=Link(i, "")) for i, ahead in links.items()}
        lanes = [
            Lane(
                id=f"{name}_{i}",
                column=to_left * i + offset,
                shape=_shape(sumo.lane, f"{name}_{i}"),
                width_m=float(sumo.lane.getWidth(f"{name}_{i}")),
                limit_mps=float(sumo.lane.getMaxSpeed(f"{name}_{i}")),
                goes_on=last or bool(ahead),
                via=taken[i].via,
                leads_over=to_left * taken[i].beside,
            )
            for i, ahead in sorted(links.items(), key=lambda one: to_left * one[0])
            if may_use(sumo.lane, f"{name}_{i}", vehicle_class)
        ]
        if not lanes:
            raise InputError("SUMO network", name, None, f"has no lane for a {vehicle_class}")
        usable = _together(lanes)
        found.append(Edge(id=name, lanes=usable, oncoming=_oncoming(usable, sumo.lane, shapes, to_left)))
        if last:
            break
        if not shifts:
            raise InputError("SUMO network", name, None, f"no lane leads from it to {route[k + 1]}")
        offset += to_left * behind
    return tuple(found)


def lanes_inside(lanes: LaneDomain, via: str) -> Iterator[str]:
    """The lanes inside a junction that one link leads through, one after the other: two, where those who turn wait in its middle."""
    while via.startswith(":"):
        yield via
        via = next((str(link[4]) for link in lanes.getLinks(via)), "")


def _shape(lanes: LaneDomain, lane: str) -> Array:
    """(n, 2)."""
    return np.asarray(lanes.getShape(lane), dtype=np.float64)[:, :2]


def _shapes(lanes: LaneDomain, vehicle_class: str) -> dict[str, Array]:
    """Of all lanes outside junctions that such vehicles may use."""
    names = (name for name in lanes.getIDList() if not name.startswith(":") and may_use(lanes, name, vehicle_class))
    return {name: _shape(lanes, name) for name in names}


def _oncoming(usable: Sequence[Lane], lanes: LaneDomain, shapes: Mapping[str, Array], to_left: int) -> OncomingLane | None:
    """The lane beside the innermost of these that leads back."""
    inner = usable[-1] if to_left > 0 else usable[0]
    width_m = _width_beside_m(inner.shape, inner.width_m, to_left, lanes, shapes)
    return OncomingLane(inner.column + to_left, width_m) if width_m else None


def _width_beside_m(shape: Array, width_m: float, side: int, lanes: LaneDomain, shapes: Mapping[str, Array]) -> float:
    """Of a lane that lies beside this one for most of its way, to the left (1) or the right (-1), and leads back; 0 without one."""
    for name, other in shapes.items():
        if _is_near(other, shape):
            their_m = float(lanes.getWidth(name))
            if _leads_back_beside(other, shape, side * 0.5 * (width_m + their_m)):
                return their_m
    return 0.0


def _is_near(shape: Array, other: Array) -> bool:
    """Whether the boxes around two polylines are."""
    return bool(np.all(shape.min(axis=0) < other.max(axis=0) + _NEAR_M) and np.all(shape.max(axis=0) > other.min(axis=0) - _NEAR_M))


def _leads_back_beside(shape: Array, other: Array, left_m: float) -> bool:
    """Whether a polyline lies so far to the left of most of another, in the opposite direction."""
    places, ways = _every(other)
    theirs, back = _every(shape)
    to_left = np.column_stack([-ways[:, 1], ways[:, 0]])
    off = places[:, None] + left_m * to_left[:, None] - theirs
    nearest = np.argmin(np.hypot(off[..., 0], off[..., 1]), axis=1)
    off = off[np.arange(len(places)), nearest]
    beside = (np.abs((off * to_left).sum(axis=1)) < _BESIDE_M) & (np.hypot(*off.T) < _EVERY_M)
    return bool(np.mean(beside & ((back[nearest] * ways).sum(axis=1) < -_OPPOSED)) > _MOST)


def _every(shape: Array) -> tuple[Array, Array]:
    """Places along a polyline, and the way that it leads there (m, 2)."""
    steps = np.diff(shape, axis=0)
    lengths = np.hypot(*steps.T)
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    at = np.linspace(0.0, ends[-1], max(math.ceil(ends[-1] / _EVERY_M), 1) + 1)
    k = np.clip(np.searchsorted(ends, at, side="right") - 1, 0, len(steps) - 1)
    ways = steps[k] / np.maximum(lengths[k], 1e-9)[:, None]
    return shape[k] + (at - ends[k])[:, None] * ways, ways


def _together(lanes: list[Lane]) -> tuple[Lane, ...]:
    """The longest run of lanes side by side."""
    runs: list[list[Lane]] = []
    for lane in lanes:
        if runs and lane.column == runs[-1][-1].column + 1:
            runs[-1].append(lane)
        else:
            runs.append([lane])
    return tuple(runs[int(np.argmax([len(run) for run in runs]))])
