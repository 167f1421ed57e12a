"""A lane's centre line as our road: a line of piecewise linear curvature that follows a polyline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.rules import Array

AHEAD_M, BEHIND_M = 400.0, 100.0
_KNOT_M, _SAMPLE_M = 5.0, 1.0
_SMOOTH = 1.0  # weight of the curvature's second difference (times the knot spacing) against metres off the line
_MOST = 0.2  # [1/m], a radius of 5 m


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """Where our road frame lies in the plane: the origin and direction of its reference line at s = 0."""

    x_m: float
    y_m: float
    yaw_rad: float

    def to_frame(self, x: Array, y: Array, yaw: Array) -> tuple[Array, Array, Array]:
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        dx, dy = np.asarray(x) - self.x_m, np.asarray(y) - self.y_m
        return c * dx + s * dy, -s * dx + c * dy, np.asarray(yaw) - self.yaw_rad

    def to_plane(self, x: Array, y: Array, yaw: Array) -> tuple[Array, Array, Array]:
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        return (
            self.x_m + c * np.asarray(x) - s * np.asarray(y),
            self.y_m + s * np.asarray(x) + c * np.asarray(y),
            np.asarray(yaw) + self.yaw_rad,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneLine:
    """`curvature` knots (s, kappa) from the foot of a point on; `off_m` is the largest distance of the fitted line from the polyline."""

    placement: Placement
    curvature: tuple[tuple[float, float], ...]
    off_m: float
    length_m: float  # of the whole polyline ahead of the origin


def fit(polyline: Array, origin: Array) -> LaneLine:
    """The line along `polyline` (n, 2) with s = 0 at the foot of `origin` (2,). Least squares over knots, heading and sideways shift.

    Followed from `BEHIND_M` to `AHEAD_M`; beyond, and beyond the polyline, the road goes straight on.
    """
    from scipy.optimize import least_squares

    along, points = _even(polyline)
    foot = int(np.argmin(np.hypot(*(points - origin).T)))
    s = along - along[foot]
    length = float(s[-1])
    near = (s >= -BEHIND_M) & (s <= AHEAD_M)
    s, points = s[near], points[near]
    foot = int(np.argmin(np.abs(s)))
    ahead = points[min(foot + 2, len(points) - 1)] - points[max(foot - 2, 0)]
    start = Placement(x_m=float(points[foot, 0]), y_m=float(points[foot, 1]), yaw_rad=float(np.arctan2(ahead[1], ahead[0])))
    x, y, _ = start.to_frame(points[:, 0], points[:, 1], np.zeros(len(points)))
    knots = np.linspace(s[0], s[-1], max(round((s[-1] - s[0]) / _KNOT_M), 1) + 1)
    heading = np.unwrap(np.arctan2(np.gradient(y, s), np.gradient(x, s)))
    bent = np.interp(knots, s, np.gradient(_smooth(heading), s))

    def line(z: Array) -> tuple[Array, Array]:
        kappa = np.interp(s, knots, z[:-2])
        theta = _from(np.concatenate([[0.0], np.cumsum(0.5 * (kappa[1:] + kappa[:-1]) * np.diff(s))]), foot) + z[-2]
        middle = theta[:-1] + 0.5 * np.diff(theta)
        step = np.diff(s)
        return (
            _from(np.concatenate([[0.0], np.cumsum(step * np.cos(middle))]), foot) - z[-1] * np.sin(z[-2]),
            _from(np.concatenate([[0.0], np.cumsum(step * np.sin(middle))]), foot) + z[-1] * np.cos(z[-2]),
        )

    def misses(z: Array) -> Array:
        px, py = line(z)
        return np.concatenate([px - x, py - y, _SMOOTH * _KNOT_M * np.diff(z[:-2], 2)])

    most = np.concatenate([np.full(knots.size, _MOST), [0.5, 1.0]])
    begun = np.clip(np.concatenate([bent, [0.0, 0.0]]), -0.99 * most, 0.99 * most)
    z = least_squares(misses, begun, bounds=(-most, most), max_nfev=25).x
    px, py = line(z)
    shift, turn = float(z[-1]), float(z[-2])
    origin_x, origin_y, yaw = start.to_plane(np.array(-shift * np.sin(turn)), np.array(shift * np.cos(turn)), np.array(turn))
    pairs = [(float(knots[0]) - 1.0, 0.0), *zip(knots.tolist(), z[:-2].tolist(), strict=True), (float(knots[-1]) + 1.0, 0.0)]
    return LaneLine(
        placement=Placement(x_m=float(origin_x), y_m=float(origin_y), yaw_rad=float(yaw)),
        curvature=tuple(pairs),
        off_m=_off(np.column_stack([px, py]), np.column_stack([x, y])),
        length_m=length,
    )


def _even(polyline: Array) -> tuple[Array, Array]:
    """Arc length and points every metre, repeated points left out."""
    step = np.hypot(*np.diff(polyline, axis=0).T)
    kept = polyline[np.concatenate([[True], step > 1e-6])]
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(kept, axis=0).T))])
    even = np.linspace(0.0, along[-1], max(round(along[-1] / _SAMPLE_M), 8) + 1)
    return even, np.column_stack([np.interp(even, along, kept[:, i]) for i in (0, 1)])


def _from(values: Array, index: int) -> Array:
    return np.asarray(values - values[index])


def _smooth(values: Array) -> Array:
    window = min(9, len(values) // 2 * 2 - 1)
    padded = np.pad(values, window // 2, mode="reflect", reflect_type="odd")
    return np.asarray(np.convolve(padded, np.full(window, 1.0 / window), mode="valid"))


def _off(line: Array, points: Array) -> float:
    """Largest distance from a point to the nearest piece of the line."""
    a, b = line[:-1], line[1:]
    way = b - a
    share = np.einsum("pij,ij->pi", points[:, None] - a, way) / np.maximum(np.einsum("ij,ij->i", way, way), 1e-12)
    nearest = a + np.clip(share, 0.0, 1.0)[..., None] * way
    return float(np.hypot(*(points[:, None] - nearest).transpose(2, 0, 1)).min(axis=1).max())
