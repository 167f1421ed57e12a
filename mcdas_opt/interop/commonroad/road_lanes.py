"""The lanes of our road from the rows of lanelets: widths, limits, and what lies beside them that a car can drive on."""

from __future__ import annotations

import re
from collections.abc import Container
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.lane import Knots, Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.commonroad.lane_line import AHEAD_M, BEHIND_M, Placement
from mcdas_opt.interop.commonroad.lane_middle import lane_middle
from mcdas_opt.interop.commonroad.lanes import EgoLane

_EVERY_M = 2.0
_ABRUPT = 1.8  # metres across per metre along that a lane beside another may begin or end with
_SAME_M = 0.02  # a knot that linear interpolation misses by less is left out
_BESIDE_STEP_M, _BESIDE_MOST_M = 0.25, 5.0
_TIGHTEST = 0.8  # of a bend's radius: what lies further in is not looked at
_HELD_M, _FADED_M = 8.0, 40.0  # what a host's body needs beside its lane is road for so far, and less and less until then
_SPARE_M = 0.15
_SPEED = re.compile(r"(\d+\.?\d*)\s*(|m/?s|km/?h|mph)")
_UNITS_MPS = {"": 1.0, "ms": 1.0, "kmh": 1.0 / 3.6, "mph": 0.44704}
_WIDEST_M = 20.0  # of what a lane of ours may be
_DRIFT_M = 25.0  # that stations along lanelets and s along the fitted line may differ by
_SEAM_M = 0.01  # between lanelets that touch
_ALONG = 0.5  # a lanelet whose direction has so much of the road's goes along it, or, against it, comes towards it
_Flags = NDArray[np.bool_]
_LEAST_M = 0.1  # less beside the lanes is none
_PASSABLE_M = 2.0  # nobody comes towards the host on less


def with_lanes(road: Road, network: Any, lane: EgoLane, placement: Placement, goals: Container[int] = ()) -> Road:
    """The road with the lanes of the ego lane's rows; those on the way to the lanelets of a goal begin where there is ground for them.
    Raises `ParameterError` where they cannot be such."""
    frame, rows = FrenetFrame(road=road), lane.rows

    def points(k: int, number: int) -> tuple[Array, Array]:
        return _points(network.find_lanelet_by_id(rows[k].lanelets[number]), lane.stations[k], placement, frame)

    spans = [points(k, row.leads)[0] for k, row in enumerate(rows)]
    low, high = max(-BEHIND_M, float(spans[0][0])), min(AHEAD_M, float(spans[-1][-1]))
    s = np.arange(np.ceil(low / _EVERY_M) * _EVERY_M, high, _EVERY_M)
    if s.size < 2:
        return road
    ends = np.maximum.accumulate([span[-1] for span in spans])
    row_at = np.minimum(np.searchsorted(ends, s, side="right"), len(rows) - 1)
    numbers = [number for row in rows for number in row.lanelets]
    right, left = min(numbers), max(numbers)
    widths = {number: np.zeros(s.size) for number in sorted(range(right, left + 1), key=lambda k: (abs(k), k))}
    limits = {number: np.full(s.size, np.nan) for number in widths}
    for k, row in enumerate(rows):
        here = row_at == k
        for number, identifier in row.lanelets.items() if here.any() else ():
            along, width = points(k, number)
            widths[number][here] = np.minimum(np.interp(s[here], along, width), _WIDEST_M)
            limits[number][here] = _limit_mps(network, network.find_lanelet_by_id(identifier))
    wanted = {number for row in rows for number, identifier in row.lanelets.items() if identifier in goals}
    _begun_sooner(widths, wanted, network, s, placement, frame)
    _narrowed(widths, road, s)
    lanes = []
    for number, wide in ((number, _opening(wide)) for number, wide in widths.items()):
        merges = Side.NONE
        if number == 0 and wide[-1] == 0.0:
            merges = Side.LEFT if rows[-1].leads > 0 else Side.RIGHT
        lanes.append(Lane(lane=number, width_m=_knots(s, wide), speed_limit_mps=_steps(s, limits[number]), merges=merges))
    lanes.sort(key=lambda lane: lane.lane)
    return replace(road, lanes_left=left, lanes_right=-right, lanes=tuple(lanes))


