"""Which lanelets the ego's lane runs through, and how many lanes of its direction lie beside it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import InputError
from mcdas_opt.interop.commonroad.lane_line import AHEAD_M, BEHIND_M

_SIDEWAYS_RAD = 0.5 * np.pi  # an ego that points further off its lane is not driving along it


@dataclass(frozen=True, slots=True, kw_only=True)
class EgoLane:
    """`polyline` (n, 2) is the middle of the lane, from behind the ego to ahead of it."""

    polyline: Array
    width_m: float
    lanes_left: int
    lanes_right: int
    lanelets: tuple[int, ...]
    ends: bool  # nothing follows its last lanelet


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
    own = network.find_lanelet_by_id(aligned[0][1])
    chain = [*_behind(network, own), own, *_ahead(network, own, _goal_lanelets(network, problem))]
    pieces = [np.asarray(lanelet.center_vertices, dtype=np.float64) for lanelet in chain]
    sides = np.hypot(*(np.asarray(own.left_vertices) - np.asarray(own.right_vertices)).T)
    nearest = int(np.argmin(np.hypot(*(np.asarray(own.center_vertices) - position).T)))
    return EgoLane(
        polyline=np.concatenate(pieces),
        width_m=float(sides[nearest]),
        lanes_left=_beside(network, own, Side.LEFT),
        lanes_right=_beside(network, own, Side.RIGHT),
        lanelets=tuple(int(lanelet.lanelet_id) for lanelet in chain),
        ends=not chain[-1].successor,
    )


def _length(lanelet: Any) -> float:
    return float(lanelet.distance[-1])


def _direction(lanelet: Any, position: Array) -> float:
    points = np.asarray(lanelet.center_vertices)
    k = min(int(np.argmin(np.hypot(*(points - position).T))), len(points) - 2)
    way = points[k + 1] - points[k]
    return float(np.arctan2(way[1], way[0]))


def _turn(a: float, b: float) -> float:
    return float(np.arctan2(np.sin(a - b), np.cos(a - b)))


def _goal_lanelets(network: Any, problem: Any) -> set[int]:
    from commonroad.geometry.shape import Circle, Polygon, Rectangle

    named = problem.goal.lanelets_of_goal_position
    if named:
        return {identifier for group in named.values() for identifier in group}
    goals: set[int] = set()
    for state in problem.goal.state_list:
        if state.has_value("position") and isinstance(state.position, Rectangle | Circle | Polygon):
            goals |= set(network.find_lanelet_by_position([np.asarray(state.position.center)])[0])
    return goals


def _ahead(network: Any, own: Any, goals: set[int]) -> list[Any]:
    """Along the shortest way to a goal's lanelet where there is one, else always straightest on."""
    route = _route(network, own, goals)
    found: list[Any] = []
    last, far = own, 0.0
    seen = {own.lanelet_id}
    while last.successor and far < AHEAD_M:
        options = [identifier for identifier in last.successor if identifier not in seen]
        if not options:
            break
        wanted = [identifier for identifier in options if identifier in route] or options
        last = min((network.find_lanelet_by_id(identifier) for identifier in wanted), key=_bend)
        seen.add(last.lanelet_id)
        found.append(last)
        far += _length(last)
    return found


def _route(network: Any, own: Any, goals: set[int]) -> set[int]:
    before: dict[int, int | None] = {own.lanelet_id: None}
    queue = deque([own.lanelet_id])
    while queue:
        here = queue.popleft()
        if here in goals:
            route, step = set(), here
            while step is not None:
                route.add(step)
                step = before[step]
            return route
        for following in network.find_lanelet_by_id(here).successor:
            if following not in before:
                before[following] = here
                queue.append(following)
    return set()


def _bend(lanelet: Any) -> tuple[float, int]:
    points = np.asarray(lanelet.center_vertices)
    first, last = points[1] - points[0], points[-1] - points[-2]
    return abs(_turn(float(np.arctan2(first[1], first[0])), float(np.arctan2(last[1], last[0])))), int(lanelet.lanelet_id)


def _behind(network: Any, own: Any) -> list[Any]:
    found: list[Any] = []
    first, far, seen = own, 0.0, {own.lanelet_id}
    while first.predecessor and far < BEHIND_M:
        options = [network.find_lanelet_by_id(identifier) for identifier in first.predecessor if identifier not in seen]
        if not options:
            break
        first = min(options, key=_bend)
        seen.add(first.lanelet_id)
        found.insert(0, first)
        far += _length(first)
    return found


def _beside(network: Any, own: Any, side: Side) -> int:
    """Lanes of the same direction to that side, one beside the other."""
    lanelet, seen = own, {own.lanelet_id}
    while True:
        left, right = (lanelet.adj_left, lanelet.adj_left_same_direction), (lanelet.adj_right, lanelet.adj_right_same_direction)
        identifier, same_direction = left if side is Side.LEFT else right
        lanelet = network.find_lanelet_by_id(identifier) if identifier is not None and same_direction else None
        if lanelet is None or lanelet.lanelet_id in seen:
            return len(seen) - 1
        seen.add(lanelet.lanelet_id)
