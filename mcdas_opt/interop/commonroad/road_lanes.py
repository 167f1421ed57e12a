"""The lanes of our road from the rows of lanelets: widths, limits, and what lies beside them that a car can drive on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mcdas_opt.domain.lane import Knots, Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.commonroad.lane_line import AHEAD_M, BEHIND_M, Placement
from mcdas_opt.interop.commonroad.rows import Row

_EVERY_M = 2.0
_SAME_M = 0.02  # a knot that linear interpolation misses by less is left out
_BESIDE_STEP_M, _BESIDE_MOST_M = 0.25, 5.0
_TIGHTEST = 0.8  # of a bend's radius: what lies further in is not looked at
_HELD_M, _FADED_M = 8.0, 40.0  # what a host's body needs beside its lane is road for so far, and less and less until then
_SPARE_M = 0.15
_LEAST_M = 0.1  # less beside the lanes is none


def with_lanes(road: Road, network: Any, rows: Sequence[Row], placement: Placement) -> Road:
    """The road with the lanes of the rows. Raises `ParameterError` where they cannot be such."""
    frame = FrenetFrame(road=road)
    spans = [_points(network.find_lanelet_by_id(row.lanelets[row.leads]), placement, frame)[0] for row in rows]
    low, high = max(-BEHIND_M, float(spans[0][0])), min(AHEAD_M, float(spans[-1][-1]))
    s = np.arange(np.ceil(low / _EVERY_M) * _EVERY_M, high, _EVERY_M)
    if s.size < 2:
        return road
    ends = np.maximum.accumulate([span[-1] for span in spans])
    row_at = np.minimum(np.searchsorted(ends, s, side="right"), len(rows) - 1)
    numbers = [number for row in rows for number in row.lanelets]
    right, left = min(numbers), max(numbers)
    lanes, reached = [], {1: np.zeros(s.size), -1: np.zeros(s.size)}  # how far the lanes reach to each side
    for number in sorted(range(right, left + 1), key=lambda k: (abs(k), k)):
        widths, limits = np.zeros(s.size), np.full(s.size, np.nan)
        for k, row in enumerate(rows):
            here = row_at == k
            if number in row.lanelets and here.any():
                lanelet = network.find_lanelet_by_id(row.lanelets[number])
                along, width = _points(lanelet, placement, frame)
                widths[here] = np.interp(s[here], along, width)
                limits[here] = _limit_mps(network, lanelet)
        for side in (1, -1) if number == 0 else (1 if number > 0 else -1,):
            inside = np.maximum(side * road.curvature_at(s), 1e-9)
            share = 0.5 if number == 0 else 1.0
            widths = np.minimum(widths, np.maximum(_TIGHTEST / inside - reached[side], 0.0) / share)
            reached[side] = reached[side] + share * widths
        merges = Side.NONE
        if number == 0 and widths[-1] == 0.0:
            merges = Side.LEFT if rows[-1].leads > 0 else Side.RIGHT
        lanes.append(Lane(lane=number, width_m=_knots(s, widths), speed_limit_mps=_steps(s, limits), merges=merges))
    lanes.sort(key=lambda lane: lane.lane)
    return replace(road, lanes_left=left, lanes_right=-right, lanes=tuple(lanes))


def with_surface(road: Road, network: Any, placement: Placement, host_d_m: float, host_reach_m: float) -> Road:
    """The road with what is beside its lanes: any lanelet's ground, as far as it is joined to them, and what the host's body stands on."""
    import shapely

    ground = shapely.union_all([_polygon(lanelet) for lanelet in network.lanelets]).buffer(0.01)
    shapely.prepare(ground)
    frame, s = FrenetFrame(road=road), np.arange(-BEHIND_M, AHEAD_M, _EVERY_M)
    kappa = road.curvature_at(s)
    far = max(road.left_edge_m, -road.right_edge_m) + _BESIDE_MOST_M
    out = np.arange(_BESIDE_STEP_M, far, _BESIDE_STEP_M)
    found: list[Lane] = []
    for sign, edge, number in ((1.0, road.left_edge_at(s), road.lanes_left + 1), (-1.0, road.right_edge_at(s), -road.lanes_right - 1)):
        lanes_m = sign * np.broadcast_to(edge, s.shape)
        d = sign * np.broadcast_to(out, (s.size, out.size))
        x, y, yaw = frame.to_plane(*np.broadcast_arrays(s[:, None], d, 0.0))
        px, py, _ = placement.to_plane(x, y, yaw)
        on = shapely.contains_xy(ground, px, py) & (kappa[:, None] * d < _TIGHTEST)
        ground_m = _without_peaks(_BESIDE_STEP_M * np.logical_and.accumulate(on, axis=1).sum(axis=1))
        wide = np.where(lanes_m < 0.0, 0.0, np.clip(ground_m - lanes_m, 0.0, _BESIDE_MOST_M))  # lanes on one side of the line alone
        needed = sign * host_d_m + host_reach_m + _SPARE_M - lanes_m[int(np.argmin(np.abs(s)))]
        wide = np.maximum(wide, needed * np.clip((_FADED_M - np.abs(s)) / (_FADED_M - _HELD_M), 0.0, 1.0))
        if wide.max() > _LEAST_M:
            found.append(Lane(lane=number, width_m=_knots(s, np.maximum(wide, 0.0)), shoulder=True))
    left, right = (any(lane.lane * sign > 0 for lane in found) for sign in (1, -1))
    lanes = tuple(sorted((*road.lanes, *found), key=lambda lane: lane.lane))
    return replace(road, lanes_left=road.lanes_left + left, lanes_right=road.lanes_right + right, lanes=lanes)


def _without_peaks(values: Array) -> Array:
    """A row without what rises for two samples at most."""
    windows = np.lib.stride_tricks.sliding_window_view
    least = windows(np.pad(values, 1, mode="edge"), 3).min(axis=1)
    return np.asarray(windows(np.pad(least, 1, mode="edge"), 3).max(axis=1))


def _points(lanelet: Any, placement: Placement, frame: FrenetFrame) -> tuple[Array, Array]:
    """s [m] of a lanelet's middle, increasing, and its width there [m]."""
    middle = np.asarray(lanelet.center_vertices, dtype=np.float64)
    width = np.hypot(*(np.asarray(lanelet.left_vertices) - np.asarray(lanelet.right_vertices)).T)
    x, y, yaw = placement.to_frame(middle[:, 0], middle[:, 1], np.zeros(len(middle)))
    s, _, _ = frame.to_road(x, y, yaw)
    kept = np.concatenate([[True], s[1:] > np.maximum.accumulate(s)[:-1] + 1e-6])
    return s[kept], width[kept]


