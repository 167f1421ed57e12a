"""The route as a road of ours: a reference line along the middle of one column of lanes, and the lanes beside it, from where to where."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter

import numpy as np

from mcdas_opt.domain.lane import Knots, Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import InputError
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.sumo.connection import LaneDomain
from mcdas_opt.interop.sumo.polylines import even, led_over, length_m, shifted, stations_m
from mcdas_opt.interop.sumo.road_line import line_along
from mcdas_opt.interop.sumo.route import Edge, lanes_inside
from mcdas_opt.interop.sumo.sideways import SidewaysSteps
from mcdas_opt.tracking.plane import to_plane, to_road

_UNFOLDED = 1.2  # a bend's radius, at least, of what lies inside it: nearer to its centre a road would fold over itself
_BEYOND_M = 400.0  # the line goes straight on before the route's beginning and after its end
_WINDOW_M, _STRIDE_M = (300.0, 800.0), 100.0
_STRAIGHT_M = 1.0  # so far beyond its ends a window is straight, as what it leaves out may lie beside the centre of a bend that it cuts
_WIDENS_M = 5.0  # a lane comes to another width within so much
_APART_M = 2.0  # between two widths of a lane
_SHORTEST_M, _SHORTEST_SHAPE_M = 0.1, 2.0  # of an edge; and of a lane whose shape tells where the road leads
_STRAY_M, _ASTRAY_M = 30.0, 10.0  # along and beside lanes that turn as no car does: a line that strays farther is none
_TIGHT_1PM = 1.0 / 25.0
_TURNING_M = 0.5  # of a junction's surface to either side of a lane that turns so tightly there; who waits beside it does not stand on it
_SAME_M = 0.05  # of two stations: one
_JUMPS_M, _ALONG = 0.5, 0.8  # from a body's front to its rear; and the cosine of its angle to the road, at least
_CLOSED_M = 1.0  # the least that is closed where a lane leads nowhere


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """An edge of the route in the frame: from where its lanes begin to where they end."""

    edge: Edge
    begin_m: float
    end_m: float


class RoadFrame:
    """The route's plane against our (s, d): d = 0 is the middle of column `base`, which counts as wide as its first lane all along."""

    def __init__(self, lanes: LaneDomain, edges: Sequence[Edge], base: int, friction: float) -> None:
        self.base, self._friction = base, friction
        self.lane_width_m = edges[0].nearest(base).width_m
        pieces = [self._middle(edge) for edge in edges]
        inside = [_through(lanes, edge, base) for edge in edges]
        for k, edge in enumerate(edges[:-1]):
            if over := edge.leading_near(base).leads_over:
                left_m = _beside_m(edges[k + 1], base, base - over, self.lane_width_m)
                *inside[k], pieces[k + 1] = led_over([*inside[k], pieces[k + 1]], left_m)
        steps = SidewaysSteps(pieces, [edge.nearest(base).limit_mps for edge in edges])
        parts = [part for k, through in enumerate(inside) for part in (steps.passed(k), *(() if steps.at(k) else through))]
        line = even([parts[0], *(part for part in parts[1:] if length_m(part) > _SHORTEST_SHAPE_M)])
        columns = [column for edge in edges for column in edge.columns]
        inside_m = ((k + 0.5) * self.lane_width_m + 2.0 * _TURNING_M for k in (base - min(columns), max(columns) - base))
        self.placement, self._knots = line_along(line, *(_UNFOLDED * m for m in inside_m))
        self._frame = FrenetFrame(
            road=Road(curvature=self._knots), s_min_m=-_BEYOND_M, s_max_m=self._knots[-1][0] + _BEYOND_M
        )  # fmt: skip
        self._beside: tuple[Array, Array] | None = None
        ends = list(self._ends(pieces, inside))
        self.sections = tuple(Section(edge=edge, begin_m=begin, end_m=end) for edge, (begin, end) in zip(edges, ends, strict=True))
        self._begins = [section.begin_m for section in self.sections]
        self._beside = self._beside_the_line(steps, inside)
        self._turning = {k: self._nearest_on(k) for k in range(len(edges) - 1) if self._bends(self.sections[k].end_m, self._begins[k + 1])}
        self._road = lru_cache(maxsize=8)(self._window)
        self._refuse_strays(pieces)

    @property
    def end_m(self) -> float:
        return self.sections[-1].end_m

    def to_road(
        self, x: Array, y: Array, yaw: Array, near_s_m: float | None = None, length_m: Array | float = 0.0
    ) -> tuple[Array, Array, Array]:
        """(s, d, heading relative to the road) of poses in SUMO's plane, yaw counter-clockwise from its x axis.

        Bodies of that length drive across a step sideways of all lanes with their front bumper on its lane; what SUMO says of their
        angle there is of the jump."""
        there = self.placement.to_frame(x, y, yaw)
        s, d, psi = self._frame.to_road(*there) if near_s_m is None else to_road(self._frame, *there, near_s_m)
        if self._beside is None:
            return s, d, psi
        half_m = np.broadcast_to(0.5 * length_m, s.shape)
        along_m, across_m = half_m * np.cos(psi), half_m * np.sin(psi)
        front_m, rear_m = self._beside_m(s + along_m), self._beside_m(s - along_m)
        turned = psi - np.arctan2((front_m - rear_m) * np.cos(psi), np.maximum(2.0 * half_m, 1e-9))
        jumps = (np.abs(front_m - rear_m) > _JUMPS_M) & (np.cos(psi) > _ALONG)
        return (
            np.where(jumps, s + along_m - half_m, s),
            np.where(jumps, d + across_m - front_m, d - 0.5 * (front_m + rear_m)),
            np.where(jumps, 0.0, turned),
        )

    def to_plane(self, s: float, d: float, psi: float) -> tuple[float, float, float]:
        """(x, y, yaw) in SUMO's plane."""
        return self.to_plane_without_steps(s, d + float(self._beside_m(np.array(s))), psi)

    def to_plane_without_steps(self, s: float, d: float, psi: float) -> tuple[float, float, float]:
        """The same where the lanes made no steps sideways."""
        x, y, yaw = to_plane(self._frame, *(np.array([q]) for q in (s, d, psi)))
        return tuple(float(q[0]) for q in self.placement.to_plane(x, y, yaw))  # type: ignore[return-value]

    def curvature_at(self, s_m: float) -> float:
        return float(self._frame.road.curvature_at(s_m))

    def section_at(self, s_m: float) -> Section:
        """What lies between two edges belongs to the one before."""
        return self.sections[max(bisect_right(self._begins, s_m) - 1, 0)]

    def edges_from(self, s_m: float) -> list[Edge]:
        """The route's edges from that place on."""
        return [section.edge for section in self.sections[max(bisect_right(self._begins, s_m) - 1, 0) :]]

    def column_at(self, s_m: float, d_m: float) -> int:
        """Of the lanes that there are."""
        columns = self.section_at(s_m).edge.columns
        return min(max(self.base + self.road_at(s_m).lane_of(d_m, s_m), columns.start), columns.stop - 1)

    def column_beside(self, s_m: float, d_m: float) -> int:
        """The same; of who is beside all lanes, one that there is not, further out."""
        columns, road = self.section_at(s_m).edge.columns, self.road_at(s_m)
        for column, side in ((columns.start, -1), (columns.stop - 1, 1)):
            half_m = 0.5 * road.lane_width_at(column - self.base, s_m)
            if side * (d_m - self.centre_m(column, s_m)) > half_m:
                return column + side
        return self.column_at(s_m, d_m)

    def centre_m(self, column: int, s_m: float) -> float:
        return self.road_at(s_m).lane_centre_m(column - self.base, s_m)

    def road_at(self, s_m: float) -> Road:
        """Our road as far as it matters at `s_m`, the base's lane as lane 0; the same record for a stretch."""
        return self._road(math.floor(s_m / _STRIDE_M))

    def _window(self, stretch: int) -> Road:
        low, high = stretch * _STRIDE_M - _WINDOW_M[0], stretch * _STRIDE_M + _WINDOW_M[1]
        s = [low, *(knot for knot, _ in self._knots if low < knot < high), high]
        kappa = self._frame.road.curvature_at(np.array(s)).tolist()
        bends = ((low - _STRAIGHT_M, 0.0), *zip(s, kappa, strict=True), (high + _STRAIGHT_M, 0.0))
        first = max(bisect_right(self._begins, low) - 1, 0)
        there = range(first, max(bisect_right(self._begins, high), first + 1))
        columns = {column for k in there for column in self.sections[k].edge.columns} | {self.base}
        oncoming = self._oncoming(columns, there)
        lanes = [self._lane(column, there, stretch * _STRIDE_M) for column in range(min(columns), max(columns) + 1)]
        beside = [lane.lane for lane in oncoming]
        return Road(
            lane_width_m=self.lane_width_m,
            lanes_left=max([max(columns) - self.base, *beside]),
            lanes_right=-min([min(columns) - self.base, *beside]),
            friction=self._friction,
            speed_limit_mps=max(lane.limit_mps for k in there for lane in self.sections[k].edge.lanes),
            curvature=bends if any(kappa) else ((0.0, 0.0),),
            lanes=tuple(sorted([*lanes, *oncoming], key=attrgetter("lane"))),
        )

    def _lane(self, column: int, there: range, host_m: float) -> Lane:
        """A column as a lane of ours along some sections: closed where there is none, or where it does not lead on along the route; but not
        where lanes further from the base lead on, which would be out of reach. The base is passed on one side: of those to which it ends,
        on the first that a host at `host_m` comes to; where it ends to the other one it counts as open until then."""
        closed: list[tuple[float, float]] = []
        on_left: list[bool] = []
        widths: list[tuple[float, float]] = []
        limits: list[tuple[float, float]] = []
        own, far_m = column == self.base, self.end_m + _BEYOND_M
        for k in there:
            section, begins_m = self.sections[k], self._begins[k]
            until_m = self._begins[k + 1] if k + 1 < there.stop else math.inf
            lane, nearest = section.edge.lane(column), section.edge.nearest(column)
            if not limits or limits[-1][1] != nearest.limit_mps:
                limits.append((begins_m, nearest.limit_mps))
            if lane is None:
                is_left, shut = section.edge.columns.start > column, (begins_m, min(until_m, far_m))
            else:
                width_m = self.lane_width_m if own else lane.width_m
                pieces = [(begins_m + _WIDENS_M, width_m), (section.end_m, width_m)]
                if self._turning.get(k) == column:
                    wide_m = width_m + 2.0 * _TURNING_M
                    pieces[1:] = [(section.end_m - _WIDENS_M, width_m), (section.end_m, wide_m), (self._begins[k + 1], wide_m)]
                widths += pieces
                if k + 1 == len(self.sections) or (lane.goes_on and column in self.sections[k + 1].edge.columns):
                    continue
                is_left, shut = self._leads_on_left(k, column), (section.end_m, max(min(until_m, far_m), section.end_m + _CLOSED_M))
            if own or is_left == (column < self.base):
                closed.append(shut)
                on_left.append(is_left)
        passed_left = next((left for (_, end_m), left in zip(closed, on_left, strict=True) if end_m > host_m), any(on_left))
        if own:
            closed = [shut for shut, left in zip(closed, on_left, strict=True) if left is passed_left]
        merges = Side.LEFT if passed_left else Side.RIGHT
        return Lane(
            lane=column - self.base,
            width_m=() if {width for _, width in widths} <= {self.lane_width_m} else _increasing(widths),
            speed_limit_mps=tuple(limits),
            closed_m=_joined(closed),
            merges=merges if own and closed else Side.NONE,
        )

    def _oncoming(self, columns: Container[int], there: range) -> list[Lane]:
        """The lanes of oncoming traffic beside the innermost column of these sections, each along the edges that have one there, but for
        where the road bends too tightly around it."""
        widths: dict[int, list[tuple[float, float]]] = {}
        for k in there:
            beside = self.sections[k].edge.oncoming
            if beside is None or beside.column in columns:
                continue
            far_m = (abs(beside.column - self.base) - 0.5) * self.lane_width_m + beside.width_m
            begin_m, end_m = self._gentle_stretch(self._begins[k], self.sections[k].end_m, math.copysign(far_m, beside.column - self.base))
            if end_m - begin_m > 2.0 * _WIDENS_M:
                ends = (begin_m, begin_m + _WIDENS_M, end_m - _WIDENS_M, end_m)
                widths.setdefault(beside.column, []).extend(zip(ends, (0.0, beside.width_m, beside.width_m, 0.0), strict=True))
        innermost = [column for column in widths if column - 1 in columns or column + 1 in columns]
        return [Lane(lane=column - self.base, width_m=_increasing(widths[column]), oncoming=True) for column in innermost]

    def _gentle_stretch(self, begin_m: float, end_m: float, d_m: float) -> tuple[float, float]:
        """The longest part of a stretch of road along which a line at that offset keeps its distance from the centre of every bend."""
        knots = np.array([(s, kappa) for s, kappa in self._knots if begin_m < s < end_m]).reshape(-1, 2)
        ends = np.array([begin_m, *knots[_UNFOLDED * d_m * knots[:, 1] > 1.0, 0].tolist(), end_m])
        k = int(np.argmax(np.diff(ends)))
        return float(ends[k]), float(ends[k + 1])

    def _leads_on_left(self, k: int, column: int) -> bool:
        """Whether the nearest lane that goes on from a section lies to the left of that column."""
        after = self.sections[k + 1].edge.columns
        on = [lane.column for lane in self.sections[k].edge.lanes if lane.goes_on and lane.column in after]
        return bool(on) and min(on, key=lambda one: abs(one - column)) > column

    def _nearest_on(self, k: int) -> int:
        """The column nearest to the base that goes on from a section."""
        on = [lane.column for lane in self.sections[k].edge.lanes if lane.goes_on]
        return min(on, key=lambda one: abs(one - self.base), default=self.base)

    def _bends(self, begin_m: float, end_m: float) -> bool:
        """Whether a stretch is too tight for a car to stay in a lane of usual width."""
        return any(abs(kappa) > _TIGHT_1PM for s_m, kappa in self._knots if begin_m <= s_m <= end_m)

    def _middle(self, edge: Edge) -> Array:
        """Of the base on an edge, or of where it would be."""
        lane = edge.nearest(self.base)
        return shifted(lane.shape, _beside_m(edge, lane.column, self.base, self.lane_width_m))

    def _ends(self, pieces: Sequence[Array], inside: Sequence[Sequence[Array]]) -> Iterator[tuple[float, float]]:
        """Where the middles of the edges begin and end, one after the other."""
        end_m = expected_m = 0.0
        for piece, through in zip(pieces, inside, strict=True):
            begin_m = max(self._station(piece[0], expected_m), end_m)
            end_m = max(self._station(piece[-1], begin_m + length_m(piece)), begin_m + _SHORTEST_M)
            yield begin_m, end_m
            expected_m = end_m + sum(map(length_m, through))

    def _beside_the_line(self, steps: SidewaysSteps, inside: Sequence[Sequence[Array]]) -> tuple[Array, Array] | None:
        """Stations, and how far the lanes lie to the left of where the road has them: near steps sideways, which the line passes as a car
        could; None without one."""
        found: list[tuple[float, float]] = []
        for k, points, along_m in steps.moved(inside):
            for point, at_m in zip(points, along_m, strict=True):
                s, d, _ = self.to_road(point[:1], point[1:], np.zeros(1), near_s_m=self._begins[k] + float(at_m))
                if not found or s[0] > found[-1][0] + _SAME_M:
                    found.append((float(s[0]), float(d[0])))
        if not found:
            return None
        stations, left_m = np.array(found).T
        return stations, left_m

    def _beside_m(self, s: Array) -> Array:
        """How far the lanes lie to the left of where the road has them."""
        return np.zeros(s.shape) if self._beside is None else np.interp(s, *self._beside)

    def _refuse_strays(self, pieces: Sequence[Array]) -> None:
        """Raises `InputError` where the line cannot stay with the lanes."""
        for section, piece in zip(self.sections, pieces, strict=True):
            share = stations_m(piece) / length_m(piece)
            for point, at_m in zip(piece, section.begin_m + share * (section.end_m - section.begin_m), strict=True):
                s, d, _ = self.to_road(point[:1], point[1:], np.zeros(1), near_s_m=float(at_m))
                if abs(float(d[0])) > _ASTRAY_M or abs(float(s[0] - at_m)) > _STRAY_M:
                    raise InputError("SUMO network", section.edge.id, None, "is off the route's line, which turns back here as no car does")

    def _station(self, point: Array, expected_m: float) -> float:
        """Of a point of the line: found near where it should be, or there. A route may come back beside itself."""
        s, _, _ = self.to_road(point[:1], point[1:], np.zeros(1), near_s_m=expected_m)
        return float(s[0]) if abs(float(s[0]) - expected_m) < _STRAY_M else expected_m