def _narrowed(widths: dict[int, Array], road: Road, s: Array) -> None:
    """No lane reaches so far into a bend that it comes near its centre."""
    around = [road.curvature_at(s + shift) for shift in (-_EVERY_M, -0.5 * _EVERY_M, 0.0, 0.5 * _EVERY_M, _EVERY_M)]
    for side in (1, -1):
        inside = np.maximum(side * np.array(around), 1e-9).max(axis=0)
        reached = np.zeros(s.size)
        for number in (number for number in widths if side * number >= 0):
            share = 0.5 if number == 0 else 1.0
            widths[number] = np.minimum(widths[number], np.maximum(_TIGHTEST / inside - reached, 0.0) / share)
            reached += share * widths[number]


def _begun_sooner(widths: dict[int, Array], wanted: set[int], network: Any, s: Array, placement: Placement, frame: FrenetFrame) -> None:
    """Lanes between the ego's and a goal's that begin ahead, where nothing is beside the ego's, begin as far before that as there is ground
    as wide that is not an oncoming lane's: who turns into a road may turn into any of its lanes, and a lane beside a ramp's is reached
    over its mouth."""
    for sign in (1, -1):
        beside = [sign * k for k in range(1, max((sign * number for number in wanted), default=0) + 1)]
        side_m = np.sum([widths[number] for number in widths if sign * number > 0], axis=0) if beside else np.zeros(s.size)
        begins = int(np.argmax((s >= 0.0) & (side_m > 0.0)))
        empty = int(np.argmax(s >= 0.0))
        if not beside or begins <= empty:
            continue
        here, needed = slice(empty, begins), np.zeros(begins - empty)
        edge = sign * 0.5 * widths[0][here]
        ground_m = _ground_beside_m(network, s[here], edge, sign, placement, frame, float(sum(widths[k][begins] for k in beside)))
        for number in beside:
            needed = needed + widths[number][begins]
            fits = np.logical_and.accumulate((ground_m >= needed - _BESIDE_STEP_M)[::-1])[::-1]
            widths[number][here] = np.where(fits, widths[number][begins], 0.0)


def _ground_beside_m(network: Any, s: Array, edge: Array, sign: float, placement: Placement, frame: FrenetFrame, far_m: float) -> Array:
    """(n,): how wide any lanelet's ground goes on beyond an edge (n,) to that side, but for where some come towards the road and none goes
    along it, looked at as far as `far_m`."""
    out = np.arange(_BESIDE_STEP_M, far_m + _BESIDE_STEP_M, _BESIDE_STEP_M)
    on, along, against = _directions(network, s[:, None], edge[:, None] + sign * out, placement, frame)
    free = np.logical_and.accumulate(on & (along | ~against), axis=1)
    return np.asarray(_BESIDE_STEP_M * free.sum(axis=1))


def _directions(network: Any, s: Array, d: Array, placement: Placement, frame: FrenetFrame) -> tuple[_Flags, _Flags, _Flags]:
    """Of places on the road, each of the broadcast shape: whether a lanelet is there, one that goes along the road, one against it."""
    import shapely

    x, y, yaw = placement.to_plane(*frame.to_plane(*np.broadcast_arrays(s, d, 0.0)))
    on, along, against = (np.zeros(x.shape, dtype=bool) for _ in range(3))
    for lanelet in network.lanelets:
        inside = shapely.contains_xy(_polygon(lanelet).buffer(_SEAM_M), x, y)
        if inside.any():
            points = lane_middle(lanelet)[0]
            ways = np.gradient(points, axis=0)
            nearest = np.argmin(np.hypot(x[inside, None] - points[:, 0], y[inside, None] - points[:, 1]), axis=1)
            turned = (np.cos(yaw[inside]) * ways[nearest, 0] + np.sin(yaw[inside]) * ways[nearest, 1]) / np.hypot(*ways[nearest].T)
            on |= inside
            along[inside] |= turned > _ALONG
            against[inside] |= turned < -_ALONG
    return on, along, against


def _opening(widths: Array) -> Array:
    """The widest lane within this one that begins and ends no more abruptly than a lane beside another may."""
    steps = _ABRUPT * _EVERY_M * np.arange(widths.size)
    from_behind = np.minimum.accumulate(widths - steps) + steps
    from_ahead = np.minimum.accumulate((widths + steps)[::-1])[::-1] - steps
    return np.asarray(np.minimum(from_behind, from_ahead))


