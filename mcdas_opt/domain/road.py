"""The road in its Frenet frame: s forward, d left, (0, 0) = the host's lane centre at the start."""

from __future__ import annotations

import copy
import math
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import lru_cache
from operator import itemgetter
from typing import Any

import numpy as np

from mcdas_opt.domain.lane import NEAREST_KNOTS_M, SPEED_LIMITS_MPS, Lane
from mcdas_opt.domain.lane_borders import Edges, LaneBorders
from mcdas_opt.domain.rules import FARTHEST_M, Array, all_of, finite, within
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError

STRETCH_M = 1000.0  # that a host drives before its places are counted from a new origin
_LEFT_S = 20.0  # no lane is gone to for its speed that ends sooner
_SOON_S, _CHANGE_S = 0.5, 5.0  # a lane change crosses the marking no sooner, and is done by then
_EASING_MPS2 = 1.5  # of braking towards a lower speed limit ahead
_TIGHTEST = 0.9  # of a bend's radius: no edge lies further in
_NOTHING_M = 1e-6  # a lane that is narrower is not there
# What a road can have: from a footpath to a square, from wet ice to a racing tyre on rubber and wings.
_LANE_WIDTHS_M = (0.1, 20.0)
_WIDEST_SHOULDER_M = 1000.0
MOST_LANES = 100
_FRICTIONS = (0.01, 10.0)
_KAPPA_1PM = itemgetter(1)  # of a knot


