"""The borders of a road's lanes along it, and the edges of what is drivable: piecewise linear in s."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.lane import Knots, Lane
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError

_STEP_M = 1.0  # before and behind a closed stretch its edge turns within so little
_STEEPEST = 2.0  # metres across per metre along: a lane that narrows more steeply would leave a hole beside the next one out
STEERED = 0.25  # metres across per metre along: no edge of `steered` turns inwards more steeply
_EVERY_M = 1.0  # the knots of `steered`, where an edge is steeper
_MOST_KNOTS = 4000
_KEPT = 256  # places at which the borders are remembered


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Left and right edge d [m] at knots s [m], (3, K); linear in between, held at both ends."""

    table: Array

    def left(self, s_m: Array | float) -> Array:
        return np.asarray(np.interp(s_m, self.table[0], self.table[1]))

    def right(self, s_m: Array | float) -> Array:
        return np.asarray(np.interp(s_m, self.table[0], self.table[2]))

    def seen_from(self, s_m: float) -> Edges:
        """The same with their s counted from `s_m`."""
        s, left, right = self.table
        return Edges(np.array([s - s_m, left, right]))


@dataclass(frozen=True, slots=True, eq=False)
class LaneBorders:
    """`d_m` (lanes + 1, K): the borders from the right at knots `s_m` (K,). `edges`: of what is drivable. `steered`: edges that are
    nowhere outside those, and that a car can follow: what plans are made with; the judge has `edges`."""

    s_m: Array
    d_m: Array
    edges: Edges
    steered: Edges
    _known: dict[float, tuple[float, ...]] = field(default_factory=dict, init=False, repr=False)  # at the places asked for of late

    @classmethod
    def of(
        cls, lanes: Sequence[Lane], lane_width_m: float, lanes_left: int, lanes_right: int, shoulder_left_m: float, shoulder_right_m: float
    ) -> LaneBorders:
        """From the lanes that differ (at least one). Raises `ParameterError` where they leave a hole, or nothing to drive on."""
        numbers = range(-lanes_right, lanes_left + 1)
        by_number = {lane.lane: lane for lane in lanes}
        usual = [by_number.get(k, Lane(lane=k)) for k in numbers]
        s = _knots(lanes)
        widths = np.array([lane.width_at(s, lane_width_m) for lane in usual])
        _refuse_holes(usual, s, widths)
        own = usual[lanes_right]
        w0 = widths[lanes_right]
        left = np.full(s.size, 0.5 * lane_width_m) if own.merges is Side.LEFT else 0.5 * w0
        left = w0 - 0.5 * lane_width_m if own.merges is Side.RIGHT else left
        above = np.cumsum(widths[lanes_right + 1 :], axis=0) + left
        below = (left - w0) - np.cumsum(widths[:lanes_right][::-1], axis=0)
        d = np.concatenate([below[::-1].reshape(-1, s.size), [left - w0], [left], above.reshape(-1, s.size)])
        high, low = d[-1] + shoulder_left_m, d[0] - shoulder_right_m
        for k, lane in enumerate(usual):
            shut = _within(s, lane.closed_m)
            if lane.lane > 0 or (lane.lane == 0 and own.merges is Side.RIGHT) or (lane.lane == 0 and lanes_right and not lanes_left):
                high = np.where(shut, np.minimum(high, d[k]), high)
            else:
                low = np.where(shut, np.maximum(low, d[k + 1]), low)
        if np.any(high - low <= 0.0):
            where = float(s[int(np.argmax(high - low <= 0.0))])
            raise ParameterError("lanes", where, "is where nothing is left to drive on: the road ends there (road_end_s_m)", "m")
        edges = Edges(np.array([s, high, low]))
        return cls(s, d, edges, _steered(edges))

    def seen_from(self, s_m: float) -> LaneBorders:
        """The same with their s counted from `s_m`."""
        steered = self.steered.seen_from(s_m)
        edges = steered if self.edges is self.steered else self.edges.seen_from(s_m)
        return LaneBorders(self.s_m - s_m, self.d_m, edges, steered)

    def along(self, s_m: Array) -> Array:
        """(lanes + 1, n): the borders' d [m] at many places (n,), from the right."""
        return np.array([np.interp(s_m, self.s_m, row) for row in self.d_m])

    def at(self, s_m: float) -> tuple[float, ...]:
        """The borders' d [m] at one place, from the right: worked out once for a place, which a cycle asks for again and again."""
        known = self._known.get(s_m)
        if known is None:
            if len(self._known) >= _KEPT:
                self._known.clear()
            known = self._known[s_m] = self._worked_out(s_m)
        return known

    def _worked_out(self, s_m: float) -> tuple[float, ...]:
        s, d = self.s_m, self.d_m
        k = int(s.searchsorted(s_m))
        if k in (0, s.size):
            return tuple(map(float, d[:, min(k, s.size - 1)]))
        before = d[:, k - 1]
        row: list[float] = (before + (s_m - s[k - 1]) / (s[k] - s[k - 1]) * (d[:, k] - before)).tolist()
        return tuple(row)


