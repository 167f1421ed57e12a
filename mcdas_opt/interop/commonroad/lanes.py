"""Which lanelets the ego's lane runs through, and which lie beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import InputError
from mcdas_opt.interop.commonroad.lane_line import AHEAD_M, BEHIND_M
from mcdas_opt.interop.commonroad.lane_middle import lane_middle
from mcdas_opt.interop.commonroad.rows import Row, route, row_of, rows_ahead, rows_behind

_ALONG_RAD = 0.5  # of several lanelets that the ego points along so well the one that leads to the goal is its
_NEAR_M = 0.5  # an ego that stands on no lanelet is on one that is so near
_CHANGING_S = 6.0  # a lane change takes, with its announcement
_SIDEWAYS_RAD = 0.5 * np.pi  # an ego that points further off its lane is not driving along it


@dataclass(frozen=True, slots=True, kw_only=True)
class EgoLane:
    """`polyline` (n, 2) is the middle of the lane, from behind the ego to ahead of it.

    `stations`: where each row begins and ends along that middle, counted from the ego [m]: where a road passes itself, as through a
    roundabout, nothing else says which of its passes a lanelet belongs to.
    """

    polyline: Array
    width_m: float
    rows: tuple[Row, ...]
    stations: tuple[tuple[float, float], ...]
    ends: bool  # nothing follows its last lanelets

    def station_of(self, lanelet: int) -> tuple[float, float] | None:
        """Where its first row ahead of the ego lies, or else its last behind; None if the road does not lead past it."""
        found = [station for row, station in zip(self.rows, self.stations, strict=True) if lanelet in row.lanelets.values()]
        return next((station for station in found if station[1] > 0.0), found[-1] if found else None)

    @property
    def lanelets(self) -> tuple[int, ...]:
        """Those that the road's line follows."""
        return tuple(row.lanelets[row.leads] for row in self.rows)


def ego_lane(scenario: Any, problem: Any, path: Path) -> EgoLane:
    """The lane under the planning problem's first position. Raises `InputError` where there is none."""
    from commonroad.geometry.shape import Circle

    network, first = scenario.lanelet_network, problem.initial_state
    position = np.asarray(first.position, dtype=np.float64)
    if not network.lanelets:
        raise InputError(path, "lanelet", None, "the scenario has no lane")
    under = network.find_lanelet_by_position([position])[0] or network.find_lanelet_by_shape(Circle(_NEAR_M, position))
    lanelets = [network.find_lanelet_by_id(identifier) for identifier in under]
    aligned = sorted((abs(_turn(_direction(lanelet, position), float(first.orientation))), lanelet.lanelet_id) for lanelet in lanelets)
    if not aligned or aligned[0][0] >= _SIDEWAYS_RAD:
        where = f"({position[0]:.2f}, {position[1]:.2f})"
        rule = "no lane lies under the ego's first position" if not aligned else "no lane there runs the ego's way"
        raise InputError(path, f"planningProblem {problem.planning_problem_id}: initialState", where, rule)
    goals = goal_lanelets(network, problem)
    along = [identifier for angle, identifier in aligned if angle < max(aligned[0][0], _ALONG_RAD)]
    under_ego = network.find_lanelet_by_id(next((identifier for identifier in along if route(network, identifier, goals)), aligned[0][1]))
    own, ahead = _leading_on(network, under_ego, goals, position, float(first.velocity))
    behind = rows_behind(network, own, BEHIND_M)
    rows = (*behind, *ahead)
    middle, widths = lane_middle(own)
    nearest = int(np.argmin(np.hypot(*(middle - position).T)))
    last = [network.find_lanelet_by_id(identifier) for identifier in rows[-1].lanelets.values()]
    return EgoLane(
        polyline=_line(network, rows),
        width_m=float(widths[nearest]),
        rows=rows,
        stations=_stations(network, rows, own.lanelet_id, len(behind), position),
        ends=not any(lanelet.successor for lanelet in last),
    )