def local_origin_m(s_m: float) -> float:
    """Where s = 0 lies for whoever works near `s_m`: the nearest whole kilometre. So numbers stay small wherever the car drives, and what
    is remembered of a road, or of the last solve, serves for that long."""
    return STRETCH_M * round(s_m / STRETCH_M) if math.isfinite(s_m) else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Road:
    """Lanes along a reference line of piecewise linear curvature.

    `curvature` holds knots (s [m], kappa [1/m]), linear in between and held at both ends; a left turn is positive.
    `friction` is what the reader of this record believes: the planner's belief in a `Situation`, the truth in the plant.
    `lanes` says of single lanes what is not so all along: where they begin and end, narrow, are closed or limited (`domain.lane`).
    Lanes are counted from the host's first, 0, to the left. Whoever asks for a lane or an edge says where: `s_m`.
    """

    lane_width_m: float = 3.7
    lanes_left: int = 0
    lanes_right: int = 0
    shoulder_left_m: float = 0.0
    shoulder_right_m: float = 0.0
    friction: float = 0.9
    speed_limit_mps: float = 36.0
    curvature: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    road_end_s_m: float | None = None
    lanes: tuple[Lane, ...] = ()
    borders: LaneBorders | None = field(init=False, repr=False, compare=False, default=None)
    knots: Array = field(init=False, repr=False, compare=False)  # (2, n): of the curvature, s and kappa
    is_straight: bool = field(init=False, repr=False, compare=False)
    sharpest_1pm: float = field(init=False, repr=False, compare=False)  # the largest curvature to either side
    _hash: int = field(init=False, repr=False, compare=False)  # of a long road, asked for in every cycle

    def __hash__(self) -> int:
        return self._hash

    def __post_init__(self) -> None:
        within("lane_width_m", self.lane_width_m, *_LANE_WIDTHS_M, "m")
        for name, value in (("lanes_left", self.lanes_left), ("lanes_right", self.lanes_right)):
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MOST_LANES:
                raise ParameterError(name, value, f"must be a whole number, at least 0 and at most {MOST_LANES}")
        within("shoulder_left_m", self.shoulder_left_m, 0.0, _WIDEST_SHOULDER_M, "m")
        within("shoulder_right_m", self.shoulder_right_m, 0.0, _WIDEST_SHOULDER_M, "m")
        within("friction", self.friction, *_FRICTIONS)
        within("speed_limit_mps", self.speed_limit_mps, *SPEED_LIMITS_MPS, "m/s")
        if self.road_end_s_m is not None:
            within("road_end_s_m", self.road_end_s_m, -2.0 * FARTHEST_M, 2.0 * FARTHEST_M, "m")
        try:
            knots = tuple((finite("curvature", s), finite("curvature", k)) for s, k in self.curvature)
        except ParameterError:
            raise ParameterError("curvature", self.curvature, "must hold at least one finite [s_m, kappa_1pm] pair") from None
        except (TypeError, ValueError):
            raise ParameterError("curvature", self.curvature, "must be a list of [s_m, kappa_1pm] pairs") from None
        object.__setattr__(self, "curvature", knots)
        if not knots:
            raise ParameterError("curvature", self.curvature, "must hold at least one finite [s_m, kappa_1pm] pair")
        if max(abs(knots[0][0]), abs(knots[-1][0])) > 2.0 * FARTHEST_M:
            raise ParameterError("curvature", self.curvature, f"s_m of the knots must lie within {2.0 * FARTHEST_M:g} of 0", "m")
        if np.any(np.diff([s for s, _ in knots]) < NEAREST_KNOTS_M):
            raise ParameterError("curvature", self.curvature, f"s_m of the knots must increase, by at least {NEAREST_KNOTS_M:g}", "m")
        self._set_knots()
        self._set_borders()
        if self._folds():
            raise ParameterError("curvature", self.curvature, "is too tight: the road would fold over itself", "1/m")

    def _folds(self) -> bool:
        """Whether an edge on the inside of a bend comes near its centre; of a road that is the same all along, either edge of any bend."""
        if self.borders is None:
            return self.sharpest_1pm * max(self.left_edge_m, -self.right_edge_m) >= _TIGHTEST
        s = np.union1d(self.borders.edges.table[0], [k[0] for k in self.curvature])
        bend = self.curvature_at(s)
        return bool(np.maximum(bend * self.borders.edges.left(s), bend * self.borders.edges.right(s)).max() >= _TIGHTEST)

    def _set_knots(self) -> None:
        knots = np.ascontiguousarray(np.array(self.curvature).T)
        knots.setflags(write=False)
        object.__setattr__(self, "knots", knots)
        object.__setattr__(self, "is_straight", not any(map(_KAPPA_1PM, self.curvature)))
        object.__setattr__(self, "sharpest_1pm", float(np.abs(knots[1]).max()))
        # numbers alone: the same in every process
        object.__setattr__(self, "_hash", hash((self.curvature, self.lane_width_m, self.lanes_left, self.lanes_right, self.friction)))

    def _set_borders(self) -> None:
        """From the lanes that differ from what the road says of all: the others are left out."""
        lanes = all_of("lanes", self.lanes, Lane)
        numbers = [lane.lane for lane in lanes]
        for k, number in enumerate(numbers):
            if number in numbers[:k]:
                raise ParameterError(f"lanes[{k}].lane", number, "is described twice: its pieces overlap")
            if not -self.lanes_right <= number <= self.lanes_left:
                raise ParameterError(f"lanes[{k}].lane", number, f"is none of the road's: {-self.lanes_right} to {self.lanes_left}")
            if lanes[k].closed_m and number == 0 and self.lanes_left and self.lanes_right and lanes[k].merges is Side.NONE:
                raise ParameterError(f"lanes[{k}].merges", "none", "must say to which side a closed lane 0 is passed: left or right")
        lanes = tuple(lane for lane in lanes if lane.differs_from(self.lane_width_m, self.speed_limit_mps))
        object.__setattr__(self, "lanes", lanes)
        object.__setattr__(self, "borders", None)
        if not lanes:
            return
        width, shoulders = self.lane_width_m, (self.shoulder_left_m, self.shoulder_right_m)
        object.__setattr__(self, "borders", LaneBorders.of(lanes, width, self.lanes_left, self.lanes_right, *shoulders))

    @property
    def grip_mps2(self) -> float:
        """The largest acceleration that the friction gives [m/s^2]."""
        return self.friction * GRAVITY_MPS2

    @property
    def left_edge_m(self) -> float:
        """d of the left edge of the drivable surface [m], where that is farthest."""
        if self.borders is not None:
            return float(self.borders.edges.table[1].max())
        return (self.lanes_left + 0.5) * self.lane_width_m + self.shoulder_left_m

    @property
    def right_edge_m(self) -> float:
        """d of the right edge of the drivable surface [m], where that is farthest; negative."""
        if self.borders is not None:
            return float(self.borders.edges.table[2].min())
        return -(self.lanes_right + 0.5) * self.lane_width_m - self.shoulder_right_m

    @property
    def edges(self) -> Edges | None:
        """The edges along the road; None where they are the same all along."""
        return None if self.borders is None else self.borders.edges

    @property
    def steered_edges(self) -> Edges | None:
        """Edges for plans, nowhere outside `edges`, which a car can follow; None where they are the same all along."""
        return None if self.borders is None else self.borders.steered

    def left_edge_at(self, s_m: Array | float) -> Array | float:
        """d of the left edge [m] at s [m]; one number where it is the same all along."""
        return self.left_edge_m if self.borders is None else self.borders.edges.left(s_m)

    def right_edge_at(self, s_m: Array | float) -> Array | float:
        """d of the right edge [m] at s [m]; one number where it is the same all along."""
        return self.right_edge_m if self.borders is None else self.borders.edges.right(s_m)

    def curvature_at(self, s: Any) -> Array:
        """Curvature [1/m] of the reference line at s [m], of the shape of `s`."""
        return np.asarray(np.interp(s, *self.knots), dtype=np.float64)

    def seen_from(self, s_m: float) -> Road:
        """The same road with its s counted from `s_m`: the same record where that is 0."""
        return self if s_m == 0.0 else _seen_from(self, s_m)

    def lane_of(self, d_m: float, s_m: float) -> int:
        """Index of the lane that holds d at s: 0 the host's first lane, positive to the left; clipped to the lanes there are."""
        if self.borders is None:
            return math.floor(min(max(d_m / self.lane_width_m + 0.5, -self.lanes_right), self.lanes_left))
        borders = self.borders.at(s_m)
        beside = {lane.lane + self.lanes_right for lane in self.lanes if lane.shoulder}
        there = [k for k in range(len(borders) - 1) if borders[k + 1] - borders[k] > _NOTHING_M and k not in beside]
        inside = [k for k in there if d_m < borders[k + 1]]
        return (inside[0] if inside else there[-1] if there else self.lanes_right) - self.lanes_right

    def lane_centre_m(self, lane: int, s_m: float) -> float:
        """d of the middle of a lane [m] at s [m]."""
        if self.borders is None:
            return lane * self.lane_width_m
        right, left = self._lane_borders(lane, s_m)
        return 0.5 * (left + right)

    def lane_width_at(self, lane: int, s_m: float) -> float:
        """The width of a lane [m] at s [m]; 0 where there is none."""
        if self.borders is None:
            return self.lane_width_m
        right, left = self._lane_borders(lane, s_m)
        return left - right

    def has_lane(self, lane: int, from_s_m: float, until_s_m: float | None = None) -> bool:
        """Whether there is such a lane of the host's direction, open and of half the usual width at least, at s, or until then."""
        if not -self.lanes_right <= lane <= self.lanes_left:
            return False
        if self.borders is None:
            return True
        return self.lane_ends_m(lane, from_s_m, 0.5 * self.lane_width_m) > (from_s_m if until_s_m is None else until_s_m)

    def goes_on(self, lane: int, s_m: float, speed_mps: float) -> bool:
        """Whether there is such a lane beside a car that drives so fast, for as long as changing to it takes."""
        if self.borders is None:
            return self.has_lane(lane, s_m)
        return self.has_lane(lane, s_m + _SOON_S * speed_mps, s_m + _CHANGE_S * speed_mps)

    def leads_on(self, lane: int, s_m: float, speed_mps: float, width_m: float) -> bool:
        """Whether there is such a lane beside a car that drives so fast, which it would not have to leave soon."""
        if self.borders is None:
            return self.has_lane(lane, s_m)
        return self.goes_on(lane, s_m, speed_mps) and self.lane_ends_m(lane, s_m, width_m) > s_m + _LEFT_S * speed_mps

    def is_for_others(self, lane: int) -> bool:
        """Whether a lane is road, but none to drive in: one of oncoming traffic, or a shoulder."""
        return any(one.lane == lane and (one.oncoming or one.shoulder) for one in self.lanes)

    def lane_ends_m(self, lane: int, s_m: float, width_m: float) -> float:
        """How far a lane goes on from s: where it is first narrower than `width_m` or closed, infinite where it never is; not at all (minus
        infinity) where it is none to drive in."""
        if self.borders is None:
            return math.inf
        described = next((one for one in self.lanes if one.lane == lane), None)
        if described is None:
            return math.inf
        if described.oncoming or described.shoulder:
            return -math.inf
        return described.ends_m(s_m, width_m, self.lane_width_m)

    def ends_m(self, lane: int, s_m: float, width_m: float) -> float:
        """Where a car of this width that keeps its lane comes to an end from s on: of the lane or of the road; infinite without."""
        road_end = math.inf if self.road_end_s_m is None else self.road_end_s_m
        return road_end if self.borders is None else min(road_end, max(self.lane_ends_m(lane, s_m, width_m), s_m))

    def markings_at(self, s_m: Array) -> list[Array]:
        """d [m] of each border between two lanes at s (n,), from the right; NaN where one of the two is not there."""
        if self.borders is None:
            return [np.full(s_m.shape, (lane + 0.5) * self.lane_width_m) for lane in range(-self.lanes_right, self.lanes_left)]
        d = self.borders.along(s_m)
        there = np.diff(d, axis=0) > _NOTHING_M
        return [np.where(there[k] & there[k + 1], d[k + 1], np.nan) for k in range(len(there) - 1)]

    def limits_from(self, lane: int, s_m: float) -> list[tuple[float, float]]:
        """The speed limits of a lane from s on: (where it begins to hold [m], limit [m/s]), the first at `s_m`."""
        described = next((one.speed_limit_mps for one in self.lanes if one.lane == lane and one.speed_limit_mps), None)
        if described is None:
            return [(s_m, self.speed_limit_mps)]
        ahead = bisect_right(described, s_m, key=itemgetter(0))
        return [(s_m, described[max(ahead - 1, 0)][1]), *described[ahead:]]

    def limit_mps(self, lane: int, s_m: float, excess: float = 0.0) -> float:
        """The speed limit of a lane at s, or less where gentle braking from there on keeps one ahead; each exceeded by a share of it."""
        if not self.lanes:
            return (1.0 + excess) * self.speed_limit_mps
        least = math.inf
        for s, limit in self.limits_from(lane, s_m):
            lost = 2.0 * _EASING_MPS2 * (s - s_m)
            if lost >= least:  # by braking until there: no limit is as low
                break
            least = min(least, ((1.0 + excess) * limit) ** 2 + lost)
        return math.sqrt(least)

    def _lane_borders(self, lane: int, s_m: float) -> tuple[float, float]:
        """Right and left border d [m] of a lane at s; beyond the lanes that there are, a lane of the usual width further out."""
        assert self.borders is not None
        row = self.borders.at(s_m)
        k = lane + self.lanes_right
        if k < 0:
            return row[0] + k * self.lane_width_m, row[0] + (k + 1) * self.lane_width_m
        if k >= len(row) - 1:
            out = k - (len(row) - 1)
            return row[-1] + out * self.lane_width_m, row[-1] + (out + 1) * self.lane_width_m
        return row[k], row[k + 1]


@lru_cache(maxsize=64)
def _seen_from(road: Road, s_m: float) -> Road:
    """Not asked again whether it is sound: rounding there must not refuse what was accepted here."""
    moved, end = copy.copy(road), road.road_end_s_m
    if len(road.curvature) > 1:  # one knot is the same curvature everywhere
        object.__setattr__(moved, "curvature", tuple(zip((road.knots[0] - s_m).tolist(), road.knots[1].tolist(), strict=True)))
        moved._set_knots()
    object.__setattr__(moved, "road_end_s_m", None if end is None else end - s_m)
    object.__setattr__(moved, "lanes", tuple(lane.seen_from(s_m) for lane in road.lanes))
    object.__setattr__(moved, "borders", None if road.borders is None else road.borders.seen_from(s_m))
    return moved
