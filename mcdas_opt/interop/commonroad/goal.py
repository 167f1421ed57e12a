"""A planning problem's goal as our destination: its area along the ego's road, its lane, its time window, speed and heading."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.commonroad.lane_line import Placement
from mcdas_opt.interop.commonroad.lanes import EgoLane
from mcdas_opt.interop.commonroad.road_lanes import on_road

_BESIDE_M = 2.0  # an area whose middle is further off the road than this is not on it
_NEXT_M = 1.0  # areas of one lane that are no further apart are one
_KEPT_M = 0.3  # from its lane's middle that a car is
_LEVELS, _INSET = 17, 0.005  # offsets to either side at which an area is measured, and as a share of its width the nearest to its edge


def destination(
    problem: Any, network: Any, road: Road, lane: EgoLane, placement: Placement, host: HostState, step_s: float, vehicle: Vehicle
) -> tuple[Destination | None, str]:
    """The goal state that can be reached along the ego's road, in the lane nearest to the ego's, the longest of these; or None, and why
    there is none: empty where none is asked for."""
    named = problem.goal.lanelets_of_goal_position or {}
    reasons: list[str] = []
    found: list[Destination] = []
    for k, state in enumerate(problem.goal.state_list):
        asked = Destination(
            time_s=_window(state, problem.initial_state.time_step, step_s),
            speed_mps=(float(state.velocity.start), float(state.velocity.end)) if state.has_value("velocity") else None,
        )
        lanelets = [network.find_lanelet_by_id(identifier) for identifier in named.get(k, ())]
        areas = [(_outline(one), lane.station_of(int(one.lanelet_id))) for one in lanelets] or [(points, None) for points in _shapes(state)]
        if not areas:
            return asked, ""
        on_the_road = []
        for points, station_m in areas:
            there, why = _along(points, station_m, asked, state, road, placement, is_lane=bool(lanelets))
            if there is None:
                reasons.append(why)
            else:
                on_the_road.append(there)
        for there in _joined(on_the_road):
            why = there.why_unreachable(host, 0.0, road, vehicle)
            if why:
                reasons.append(why)
            else:
                found.append(there)
    own = road.lane_of(host.d_m, host.s_m)
    return min(found, key=lambda one: (abs((one.lane or 0) - own), -_length_m(one)), default=None), "" if found or not reasons else reasons[
        0
    ]


def _along(
    points: Array, station_m: tuple[float, float] | None, asked: Destination, state: Any, road: Road, placement: Placement, *, is_lane: bool
) -> tuple[Destination | None, str]:
    s, d = on_road(points, station_m, placement, FrenetFrame(road=road))
    middle_s, middle_d = 0.5 * float(s.min() + s.max()), 0.5 * float(d.min() + d.max())
    low, high = float(road.right_edge_at(middle_s)), float(road.left_edge_at(middle_s))
    if not low - _BESIDE_M <= middle_d <= high + _BESIDE_M:
        return None, f"the goal lies {max(low - middle_d, middle_d - high):.3g} m off the ego's road"
    inside = [k for k in range(-road.lanes_right, road.lanes_left + 1) if d.min() < road.lane_centre_m(k, middle_s) < d.max()]
    several = len([k for k in inside if road.has_lane(k, middle_s)]) > 1
    lane = None if several else road.lane_of(middle_d, middle_s)
    if is_lane:
        there = replace(asked, s_m=(float(s.min()), float(s.max())), lane=lane)
    else:
        along_m, across_m = _box_inside(s, d, float(road.lane_centre_m(road.lane_of(middle_d, middle_s), middle_s)))
        there = replace(asked, s_m=along_m, d_m=across_m, lane=lane)
    if state.has_value("orientation"):
        x, y, _ = FrenetFrame(road=road).to_plane(np.array([middle_s, middle_s + 1.0]), np.zeros(2), np.zeros(2))
        along = float(np.arctan2(np.diff(y)[0], np.diff(x)[0])) + placement.yaw_rad
        half = 0.5 * float(state.orientation.end - state.orientation.start)
        turned = 0.5 * float(state.orientation.start + state.orientation.end) - along
        turned = (turned + np.pi) % (2.0 * np.pi) - np.pi
        there = replace(there, heading_rad=(turned - half, turned + half))
    return there, ""


def _box_inside(s_m: Array, d_m: Array, through_d_m: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """From where to where, along and across the road, of a box within a convex area of these corners in turn: who is in it is in the area,
    however that lies across the road. Where the line at that offset crosses the area, with room beside the line to either side: as much of
    length and of both rooms as there is together, of rooms as they count."""
    low, high = float(d_m.min()), float(d_m.max())
    through = through_d_m if low < through_d_m < high else 0.5 * (low + high)
    inset = _INSET * (high - low)
    levels = np.concatenate([np.linspace(low + inset, through, _LEVELS), np.linspace(through, high - inset, _LEVELS)])
    begins, ends = np.array([_chord(s_m, d_m, level) for level in np.clip(levels, low + inset, high - inset)]).T
    right, left = slice(None, _LEVELS), slice(_LEVELS, None)
    begin, end = np.maximum.outer(begins[right], begins[left]), np.minimum.outer(ends[right], ends[left])
    size = np.maximum(end - begin, 0.0) * np.multiply.outer(_counted(through - levels[right]), _counted(levels[left] - through))
    i, j = np.unravel_index(int(np.argmax(size)), size.shape)
    return (float(begin[i, j]), float(end[i, j])), (float(levels[right][i]), float(levels[left][j]))


def _counted(room_m: Array) -> Array:
    """Room beside a line that a car keeps to within `_KEPT_M`: beyond that it hardly counts."""
    return np.minimum(room_m, _KEPT_M) + 0.01 * room_m


def _chord(s_m: Array, d_m: Array, level_m: float) -> tuple[float, float]:
    """From where to where the line at that offset lies within a convex area, which it crosses."""
    next_s, next_d = np.roll(s_m, -1), np.roll(d_m, -1)
    crossed = (np.minimum(d_m, next_d) <= level_m) & (level_m <= np.maximum(d_m, next_d)) & (d_m != next_d)
    found = (s_m + (level_m - d_m) / np.where(crossed, next_d - d_m, 1.0) * (next_s - s_m))[crossed]
    return float(found.min()), float(found.max())


def _joined(areas: list[Destination]) -> list[Destination]:
    """The same with those of one lane that follow one another as one."""
    joined: list[Destination] = []
    for area in sorted(areas, key=lambda one: (one.lane or 0, one.s_m or (0.0, 0.0))):
        last = joined[-1] if joined else None
        if (
            last is not None
            and last.lane == area.lane
            and last.s_m is not None
            and area.s_m is not None
            and area.s_m[0] <= last.s_m[1] + _NEXT_M
        ):
            joined[-1] = replace(last, s_m=(last.s_m[0], max(last.s_m[1], area.s_m[1])))
        else:
            joined.append(area)
    return joined


def _length_m(one: Destination) -> float:
    return 0.0 if one.s_m is None else one.s_m[1] - one.s_m[0]


def _window(state: Any, first_step: int, step_s: float) -> tuple[float, float]:
    """[s] from the beginning on, to the nanosecond, as drives count it: a window may be a single moment."""
    from commonroad.common.util import Interval

    given = state.time_step
    begin, end = (given.start, given.end) if isinstance(given, Interval) else (given, given)
    first, last = (max(round(step_s * (float(step) - first_step), 9), 0.0) for step in (begin, end))
    return first, last


def _outline(lanelet: Any) -> Array:
    return np.concatenate([np.asarray(lanelet.left_vertices), np.asarray(lanelet.right_vertices)[::-1]])


def _shapes(state: Any) -> list[Array]:
    """Outlines of what counts as there (n, 2) [m]."""
    from commonroad.geometry.shape import Circle, ShapeGroup

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
