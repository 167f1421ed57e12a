"""Which lanelets the ego's lane runs through, and which lie beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import InputError
from mcdas_opt.interop.commonroad.lane_line import AHEAD_M, BEHIND_M
from mcdas_opt.interop.commonroad.rows import Row, route, rows_ahead, rows_behind

_ALONG_RAD = 0.5  # of several lanelets that the ego points along so well the one that leads to the goal is its
_SIDEWAYS_RAD = 0.5 * np.pi  # an ego that points further off its lane is not driving along it


@dataclass(frozen=True, slots=True, kw_only=True)
class EgoLane:
    """`polyline` (n, 2) is the middle of the lane, from behind the ego to ahead of it."""

    polyline: Array
    width_m: float
    rows: tuple[Row, ...]
    ends: bool  # nothing follows its last lanelets

    @property
    def lanelets(self) -> tuple[int, ...]:
        """Those that the road's line follows."""
        return tuple(row.lanelets[row.leads] for row in self.rows)


def ego_lane(scenario: Any, problem: Any, path: Path) -> EgoLane:
    """The lane under the planning problem's first position. Raises `InputError` where there is none."""
    network, first = scenario.lanelet_network, problem.initial_state
    position = np.asarray(first.position, dtype=np.float64)
    if not network.lanelets:
        raise InputError(path, "lanelet", None, "the scenario has no lane")
    under = network.find_lanelet_by_position([position])[0]
    lanelets = [network.find_lanelet_by_id(identifier) for identifier in under]
    aligned = sorted((abs(_turn(_direction(lanelet, position), float(first.orientation))), lanelet.lanelet_id) for lanelet in lanelets)
    if not aligned or aligned[0][0] >= _SIDEWAYS_RAD:
        where = f"({position[0]:.2f}, {position[1]:.2f})"
        rule = "no lane lies under the ego's first position" if not aligned else "no lane there runs the ego's way"
        raise InputError(path, f"planningProblem {problem.planning_problem_id}: initialState", where, rule)
    goals = goal_lanelets(network, problem)
    along = [identifier for angle, identifier in aligned if angle < max(aligned[0][0], _ALONG_RAD)]
    own = network.find_lanelet_by_id(next((identifier for identifier in along if route(network, identifier, goals)), aligned[0][1]))
    ahead = rows_ahead(network, own, goals, AHEAD_M)
    rows = (*rows_behind(network, own, BEHIND_M), *ahead)
    sides = np.hypot(*(np.asarray(own.left_vertices) - np.asarray(own.right_vertices)).T)
    nearest = int(np.argmin(np.hypot(*(np.asarray(own.center_vertices) - position).T)))
    last = [network.find_lanelet_by_id(identifier) for identifier in rows[-1].lanelets.values()]
    return EgoLane(
        polyline=_line(network, rows),
        width_m=float(sides[nearest]),
        rows=rows,
        ends=not any(lanelet.successor for lanelet in last),
    )


def _line(network: Any, rows: Sequence[Row]) -> Array:
    """The middle of lane 0, row by row; where that ended, a line as far beside the lane that leads on as it was then."""
    pieces: list[Array] = []
    offset = 0.0
    for before, row in zip((None, *rows), rows, strict=False):
        points = np.asarray(network.find_lanelet_by_id(row.lanelets[row.leads]).center_vertices, dtype=np.float64)
        if before is not None and row.leads != before.leads:
            leading = np.asarray(network.find_lanelet_by_id(before.lanelets[row.leads]).center_vertices, dtype=np.float64)
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
    points = np.asarray(lanelet.center_vertices)
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