def _polygon(lanelet: Any) -> Any:
    import shapely

    ring = np.concatenate([np.asarray(lanelet.left_vertices), np.asarray(lanelet.right_vertices)[::-1]])
    return shapely.Polygon(ring).buffer(0.0)


def _limit_mps(network: Any, lanelet: Any) -> float:
    """By the signs that a lanelet refers to; NaN without."""
    for identifier in lanelet.traffic_signs or ():
        sign = network.find_traffic_sign_by_id(identifier)
        for element in sign.traffic_sign_elements if sign is not None else ():
            if element.traffic_sign_element_id.name == "MAX_SPEED" and element.additional_values:
                return float(element.additional_values[0])
    return np.nan


def _knots(s: Array, values: Array) -> Knots:
    """As few as say the same to a hair (Ramer, 1972; Douglas and Peucker, 1973)."""
    kept = {0, s.size - 1}
    open_pieces = [(0, s.size - 1)]
    while open_pieces:
        first, last = open_pieces.pop()
        between = np.interp(s[first : last + 1], s[[first, last]], values[[first, last]])
        off = np.abs(values[first : last + 1] - between)
        worst = int(np.argmax(off))
        if off[worst] > _SAME_M:
            kept.add(first + worst)
            open_pieces += [(first, first + worst), (first + worst, last)]
    return tuple((float(s[k]), float(values[k])) for k in sorted(kept))


def _steps(s: Array, values: Array) -> Knots:
    """Where a value begins to hold; nothing where none is known."""
    known = [(float(at), float(value)) for at, value in zip(s, values, strict=True) if np.isfinite(value)]
    return tuple(one for k, one in enumerate(known) if k == 0 or one[1] != known[k - 1][1])