def _leading_on(network: Any, own: Any, goals: set[int], position: Array, speed_mps: float) -> tuple[Any, list[Row]]:
    """The lanelet that the road's line follows, and the rows from there on: the ego's own, or where it leads away from the goal, as a lane
    for turning or an exit does, the nearest beside it that leads there, if the lane changes that this takes fit in before."""
    beside_own = row_of(network, own, 0).lanelets
    for number in sorted(beside_own, key=lambda k: (abs(k), k)):
        lanelet = network.find_lanelet_by_id(beside_own[number])
        rows = rows_ahead(network, lanelet, goals, AHEAD_M)
        if not any(goals.intersection(row.lanelets.values()) for row in rows):
            continue
        left_m = _length_beside_m(network, rows, -number) - _way_on_m(own, position)
        if number == 0 or left_m >= abs(number) * _CHANGING_S * speed_mps:
            return lanelet, rows
    return own, rows_ahead(network, own, goals, AHEAD_M)


def _length_beside_m(network: Any, rows: Sequence[Row], number: int) -> float:
    """How long the lane of that number goes on from the first row on."""
    together = takewhile(lambda row: number in row.lanelets, rows)
    return sum(_length_m(network.find_lanelet_by_id(row.lanelets[number])) for row in together)


def _way_on_m(lanelet: Any, position: Array) -> float:
    """How far along a lanelet's middle that position is."""
    middle, _ = lane_middle(lanelet)
    to_ego = middle[: int(np.argmin(np.hypot(*(middle - position).T))) + 1]
    return float(np.hypot(*np.diff(to_ego, axis=0).T).sum())


def _stations(network: Any, rows: Sequence[Row], own: int, own_row: int, position: Array) -> tuple[tuple[float, float], ...]:
    lengths = [_length_m(network.find_lanelet_by_id(row.lanelets[row.leads])) for row in rows]
    begins = np.cumsum([0.0, *lengths]) - sum(lengths[:own_row]) - _way_on_m(network.find_lanelet_by_id(own), position)
    return tuple(pairwise(begins.tolist()))


def _length_m(lanelet: Any) -> float:
    return float(np.hypot(*np.diff(lane_middle(lanelet)[0], axis=0).T).sum())


def _line(network: Any, rows: Sequence[Row]) -> Array:
    """The middle of lane 0, row by row; where that ended, a line as far beside the lane that leads on as it was then."""
    pieces: list[Array] = []
    offset = 0.0
    for before, row in zip((None, *rows), rows, strict=False):
        points = lane_middle(network.find_lanelet_by_id(row.lanelets[row.leads]))[0]
        if before is not None and row.leads != before.leads:
            leading = lane_middle(network.find_lanelet_by_id(before.lanelets[row.leads]))[0]
            along = leading[-1] - leading[-2]
            normal = np.array([-along[1], along[0]]) / np.hypot(*along)
            offset = float((pieces[-1][-1] - leading[-1]) @ normal)
        if offset:
            way = np.gradient(points, axis=0)
            normals = np.column_stack([-way[:, 1], way[:, 0]]) / np.maximum(np.hypot(*way.T), 1e-9)[:, None]
            points = points + offset * normals
        pieces.append(points)
    return np.concatenate(pieces)


def _direction(lanelet: Any, position: Array) -> float:
    points, _ = lane_middle(lanelet)
    k = min(int(np.argmin(np.hypot(*(points - position).T))), len(points) - 2)
    way = points[k + 1] - points[k]
    return float(np.arctan2(way[1], way[0]))


def _turn(a: float, b: float) -> float:
    return float(np.arctan2(np.sin(a - b), np.cos(a - b)))


def goal_lanelets(network: Any, problem: Any) -> set[int]:
    from commonroad.geometry.shape import Circle, Polygon, Rectangle

    named = problem.goal.lanelets_of_goal_position
    if named:
        return {identifier for group in named.values() for identifier in group}
    goals: set[int] = set()
    for state in problem.goal.state_list:
        if state.has_value("position") and isinstance(state.position, Rectangle | Circle | Polygon):
            goals |= set(network.find_lanelet_by_position([np.asarray(state.position.center)])[0])
    return goals