def _through(lanes: LaneDomain, edge: Edge, base: int) -> list[Array]:
    """The lanes inside the junction behind an edge, beside which the base lies."""
    lane = edge.leading_near(base)
    left_m = _beside_m(edge, lane.column, base, lane.width_m)
    return [shifted(np.asarray(lanes.getShape(via), dtype=np.float64)[:, :2], left_m) for via in lanes_inside(lanes, lane.via)]


def _beside_m(edge: Edge, column: int, base: int, usual_m: float) -> float:
    """From the middle of the base to that of a column [m], to the left; a lane that is not there counts as wide as usual."""
    step = 1 if column > base else -1
    between = [usual_m if (lane := edge.lane(k)) is None else lane.width_m for k in range(base, column + step, step)]
    return step * (sum(between) - 0.5 * (between[0] + between[-1]))


def _joined(stretches: list[tuple[float, float]]) -> Knots:
    """The same with those in one that meet."""
    joined: list[tuple[float, float]] = []
    for begin, end in stretches:
        if joined and begin <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(end, joined[-1][1]))
        else:
            joined.append((begin, end))
    return tuple(joined)


def _increasing(knots: Sequence[tuple[float, float]]) -> Knots:
    """Those that lie beyond all before them: of an edge that is shorter than its lane takes to widen, the first."""
    found = list(knots[:1])
    for knot in knots[1:]:
        if knot[0] >= found[-1][0] + _APART_M:
            found.append(knot)
    return tuple(found)
