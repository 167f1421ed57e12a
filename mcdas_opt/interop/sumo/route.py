"""The lanes along a vehicle's route, told apart across edges by the column that they continue."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import InputError
from mcdas_opt.interop.sumo.connection import Connection, LaneDomain


@dataclass(frozen=True, slots=True, kw_only=True)
class Lane:
    """A lane that the vehicle may use: `shape` (n, 2) is its middle; `goes_on` when it leads to the route's next edge, through `via`."""

    id: str
    column: int  # 0 is the one that the route was read from; counted to the left, the same along links
    shape: Array
    width_m: float
    limit_mps: float
    goes_on: bool
    via: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Edge:
    """One edge of the route with its usable lanes, from right to left, nothing missing in between."""

    id: str
    lanes: tuple[Lane, ...]

    @property
    def columns(self) -> range:
        return range(self.lanes[0].column, self.lanes[-1].column + 1)

    def lane(self, column: int) -> Lane | None:
        return self.lanes[column - self.columns.start] if column in self.columns else None

    def nearest(self, column: int) -> Lane:
        """The lane of that column, else the one beside which it would lie."""
        return self.lanes[min(max(column, self.columns.start), self.columns.stop - 1) - self.columns.start]


def keeps_left(sumo: Connection, route: Sequence[str]) -> bool:
    """Whether the network's traffic keeps left. SUMO counts lanes from the side that traffic keeps to: lane 1 then lies to the right of
    lane 0. False where no edge of the route has two lanes."""
    for name in route:
        if sumo.edge.getLaneNumber(name) > 1:
            outer, inner = (np.asarray(sumo.lane.getShape(f"{name}_{i}"), dtype=np.float64)[:, :2] for i in (0, 1))
            way, beside = outer[1] - outer[0], inner[0] - outer[0]
            return bool(way[0] * beside[1] < way[1] * beside[0])
    return False


def read_route(sumo: Connection, route: Sequence[str], lane_index: int, vehicle_class: str) -> tuple[Edge, ...]:
    """The route's edges from the first of `route` on; column 0 is its lane `lane_index`, as SUMO counts.

    Lanes beside the route's that others alone may use are left out. Raises `InputError` for a route that no lane goes along.
    """
    found: list[Edge] = []
    to_left = -1 if keeps_left(sumo, route) else 1  # of the column, from one index to the next
    offset = -to_left * lane_index
    for k, name in enumerate(route):
        last = k + 1 == len(route)
        links = {i: _links(sumo.lane, f"{name}_{i}", None if last else route[k + 1]) for i in range(sumo.edge.getLaneNumber(name))}
        lanes = [
            Lane(
                id=f"{name}_{i}",
                column=to_left * i + offset,
                shape=np.asarray(sumo.lane.getShape(f"{name}_{i}"), dtype=np.float64)[:, :2],
                width_m=float(sumo.lane.getWidth(f"{name}_{i}")),
                limit_mps=float(sumo.lane.getMaxSpeed(f"{name}_{i}")),
                goes_on=last or bool(ahead),
                via=ahead[0][1] if ahead else "",
            )
            for i, ahead in sorted(links.items(), key=lambda one: to_left * one[0])
            if _may_use(sumo.lane, f"{name}_{i}", vehicle_class)
        ]
        if not lanes:
            raise InputError("SUMO network", name, None, f"has no lane for a {vehicle_class}")
        found.append(Edge(id=name, lanes=_together(lanes)))
        if last:
            break
        shifts = Counter(to_left * (i - to) + offset for i, ahead in links.items() for to, _ in ahead)
        if not shifts:
            raise InputError("SUMO network", name, None, f"no lane leads from it to {route[k + 1]}")
        offset = shifts.most_common(1)[0][0]
    return tuple(found)


def _links(lanes: LaneDomain, lane: str, following: str | None) -> list[tuple[int, str]]:
    """(index of the lane on the following edge, lane inside the junction that leads there)."""
    if following is None:
        return []
    found = []
    for link in lanes.getLinks(lane):
        edge, _, index = str(link[0]).rpartition("_")
        if edge == following:
            found.append((int(index), str(link[4])))
    return found


def _may_use(lanes: LaneDomain, lane: str, vehicle_class: str) -> bool:
    allowed = lanes.getAllowed(lane)
    return (not allowed or vehicle_class in allowed) and vehicle_class not in lanes.getDisallowed(lane)


def _together(lanes: list[Lane]) -> tuple[Lane, ...]:
    """The longest run of lanes side by side."""
    runs: list[list[Lane]] = []
    for lane in lanes:
        if runs and lane.column == runs[-1][-1].column + 1:
            runs[-1].append(lane)
        else:
            runs.append([lane])
    return tuple(runs[int(np.argmax([len(run) for run in runs]))])
