"""A polyline as a road's reference line: of piecewise linear curvature, stretch by stretch, however long it is."""

from __future__ import annotations

import math

import numpy as np

from mcdas_opt.domain.lane import Knots
from mcdas_opt.domain.rules import Array
from mcdas_opt.interop.commonroad.lane_line import Placement
from mcdas_opt.interop.sumo.polylines import stations_m

_KNOT_M, _SAMPLE_M = 2.5, 0.5
_INSIDE = round(_KNOT_M / _SAMPLE_M)  # samples between two knots
_FITTED, _KEPT = 40, 24  # knots of a window that are fitted, and of these those that stay: the others look ahead
_SMOOTH = (100.0, 10.0, 1.0, 0.3)  # weights of the curvature's second difference (times the knot spacing) against metres beside the points:
_NEAR_M = 0.1  # the first whose line stays so near them, else the last
_TIGHTEST_M = 6.0  # of a radius: what a car can follow
_STRAIGHT_M, _STRAIGHT_1PM = 0.02, 1e-4  # a line that goes straight on stays so near, from no more curvature than this
_SPREAD = 2  # knots to either side over which a first guess takes the mean of the points' curvature
_LONGER = 1.5  # than the points, at most
_STEPS, _SETTLED_1PM = 8, 1e-5  # Gauss-Newton steps at most of one window, and a step after which it is settled


def line_along(points: Array, right_m: float, left_m: float) -> tuple[Placement, Knots]:
    """The line along points (n, 2), a metre or so apart, from the first to the last. Its radius is no less than 6 m, than `right_m` where
    it bends to the right, and than `left_m` to the left.

    Window by window, each from where the last one ends: least squares over the curvature at the knots, of the distance beside the points.
    """
    along = stations_m(points)
    way = points[min(3, len(points) - 1)] - points[0]
    placement = Placement(x_m=float(points[0, 0]), y_m=float(points[0, 1]), yaw_rad=math.atan2(way[1], way[0]))
    bounds = (-1.0 / max(right_m, _TIGHTEST_M), 1.0 / max(left_m, _TIGHTEST_M))
    pose, station, s, kappa = (placement.x_m, placement.y_m, placement.yaw_rad), 0.0, 0.0, 0.0
    knots = [(-1.0, 0.0), (0.0, 0.0)]
    while (left := int((along[-1] - station) / _KNOT_M)) >= 1 and s < _LONGER * along[-1]:  # a line that goes in circles comes to no end
        window = _Window(points, along, pose, station, kappa, min(_FITTED, left))
        straight = window.straight() if abs(kappa) < _STRAIGHT_1PM else None
        bent = (window.fitted(bounds) if straight is None else straight)[: _KEPT if left > _FITTED else _FITTED]
        shown = range(bent.size) if straight is None else sorted({0, bent.size - 1})
        knots += [(s + _KNOT_M * (k + 1), float(bent[k])) for k in shown]
        pose, station = window.after(bent)
        s, kappa = s + _KNOT_M * bent.size, float(bent[-1])
    knots.append((s + _KNOT_M, 0.0))
    return placement, tuple(knots)


