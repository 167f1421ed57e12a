"""Roads and poses as the browser's scripts take them: coordinates of the plane, rounded, in plain lists."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.plotting.moments import View

_EVERY_M = 2.0  # between the points of a bent road's edges
_DASH_PERIOD_M = 9.0
_PLAN_EVERY = 2  # of a plan's samples
SIGMAS = 2.5


def rounded(values: Any, digits: int = 2) -> list[Any]:
    """Plain numbers of so many digits; what is not finite becomes None."""
    array = np.asarray(values, dtype=np.float64)
    is_finite = np.isfinite(array)
    with np.errstate(over="ignore"):
        plain = np.round(array, digits)
    plain = np.where(np.isfinite(plain), plain, array)  # what is so large has no such digits
    if not is_finite.all():
        plain = plain.astype(object)
        plain[~is_finite] = None
    numbers: list[Any] = plain.tolist()
    return numbers


def _pieces(d_m: Array) -> list[slice]:
    """Where numbers are, as slices of two at least."""
    there = np.concatenate([[False], np.isfinite(d_m), [False]])
    begins, ends = np.flatnonzero(there[1:] & ~there[:-1]), np.flatnonzero(~there[1:] & there[:-1])
    return [slice(begin, end) for begin, end in zip(begins.tolist(), ends.tolist(), strict=True) if end - begin > 1]


class Ground:
    """A road's plane between two places along it: every pose on it, and its edges and markings."""

    def __init__(self, road: Road, s_from_m: float, s_to_m: float) -> None:
        self.road = road
        low = math.floor(s_from_m / _DASH_PERIOD_M) * _DASH_PERIOD_M
        self.low_m, self.high_m = low, s_to_m
        self._frame = FrenetFrame(road=road, s_min_m=min(low, 0.0) - 10.0, s_max_m=max(s_to_m, 0.0) + 10.0)

    def place(self, s: Any, d: Any, psi: Any = 0.0) -> Array:
        """(n, 3): x, y, yaw of poses in the road's frame; what lies beyond this piece of road is put at its end."""
        s, d, psi = np.broadcast_arrays(*(np.atleast_1d(np.asarray(q, dtype=np.float64)) for q in (s, d, psi)))
        if not self.road.is_straight:
            s = np.clip(s, self.low_m, self.high_m)
        return np.stack(self._frame.to_plane(s, d, psi), axis=-1)

    def document(self) -> dict[str, Any]:
        """Edges, lane markings and the road's end as polylines; `low` and `high` are the d of the edges where it is straight."""
        road, low = self.road, self.low_m
        high = self.high_m if road.road_end_s_m is None else min(self.high_m, road.road_end_s_m)
        is_even = road.is_straight and road.edges is None
        s = np.array([low, high]) if is_even else np.append(np.arange(low, high, _EVERY_M), high)
        across = np.array([float(road.right_edge_at(high)), float(road.left_edge_at(high))])
        ends = self.place(high, across)[:, :2] if road.road_end_s_m is not None else None
        return {
            "left": rounded(self.place(s, road.left_edge_at(s))[:, :2]),
            "right": rounded(self.place(s, road.right_edge_at(s))[:, :2]),
            "marks": [rounded(self.place(s[piece], d[piece])[:, :2]) for d in road.markings_at(s) for piece in _pieces(d)],
            "end": None if ends is None or road.road_end_s_m is None or road.road_end_s_m > self.high_m else rounded(ends),
            "low": road.right_edge_m,
            "high": road.left_edge_m,
        }

    def track(self, track: Track) -> list[float]:
        """As `ellipse`."""
        return ellipse(self, track.s_m, track.d_m, track.speed_s_mps, track.speed_d_mps, track.covariance)


def ellipse(ground: Ground, s_m: float, d_m: float, speed_s_mps: float, speed_d_mps: float, covariance: Array) -> list[float]:
    """x, y, their speeds, and the ellipse of the position's uncertainty: semi-axes along and across it, its angle.

    `covariance` is 4 x 4 of (s, s speed, d, d speed).
    """
    ((x, y, yaw),) = ground.place(s_m, d_m)
    values, vectors = np.linalg.eigh(covariance[np.ix_([0, 2], [0, 2])])
    along, across = SIGMAS * np.sqrt(np.maximum(values[::-1], 0.0))
    angle = math.atan2(float(vectors[1, 1]), float(vectors[0, 1])) + yaw
    c, n = math.cos(yaw), math.sin(yaw)
    vx, vy = c * speed_s_mps - n * speed_d_mps, n * speed_s_mps + c * speed_d_mps
    return [round(float(q), 3) for q in (x, y, vx, vy, along, across, angle)]


def plan_path(ground: Ground, x: Trajectory) -> tuple[list[Any], list[Any]]:
    """A plan's path, every other sample, and where it is at every whole second."""
    known = np.flatnonzero(np.isfinite(x.s_m) & np.isfinite(x.d_m))
    marks = np.arange(1.0, float(x.t_s[-1]) + 1e-9)
    path = rounded(ground.place(x.s_m[known][::_PLAN_EVERY], x.d_m[known][::_PLAN_EVERY])[:, :2])
    return path, rounded(ground.place(np.interp(marks, x.t_s, x.s_m), np.interp(marks, x.t_s, x.d_m))[:, :2])


def view_document(view: View) -> dict[str, float]:
    return {"back": view.back_m, "ahead": view.ahead_m, "right": view.right_m, "left": view.left_m}


def chart(title: str, unit: str, low: float, high: float, limits: Sequence[tuple[float, str, bool]] = (), **more: Any) -> dict[str, Any]:
    """A chart over time from `low` to `high`; each limit is a value, a word, and whether it is a hard one."""
    return {"title": title, "unit": unit, "low": low, "high": high, "limits": [list(one) for one in limits], **more}


def line(t_s: Any, values: Any, colour: str, digits: int = 3) -> dict[str, Any]:
    """A quantity over time, for the `lines` of a chart."""
    return {"t": rounded(t_s, 3), "v": rounded(values, digits), "colour": colour}
