"""A planning problem's goal as our destination: its area along the ego's road, its lane, its time window."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.commonroad.lane_line import Placement

_BESIDE_M = 2.0  # an area whose middle is further off the road than this is not on it


def destination(
    problem: Any, network: Any, road: Road, placement: Placement, host: HostState, step_s: float, speed_max_mps: float
) -> tuple[Destination | None, str]:
    """The first goal state that can be reached along the ego's road; or None, and why there is none: empty where none is asked for."""
    named = problem.goal.lanelets_of_goal_position or {}
    reasons: list[str] = []
    for k, state in enumerate(problem.goal.state_list):
        times = _window(state, problem.initial_state.time_step, step_s)
        areas = _areas(state, [network.find_lanelet_by_id(identifier) for identifier in named.get(k, ())])
        if not areas:
            if times is None:
                continue
            return Destination(time_s=times), ""
        for points in areas:
            found, why = _along(points, times, road, placement)
            why = why or (found.why_unreachable(host, 0.0, road, speed_max_mps) if found is not None else "")
            if found is not None and not why:
                return found, ""
            reasons.append(why)
    return None, reasons[0] if reasons else ""


def _along(points: Array, times: tuple[float, float] | None, road: Road, placement: Placement) -> tuple[Destination | None, str]:
    x, y, yaw = placement.to_frame(points[:, 0], points[:, 1], np.zeros(len(points)))
    s, d, _ = FrenetFrame(road=road).to_road(x, y, yaw)
    middle_s, middle_d = 0.5 * float(s.min() + s.max()), 0.5 * float(d.min() + d.max())
    low, high = float(road.right_edge_at(middle_s)), float(road.left_edge_at(middle_s))
    if not low - _BESIDE_M <= middle_d <= high + _BESIDE_M:
        return None, f"the goal lies {max(low - middle_d, middle_d - high):.3g} m off the ego's road"
    lane = road.lane_of(middle_d, middle_s)
    inside = [k for k in range(-road.lanes_right, road.lanes_left + 1) if d.min() < road.lane_centre_m(k, middle_s) < d.max()]
    several = len([k for k in inside if road.has_lane(k, middle_s)]) > 1
    return Destination(s_m=(float(s.min()), float(s.max())), lane=None if several else lane, time_s=times), ""


def _window(state: Any, first_step: int, step_s: float) -> tuple[float, float] | None:
    """[s] from the beginning on, to the nanosecond, as drives count it: a window may be a single moment."""
    from commonroad.common.util import Interval

    if state.time_step is None:
        return None
    given = state.time_step
    begin, end = (given.start, given.end) if isinstance(given, Interval) else (given, given)
    first, last = (max(round(step_s * (float(step) - first_step), 9), 0.0) for step in (begin, end))
    return first, last


def _areas(state: Any, lanelets: list[Any]) -> list[Array]:
    """Outlines of what counts as there (n, 2) [m]."""
    from commonroad.geometry.shape import Circle, ShapeGroup

    if lanelets:
        return [np.concatenate([np.asarray(one.left_vertices), np.asarray(one.right_vertices)[::-1]]) for one in lanelets]
    if not state.has_value("position"):
        return []
    shapes = state.position.shapes if isinstance(state.position, ShapeGroup) else [state.position]
    found = []
    for shape in shapes:
        if isinstance(shape, Circle):
            around = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
            found.append(np.asarray(shape.center) + shape.radius * np.column_stack([np.cos(around), np.sin(around)]))
        else:
            found.append(np.asarray(shape.vertices, dtype=np.float64))
    return found
