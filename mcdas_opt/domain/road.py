"""The road in its Frenet frame: s forward, d left, (0, 0) = the host's lane centre at the start."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from operator import itemgetter
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import FARTHEST_M, Array, finite, non_negative, positive, require, within
from mcdas_opt.errors import ParameterError

_STRETCH_M = 1000.0
# What a road can have: from a footpath to a square, from wet ice to a racing tyre on rubber and wings.
_LANE_WIDTHS_M = (0.1, 20.0)
_WIDEST_SHOULDER_M = 1000.0
_MOST_LANES = 100
NEAREST_KNOTS_M = 1e-6  # so that they stay apart wherever along the road one counts from
_FRICTIONS = (0.01, 10.0)
_SPEED_LIMITS_MPS = (0.1, 150.0)
_KAPPA_1PM = itemgetter(1)  # of a knot


def local_origin_m(s_m: float) -> float:
    """Where s = 0 lies for whoever works near `s_m`: the nearest whole kilometre. So numbers stay small wherever the car drives, and what
    is remembered of a road, or of the last solve, serves for that long."""
    return _STRETCH_M * round(s_m / _STRETCH_M) if math.isfinite(s_m) else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Road:
    """Lanes of one direction along a reference line of piecewise linear curvature.

    `curvature` holds knots (s [m], kappa [1/m]), linear in between and held at both ends; a left turn is positive.
    `friction` is what the reader of this record believes: the planner's belief in a `Situation`, the truth in the plant.
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

    def __post_init__(self) -> None:
        require(self, positive, "lane_width_m", "friction", "speed_limit_mps")
        require(self, non_negative, "shoulder_left_m", "shoulder_right_m")
        within("lane_width_m", self.lane_width_m, *_LANE_WIDTHS_M, "m")
        for name, value in (("lanes_left", self.lanes_left), ("lanes_right", self.lanes_right)):
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _MOST_LANES:
                raise ParameterError(name, value, f"must be a whole number, at least 0 and at most {_MOST_LANES}")
        within("shoulder_left_m", self.shoulder_left_m, 0.0, _WIDEST_SHOULDER_M, "m")
        within("shoulder_right_m", self.shoulder_right_m, 0.0, _WIDEST_SHOULDER_M, "m")
        within("friction", self.friction, *_FRICTIONS)
        within("speed_limit_mps", self.speed_limit_mps, *_SPEED_LIMITS_MPS, "m/s")
        if self.road_end_s_m is not None:
            within("road_end_s_m", self.road_end_s_m, -2.0 * FARTHEST_M, 2.0 * FARTHEST_M, "m")
        try:
            knots = tuple((finite("curvature", s), finite("curvature", k)) for s, k in self.curvature)
        except ParameterError:
            raise ParameterError("curvature", self.curvature, "must hold at least one finite [s_m, kappa_1pm] pair") from None
        except (TypeError, ValueError):
            raise ParameterError("curvature", self.curvature, "must be a list of [s_m, kappa_1pm] pairs") from None
        object.__setattr__(self, "curvature", knots)
        s = np.array([k[0] for k in knots])
        if not knots or not np.all(np.isfinite(knots)):
            raise ParameterError("curvature", self.curvature, "must hold at least one finite [s_m, kappa_1pm] pair")
        if max(abs(knots[0][0]), abs(knots[-1][0])) > 2.0 * FARTHEST_M:
            raise ParameterError("curvature", self.curvature, f"s_m of the knots must lie within {2.0 * FARTHEST_M:g} of 0", "m")
        if np.any(np.diff(s) < NEAREST_KNOTS_M):
            raise ParameterError("curvature", self.curvature, f"s_m of the knots must increase, by at least {NEAREST_KNOTS_M:g}", "m")
        widest = max(self.left_edge_m, -self.right_edge_m)
        if max(abs(k) for _, k in knots) * widest >= 0.9:
            raise ParameterError("curvature", self.curvature, "is too tight: the road would fold over itself", "1/m")

    @property
    def left_edge_m(self) -> float:
        """d of the left edge of the drivable surface [m]."""
        return (self.lanes_left + 0.5) * self.lane_width_m + self.shoulder_left_m

    @property
    def right_edge_m(self) -> float:
        """d of the right edge of the drivable surface [m], negative."""
        return -(self.lanes_right + 0.5) * self.lane_width_m - self.shoulder_right_m

    @property
    def is_straight(self) -> bool:
        return not any(map(_KAPPA_1PM, self.curvature))

    def curvature_at(self, s: Any) -> Array:
        """Curvature [1/m] of the reference line at s [m], of the shape of `s`."""
        knots = np.asarray(self.curvature)
        return np.asarray(np.interp(s, knots[:, 0], knots[:, 1]), dtype=np.float64)

    def lane_of(self, d_m: float) -> int:
        """Index of the lane that holds d: 0 the host's first lane, positive to the left; clipped to the lanes there are."""
        lane = math.floor(d_m / self.lane_width_m + 0.5)
        return min(max(lane, -self.lanes_right), self.lanes_left)

    def seen_from(self, s_m: float) -> Road:
        """The same road with its s counted from `s_m`: the same record where that is 0."""
        return self if s_m == 0.0 else _seen_from(self, s_m)

    def lane_centre_m(self, lane: int) -> float:
        return lane * self.lane_width_m

    def has_lane(self, lane: int) -> bool:
        return -self.lanes_right <= lane <= self.lanes_left


@lru_cache(maxsize=64)
def _seen_from(road: Road, s_m: float) -> Road:
    end = road.road_end_s_m
    knots = road.curvature
    if len(knots) > 1:  # one knot is the same curvature everywhere
        knots = tuple((s - s_m, kappa) for s, kappa in knots)
    return replace(road, curvature=knots, road_end_s_m=None if end is None else end - s_m)