class _Window:
    """A stretch of `n` knots from a pose (x, y, heading) beside `station` of a polyline, with the curvature that the line has there."""

    def __init__(self, points: Array, along: Array, pose: tuple[float, float, float], station: float, kappa: float, n: int) -> None:
        self._points, self._along, self._pose, self._station, self._kappa = points, along, pose, station, kappa
        share = (np.arange(n * _INSIDE) + 0.5) / _INSIDE  # middles of the samples, in knots
        hats = np.maximum(1.0 - np.abs(share[:, None] - np.arange(n + 1)), 0.0)
        self._turned = (np.cumsum(hats, axis=0) - 0.5 * hats) * _SAMPLE_M  # heading at the middles, by the curvature at each knot

    @property
    def _n(self) -> int:
        return int(self._turned.shape[1]) - 1

    def straight(self) -> Array | None:
        """No curvature, where that stays with the points."""
        bent = np.zeros(self._n)
        return bent if float(np.abs(self._beside(bent)).max()) < _STRAIGHT_M else None

    def fitted(self, bounds: tuple[float, float]) -> Array:
        """The curvature at the knots after the first: as smooth as stays near the points."""
        begun = bent = np.clip(self._as_the_points_bend(), 0.99 * bounds[0], 0.99 * bounds[1])
        for smooth in _SMOOTH:
            bent = self._least_squares(smooth, begun, bounds)
            if float(np.abs(self._beside(bent)).max()) < _NEAR_M:
                break
        return bent

    def after(self, bent: Array) -> tuple[tuple[float, float, float], float]:
        """The pose at the last of these knots, and its station."""
        x, y, _ = self._line(bent)
        k = bent.size * _INSIDE - 1
        heading = self._pose[2] + _KNOT_M * (0.5 * self._kappa + float(bent[:-1].sum()) + 0.5 * float(bent[-1]))
        return (float(x[k]), float(y[k]), heading), float(self._feet(x, y)[1][k])

    def _line(self, bent: Array) -> tuple[Array, Array, Array]:
        """x and y after each sample, and the heading at its middle."""
        theta = self._pose[2] + self._turned[:, : bent.size + 1] @ np.concatenate([[self._kappa], bent])
        x, y = (np.asarray(_SAMPLE_M * np.cumsum(way)) for way in (np.cos(theta), np.sin(theta)))
        return self._pose[0] + x, self._pose[1] + y, theta

    def _at(self, stations: Array) -> Array:
        """(2, n) of the polyline."""
        return np.array([np.interp(stations, self._along, self._points[:, i]) for i in (0, 1)])

    def _feet(self, x: Array, y: Array) -> tuple[Array, Array]:
        """The polyline's directions (2, n) beside points of the line, and the stations there."""
        stations: Array = np.asarray(self._station + _SAMPLE_M * np.arange(1, x.size + 1))
        way = np.zeros((2, x.size))
        for _ in range(3):
            ahead = self._at(stations + 0.5) - self._at(stations - 0.5)
            way = ahead / np.asarray(np.maximum(np.hypot(*ahead), 1e-9))
            off = np.array([x, y]) - self._at(stations)
            stations = np.asarray(np.clip(stations + (way * off).sum(axis=0), self._along[0], self._along[-1]))
        return way, stations

    def _beside(self, bent: Array) -> Array:
        """How far the line lies to the left of the polyline, sample by sample."""
        x, y, _ = self._line(bent)
        way, stations = self._feet(x, y)
        px, py = self._at(stations)
        return np.asarray(way[0] * (y - py) - way[1] * (x - px))

    def _least_squares(self, smooth: float, bent: Array, bounds: tuple[float, float]) -> Array:
        """Gauss-Newton steps within the bounds of the curvature."""
        from scipy.optimize import lsq_linear

        bends = np.diff(np.eye(self._n + 1), 2, axis=0) * (smooth * _KNOT_M)
        for _ in range(_STEPS):
            x, y, theta = self._line(bent)
            way, _ = self._feet(x, y)
            dx, dy = (np.cumsum(turn[:, None] * self._turned[:, 1:], axis=0) * _SAMPLE_M for turn in (-np.sin(theta), np.cos(theta)))
            slopes = np.concatenate([way[0][:, None] * dy - way[1][:, None] * dx, bends[:, 1:]])
            misses = np.concatenate([self._beside(bent), bends @ np.concatenate([[self._kappa], bent])])
            before, bent = bent, lsq_linear(slopes, slopes @ bent - misses, bounds).x
            if float(np.abs(bent - before).max()) < _SETTLED_1PM:
                break
        return bent

    def _as_the_points_bend(self) -> Array:
        """The curvature of the polyline at the knots after the first, spread so that bounds take little from a turn."""
        dx, dy = np.diff(self._at(np.asarray(self._station + _KNOT_M * np.arange(-_SPREAD, self._n + _SPREAD + 2))))
        there = np.hypot(dx, dy) > 0.0  # before its beginning and after its end the polyline goes straight on
        heading = np.interp(np.arange(dx.size), np.flatnonzero(there), np.unwrap(np.arctan2(dy[there], dx[there])))
        over = 2 * _SPREAD + 1
        return np.asarray(np.convolve(np.diff(heading), np.full(over, 1.0 / over), mode="valid")[: self._n] / _KNOT_M)