def with_surface(road: Road, network: Any, placement: Placement, host_d_m: float, host_reach_m: float) -> Road:
    """The road with what is beside its lanes: any lanelet's ground, as far as it is joined to them, and what the host's body stands on; the
    lane of those who come towards the host, where most of the ground is theirs alone."""
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
        wide = _opening(np.maximum(wide, 0.0))
        if wide.max() > _LEAST_M:
            theirs = _is_oncoming(network, s, sign * (lanes_m + 0.5 * np.minimum(wide, road.lane_width_m)), wide, placement, frame)
            found.append(Lane(lane=number, width_m=_knots(s, wide), shoulder=True, oncoming=theirs))
    left, right = (any(lane.lane * sign > 0 for lane in found) for sign in (1, -1))
    lanes = tuple(sorted((*road.lanes, *found), key=lambda lane: lane.lane))
    return replace(road, lanes_left=road.lanes_left + left, lanes_right=road.lanes_right + right, lanes=lanes)


def _is_oncoming(network: Any, s: Array, d: Array, wide: Array, placement: Placement, frame: FrenetFrame) -> bool:
    """Whether, of the places (s, d) that are wide enough for a car to pass, most belong to lanelets that come towards the host alone."""
    lanes = wide >= _PASSABLE_M
    _, along, against = _directions(network, s[lanes], d[lanes], placement, frame)
    return bool(lanes.any()) and float(np.mean(against & ~along)) > 0.5


def _without_peaks(values: Array) -> Array:
    """A row without what rises for two samples at most."""
    windows = np.lib.stride_tricks.sliding_window_view
    least = windows(np.pad(values, 1, mode="edge"), 3).min(axis=1)
    return np.asarray(windows(np.pad(least, 1, mode="edge"), 3).max(axis=1))


def _points(lanelet: Any, station_m: tuple[float, float], placement: Placement, frame: FrenetFrame) -> tuple[Array, Array]:
    """s [m] of a lanelet's middle, increasing, and its width there [m]."""
    middle, width = lane_middle(lanelet)
    s, _ = on_road(middle, station_m, placement, frame)
    kept = np.concatenate([[True], s[1:] > np.maximum.accumulate(s)[:-1] + 1e-6])
    return s[kept], width[kept]


def on_road(points: Array, station_m: tuple[float, float] | None, placement: Placement, frame: FrenetFrame) -> tuple[Array, Array]:
    """(s, d) of points (n, 2) of the scenario's plane; `station_m` says about where along the road they lie."""
    x, y, yaw = placement.to_frame(points[:, 0], points[:, 1], np.zeros(len(points)))
    guess = None
    if station_m is not None:
        near = np.arange(station_m[0] - _DRIFT_M, station_m[1] + _DRIFT_M, 1.0)
        line_x, line_y, _ = frame.to_plane(near, np.zeros(near.size), np.zeros(near.size))
        guess = near[np.argmin(np.hypot(x[:, None] - line_x, y[:, None] - line_y), axis=1)]
    s, d, _ = frame.to_road(x, y, yaw, guess_s_m=guess)
    return s, d


def _polygon(lanelet: Any) -> Any:
    import shapely

    ring = np.concatenate([np.asarray(lanelet.left_vertices), np.asarray(lanelet.right_vertices)[::-1]])
    return shapely.Polygon(ring).buffer(0.0)


def _limit_mps(network: Any, lanelet: Any) -> float:
    """By the signs that a lanelet refers to; NaN without one that can be read. A number is in m/s, as the format says, unless a map says
    otherwise behind it."""
    for identifier in lanelet.traffic_signs or ():
        sign = network.find_traffic_sign_by_id(identifier)
        for element in sign.traffic_sign_elements if sign is not None else ():
            if element.traffic_sign_element_id.name == "MAX_SPEED" and element.additional_values:
                said = _SPEED.fullmatch(str(element.additional_values[0]).strip().lower())
                return float(said[1]) * _UNITS_MPS[said[2].replace("/", "")] if said else np.nan
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