def _knots(lanes: Sequence[Lane]) -> Array:
    """Where anything changes."""
    places = [s for lane in lanes for s, _ in lane.width_m]
    for lane in lanes:
        for begin, end in lane.closed_m:
            places += [begin - _STEP_M, begin, end, end + _STEP_M]
    return np.unique(np.array(places or [0.0]))


def _within(s: Array, stretches: Knots) -> NDArray[np.bool_]:
    """(K,) whether each place lies in one of the stretches, their ends included; `s` increases."""
    ends = np.reshape(np.array(stretches, dtype=np.float64), (-1, 2))
    entered = np.bincount(np.searchsorted(s, ends[:, 0]), minlength=s.size + 1)
    left = np.bincount(np.searchsorted(s, ends[:, 1], side="right"), minlength=s.size + 1)
    return np.asarray(np.cumsum(entered - left)[:-1] > 0)


def _refuse_holes(usual: Sequence[Lane], s: Array, widths: Array) -> None:
    """A lane may be as narrow as it likes, but where another lies beyond it, that one must not be thrown aside."""
    if s.size < 2:
        return
    slopes = np.abs(np.diff(widths, axis=1)) / np.diff(s)
    steep = slopes > _STEEPEST
    for k, lane in enumerate(usual):
        beyond = widths[k + 1 :] if lane.lane >= 0 else widths[:k]
        if lane.lane == 0 and lane.merges is Side.NONE:
            beyond = np.delete(widths, k, axis=0)
        elif lane.lane == 0 and lane.merges is Side.LEFT:
            beyond = widths[:k]
        wide = (np.minimum(beyond[:, 1:], beyond[:, :-1]) > 0.0).any(axis=0) if len(beyond) else np.zeros(s.size - 1, dtype=bool)
        bad = steep[k] & wide
        if bad.any():
            j = int(np.argmax(bad))
            span = [float(s[j]), float(s[j + 1])]
            raise ParameterError(
                f"lane {lane.lane}: width_m", span, "leaves a hole beside the lane beyond it: it changes too abruptly", "m"
            )


def _steered(edges: Edges) -> Edges:
    """The widest edges inside these that turn inwards no more steeply than a car can follow."""
    s, left, right = edges.table
    if s.size < 2:
        return edges
    with np.errstate(over="ignore"):  # of knots that are as good as in one place
        slopes = np.abs(np.diff(np.array([left, right])) / np.diff(s))
    if slopes.max() <= STEERED:
        return edges
    span = max(float(np.ptp(left)), float(np.ptp(right))) / STEERED
    low, high = s[0] - span, s[-1] + span
    even = np.linspace(low, high, int(min(np.ceil((high - low) / _EVERY_M) + 1, _MOST_KNOTS)))
    places = np.union1d(even, s)
    # the lowest cone over any place is the lowest over a knot, since edges are linear in between
    inner_left = np.minimum(_lowest_cone(s, left, places), edges.left(places))
    inner_right = np.maximum(-_lowest_cone(s, -right, places), edges.right(places))
    return Edges(np.array([places, inner_left, inner_right]))


def _lowest_cone(s: Array, heights: Array, places: Array) -> Array:
    """(P,) the least over the knots of height + `STEERED` times the distance to the knot, in two sweeps; `s` and `places` increase."""
    from_behind = _lowest_cone_behind(s, heights, places)
    from_ahead = _lowest_cone_behind(-s[::-1], heights[::-1], -places[::-1])[::-1]
    return np.minimum(from_behind, from_ahead)


def _lowest_cone_behind(s: Array, heights: Array, places: Array) -> Array:
    """The same of the knots behind each place; of the first knot where none is."""
    rise = heights - STEERED * (s - s[0])
    lowest = np.maximum.accumulate(np.where(rise == np.minimum.accumulate(rise), np.arange(s.size), 0))
    k = lowest[np.maximum(np.searchsorted(s, places, side="right") - 1, 0)]
    return np.asarray(heights[k] + STEERED * np.abs(places - s[k]))
