"""The road's Frenet frame against the plane."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array, finite, require_type, within

# of 1 - d kappa: nearer to a bend's centre nothing has a place or a speed along the road; of what is measured, from farther off
LEAST_STRETCH, LEAST_STRETCH_MEASURED = 0.1, 0.2
_STEP_M = 0.5
_LONGEST_M = 1e6  # of a table
_LOST_M = 0.01  # off the perpendicular: who is beyond the centre of a bend may be lost by Newton's method
_HALVINGS = 30
_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True, slots=True, kw_only=True)
class FrenetFrame:
    """Maps (s, d, psi relative to the road) to (x, y, yaw) and back; the identity on a straight road.

    The plane's origin and x axis are the road's at s = 0. Heading is the exact integral of the piecewise linear curvature, positions
    are Gauss quadratures of it (1e-10 m); inside [s_min, s_max] the reference line is tabulated, beyond it goes on straight:
    who must know how far away somebody out there is takes a longer piece.
    """

    road: Road
    s_min_m: float = -400.0
    s_max_m: float = 1600.0
    _table: Array = field(init=False, repr=False)  # (3, n): s, x, y of the reference line
    _s: Array = field(init=False, repr=False)
    _x: Array = field(init=False, repr=False)
    _y: Array = field(init=False, repr=False)
    _knots: Array = field(init=False, repr=False)  # (3, n): s, curvature, heading of the knots between which the line is tabulated
    _sharpening: Array = field(init=False, repr=False)  # (n,): how the curvature goes on from each knot [1/m^2]
    _addresses: tuple[int, int, int, int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_type("road", self.road, Road)
        within("s_max_m", finite("s_max_m", self.s_max_m, "m"), finite("s_min_m", self.s_min_m, "m"), self.s_min_m + _LONGEST_M, "m")
        self._tabulate()
        line, bends = self._table, self._knots
        object.__setattr__(self, "_addresses", (line.shape[1], line.ctypes.data, bends.shape[1], bends.ctypes.data))

    @usual_arithmetic
    def _tabulate(self) -> None:
        if self.road.is_straight:
            empty = np.zeros(0)
            for name in ("_s", "_x", "_y"):
                object.__setattr__(self, name, empty)
            for name in ("_table", "_knots"):
                object.__setattr__(self, name, np.zeros((3, 0)))
            object.__setattr__(self, "_sharpening", empty)
            return
        knots, kappa = self.road.knots
        heading = np.concatenate([[0.0], np.cumsum(0.5 * (kappa[1:] + kappa[:-1]) * np.diff(knots))])
        self._bend_between(np.array([knots, kappa, heading]))
        bends = np.array([knots, kappa, heading - self.road_heading(np.zeros(1))[0]])
        first = max(int(np.searchsorted(knots, self.s_min_m, side="right")) - 1, 0)
        self._bend_between(bends[:, first : int(np.searchsorted(knots, self.s_max_m)) + 1].copy())
        even = np.arange(self.s_min_m, self.s_max_m + _STEP_M, _STEP_M)
        s = np.union1d(even, np.concatenate([knots[(knots > self.s_min_m) & (knots < self.s_max_m)], [0.0]]))
        half = 0.5 * np.diff(s)
        nodes = s[:-1, None] + half[:, None] * (1.0 + _GAUSS_NODES)
        theta = self.road_heading(nodes)
        x = np.concatenate([[0.0], np.cumsum(half * (np.cos(theta) @ _GAUSS_WEIGHTS))])
        y = np.concatenate([[0.0], np.cumsum(half * (np.sin(theta) @ _GAUSS_WEIGHTS))])
        origin = int(np.searchsorted(s, 0.0))
        object.__setattr__(self, "_table", np.array([s, x - x[origin], y - y[origin]]))
        for name, row in zip(("_s", "_x", "_y"), self._table, strict=True):
            object.__setattr__(self, name, row)

    def _bend_between(self, knots: Array) -> None:
        object.__setattr__(self, "_knots", knots)
        object.__setattr__(self, "_sharpening", np.append(np.diff(knots[1]) / np.diff(knots[0]), 0.0))

    def road_heading(self, s: Array) -> Array:
        """Heading of the reference line [rad] at s [m], zero at s = 0."""
        s = np.asarray(s, dtype=np.float64)
        if self.road.is_straight:
            return np.zeros_like(s)
        ks, kk, headings = self._knots
        i = np.maximum(np.searchsorted(ks, s, side="right") - 1, 0)
        # beyond either end the curvature is held, so the integral goes on linearly
        way, begun = s - ks[i], kk[i]
        inside = headings[i] + 0.5 * (begun + (self._sharpening[i] * way + begun)) * way
        return np.asarray(np.where(s < ks[0], headings[0] + (s - ks[0]) * kk[0], inside))

    def addresses(self) -> tuple[int, int, int, int]:
        """What `frenet.h` reads, as arguments of a call: how many samples of the line and where their table lies (3, n: s, x, y), how many
        knots and where theirs lies (3, n: s, curvature, heading); nothing on a straight road. Valid as long as the frame lives.
        """
        return self._addresses

    def __reduce__(self) -> tuple[Any, ...]:
        """Made anew in another process: addresses do not travel."""
        return partial(FrenetFrame, road=self.road, s_min_m=self.s_min_m, s_max_m=self.s_max_m), ()

    def _line(self, s: Array) -> tuple[Array, Array, Array]:
        if s.size and (s.min() < self._s[0] or s.max() > self._s[-1]):
            there = np.clip(s, self._s[0], self._s[-1])
            x, y, theta = self._line(there)
            return x + (s - there) * np.cos(theta), y + (s - there) * np.sin(theta), theta
        i = np.clip(np.searchsorted(self._s, s, side="right") - 1, 0, self._s.size - 2)
        half = 0.5 * (s - self._s[i])
        theta = self.road_heading(self._s[i][..., None] + half[..., None] * (1.0 + _GAUSS_NODES))
        x = self._x[i] + half * (np.cos(theta) @ _GAUSS_WEIGHTS)
        y = self._y[i] + half * (np.sin(theta) @ _GAUSS_WEIGHTS)
        return x, y, self.road_heading(s)

    def _nearest(self, x: Array, y: Array, low_m: float, high_m: float, every: int = 8) -> Array:
        """s of the nearest of every so many tabulated points from `low_m` to `high_m`."""
        coarse = slice(int(np.searchsorted(self._s, low_m)), int(np.searchsorted(self._s, high_m)), every)
        distance = (x[..., None] - self._x[coarse]) ** 2 + (y[..., None] - self._y[coarse]) ** 2
        return np.asarray(self._s[coarse][np.argmin(distance, axis=-1)])

    def _halved(self, x: Array, y: Array, low_m: float, high_m: float) -> Array:
        """s of the nearest tabulated point, and from there of the foot of the perpendicular beside it, by halving."""
        nearest = self._nearest(x, y, low_m, high_m, every=1)
        low, high = (np.clip(nearest + side * _STEP_M, self._s[0], self._s[-1]) for side in (-1.0, 1.0))
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            px, py, theta = self._line(middle)
            before = (x - px) * np.cos(theta) + (y - py) * np.sin(theta) > 0.0
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        return 0.5 * (low + high)

    def to_plane(self, s: Array, d: Array, psi: Array) -> tuple[Array, Array, Array]:
        """(x, y, yaw) of (s, d, psi); arrays of one shape."""
        s, d, psi = (np.asarray(q, dtype=np.float64) for q in (s, d, psi))
        if self.road.is_straight:
            return s, d, psi
        x, y, theta = self._line(s)
        return x - d * np.sin(theta), y + d * np.cos(theta), psi + theta

    def to_road(
        self, x: Array, y: Array, yaw: Array, near_s_m: float | None = None, guess_s_m: Array | None = None
    ) -> tuple[Array, Array, Array]:
        """(s, d, psi) of (x, y, yaw), by Newton's method on the foot of the perpendicular from the nearest tabulated point, or by halving.

        With `near_s_m` only the road within 300 m of it is searched (a road that turns full circle passes a point twice); with
        `guess_s_m` (of the shape of x) nothing is searched and Newton's method begins there.
        """
        x, y, yaw = (np.asarray(q, dtype=np.float64) for q in (x, y, yaw))
        if self.road.is_straight:
            return x, y, yaw
        low_m, high_m = (self._s[0], self._s[-1]) if near_s_m is None else (near_s_m - 300.0, near_s_m + 300.0)
        s = self._nearest(x, y, low_m, high_m) if guess_s_m is None else np.clip(guess_s_m, self._s[0], self._s[-1])
        for _ in range(12):
            px, py, theta = self._line(s)
            along = (x - px) * np.cos(theta) + (y - py) * np.sin(theta)
            across = -(x - px) * np.sin(theta) + (y - py) * np.cos(theta)
            before = s
            s = np.clip(s + along / np.maximum(1.0 - across * self.road.curvature_at(s), LEAST_STRETCH), self._s[0], self._s[-1])
            if np.abs(s - before).max(initial=0.0) < 1e-12:
                break
        px, py, theta = self._line(s)
        off = np.abs((x - px) * np.cos(theta) + (y - py) * np.sin(theta))
        lost = (off > _LOST_M) & (s > self._s[0]) & (s < self._s[-1])
        if lost.any():
            s = np.array(s)
            s[lost] = self._halved(x[lost], y[lost], low_m, high_m)
            px, py, theta = self._line(s)
        d = -(x - px) * np.sin(theta) + (y - py) * np.cos(theta)
        return s, d, np.arctan2(np.sin(yaw - theta), np.cos(yaw - theta))
