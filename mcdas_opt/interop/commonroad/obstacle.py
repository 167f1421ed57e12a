"""A CommonRoad obstacle as somebody in the frame of the ego's road: how large it is, and where its middle is at each moment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.commonroad.lane_line import Placement

_REACH_D_M, _MARGIN_S_M = 60.0, 20.0  # a neighbour further off the road than this is none
_KINDS = {
    "car": BodyKind.CAR,
    "taxi": BodyKind.CAR,
    "parkedVehicle": BodyKind.CAR,
    "truck": BodyKind.LORRY,
    "bus": BodyKind.LORRY,
    "motorcycle": BodyKind.MOTORCYCLE,
    "bicycle": BodyKind.BICYCLE,
    "pedestrian": BodyKind.PEDESTRIAN,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """`samples` (n, 5): t, s, d, heading, speed of the body's middle. Who `leaves` is gone after the last; else it goes on from there."""

    samples: Array
    length_m: float
    width_m: float
    kind: BodyKind | None
    leaves: bool


def recorded(obstacle: Any, step_s: float, first_step: int, duration_s: float, placement: Placement, frame: FrenetFrame) -> Recorded | str:
    """The obstacle from `first_step` on, or why it is nobody here.

    It leaves where its states end, as CommonRoad has it; a dynamic one without a trajectory goes on at its first speed.
    """
    from commonroad.prediction.prediction import SetBasedPrediction

    states, moves = [obstacle.initial_state], obstacle.obstacle_role.name == "DYNAMIC"
    if moves and isinstance(obstacle.prediction, SetBasedPrediction):
        return "its future is a set of occupancies, no trajectory"
    if moves and obstacle.prediction is not None:
        states += [state for state in obstacle.prediction.trajectory.state_list if state.time_step > states[0].time_step]
    t: Array = np.array([step_s * (state.time_step - first_step) for state in states], dtype=np.float64)
    length, width, xy, yaw = _bodies(obstacle.obstacle_shape, states, moves=moves)
    if len(states) > 1:
        pace = np.hypot(*np.gradient(xy, t, axis=0).T)
        speed = np.array([_speed(state) or pace[k] for k, state in enumerate(states)])
    elif moves:
        begun_s, speed, yaw = float(t[0]), np.full(2, _speed(states[0])), np.repeat(yaw, 2)
        t = np.array([0.0, step_s]) + max(begun_s, 0.0)
        xy = xy + ((t - begun_s) * speed)[:, None] * np.column_stack([np.cos(yaw), np.sin(yaw)])
    else:
        t, xy, yaw, speed = np.array([0.0, duration_s]), np.repeat(xy, 2, axis=0), np.repeat(yaw, 2), np.zeros(2)
    x, y, heading = placement.to_frame(xy[:, 0], xy[:, 1], yaw)
    s, d, psi = frame.to_road(x, y, heading)
    if np.abs(d).max() > _REACH_D_M or s.min() < frame.s_min_m + _MARGIN_S_M or s.max() > frame.s_max_m - _MARGIN_S_M:
        return "is never near the ego's road"
    return Recorded(
        samples=np.column_stack([t, s, d, np.unwrap(psi), speed]),
        length_m=length,
        width_m=width,
        kind=_KINDS.get(obstacle.obstacle_type.value),
        leaves=len(states) > 1 and bool(t[-1] < duration_s),
    )


def _speed(state: Any) -> float:
    return _middle(state.velocity) if state.has_value("velocity") else 0.0


def _middle(value: Any) -> float:
    """Of an interval; an exact value is its own."""
    from commonroad.common.util import Interval

    return 0.5 * (float(value.start) + float(value.end)) if isinstance(value, Interval) else float(value)


def _bodies(shape: Any, states: Sequence[Any], *, moves: bool) -> tuple[float, float, Array, Array]:
    """(length, width, middles (n, 2), yaw (n,)) of the box about what CommonRoad has occupied in each state, along its orientation.

    A rectangle that is turned against its obstacle's orientation, and stands, is that rectangle. Where a place is uncertain, all that
    CommonRoad has occupied counts.
    """
    from commonroad.geometry.shape import Rectangle, occupancy_shape_from_state

    yaw = np.array([_middle(state.orientation) for state in states])
    sure = not any(state.is_uncertain_position or state.is_uncertain_orientation for state in states)
    if isinstance(shape, Rectangle) and sure and (shape.orientation == 0.0 or not moves):
        xy = np.array([np.asarray(state.position, dtype=np.float64) for state in states])
        return float(shape.length), float(shape.width), xy + shape.center, yaw + shape.orientation
    boxes = [_box(occupancy_shape_from_state(shape, state), turn) for state, turn in zip(states, yaw.tolist(), strict=True)]
    length, width = np.max([size for size, _ in boxes], axis=0).tolist()
    return length, width, np.array([middle for _, middle in boxes]), yaw


def _box(shape: Any, yaw_rad: float) -> tuple[Array, Array]:
    """(length and width, middle) of the box about a shape in the plane, turned so."""
    from commonroad.geometry.shape import ShapeGroup

    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    turned = np.array([[c, s], [-s, c]])
    low, high = zip(*(_reach(one, turned) for one in (shape.shapes if isinstance(shape, ShapeGroup) else [shape])), strict=True)
    least, most = np.min(low, axis=0), np.max(high, axis=0)
    return most - least, 0.5 * (least + most) @ turned


def _reach(shape: Any, turned: Array) -> tuple[Array, Array]:
    """The least and the greatest of a circle's, a rectangle's or a polygon's coordinates along turned axes."""
    from commonroad.geometry.shape import Circle

    if isinstance(shape, Circle):
        middle = turned @ np.asarray(shape.center)
        return middle - shape.radius, middle + shape.radius
    corners = np.asarray(shape.vertices) @ turned.T
    return corners.min(axis=0), corners.max(axis=0)
