"""Reeds-Shepp words for many poses at once: arcs of one radius and straight lines, both gears, that join two poses.

Source: Reeds and Shepp, Pacific J. Math. 145(2), 1990, section 8 (formulas 8.1-8.11, with the signs as corrected in later use).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.angles import wrapped

_HALF = 0.5 * np.pi
_Solved = tuple[Array, Array, Array]  # t, u, v; nan where the word does not exist


def _where(valid: NDArray[np.bool_], *parts: Array) -> _Solved:
    t, u, v = (np.where(valid, part, np.nan) for part in parts)
    return t, u, v


def _lsl(x: Array, y: Array, phi: Array) -> _Solved:
    a, b = x - np.sin(phi), y - 1.0 + np.cos(phi)
    t = np.arctan2(b, a)
    v = wrapped(phi - t)
    return _where((t >= 0.0) & (v >= 0.0), t, np.hypot(a, b), v)


def _lsr(x: Array, y: Array, phi: Array) -> _Solved:
    a, b = x + np.sin(phi), y - 1.0 - np.cos(phi)
    squared = a * a + b * b
    u = np.sqrt(np.maximum(squared - 4.0, 0.0))
    t = wrapped(np.arctan2(b, a) + np.arctan2(2.0, u))
    v = wrapped(t - phi)
    return _where((squared >= 4.0) & (t >= 0.0) & (v >= 0.0), t, u, v)


def _lrl(x: Array, y: Array, phi: Array) -> _Solved:
    a, b = x - np.sin(phi), y - 1.0 + np.cos(phi)
    rho = np.hypot(a, b)
    u = -2.0 * np.arcsin(np.minimum(0.25 * rho, 1.0))
    t = wrapped(np.arctan2(b, a) + 0.5 * u + np.pi)
    v = wrapped(phi - t + u)
    return _where((rho <= 4.0) & (t >= 0.0) & (u <= 0.0), t, u, v)


def _tau_omega(u: Array, v: Array, xi: Array, eta: Array, phi: Array) -> tuple[Array, Array]:
    delta = wrapped(u - v)
    a = np.sin(u) - np.sin(delta)
    b = np.cos(u) - np.cos(delta) - 1.0
    first = np.arctan2(eta * a - xi * b, xi * a + eta * b)
    flipped = 2.0 * (np.cos(delta) - np.cos(v) - np.cos(u)) + 3.0 < 0.0
    tau = wrapped(np.where(flipped, first + np.pi, first))
    return tau, wrapped(tau - u + v - phi)


def _lrlr_inner(x: Array, y: Array, phi: Array) -> _Solved:
    xi, eta = x + np.sin(phi), y - 1.0 - np.cos(phi)
    rho = 0.25 * (2.0 + np.hypot(xi, eta))
    u = np.arccos(np.minimum(rho, 1.0))
    t, v = _tau_omega(u, -u, xi, eta, phi)
    return _where((rho <= 1.0) & (t >= 0.0) & (v <= 0.0), t, u, v)


def _lrlr_outer(x: Array, y: Array, phi: Array) -> _Solved:
    xi, eta = x + np.sin(phi), y - 1.0 - np.cos(phi)
    rho = (20.0 - xi * xi - eta * eta) / 16.0
    u = -np.arccos(np.clip(rho, 0.0, 1.0))
    t, v = _tau_omega(u, u, xi, eta, phi)
    return _where((rho >= 0.0) & (rho <= 1.0) & (t >= 0.0) & (v >= 0.0), t, u, v)


def _lrsl(x: Array, y: Array, phi: Array) -> _Solved:
    xi, eta = x - np.sin(phi), y - 1.0 + np.cos(phi)
    rho = np.hypot(xi, eta)
    r = np.sqrt(np.maximum(rho * rho - 4.0, 0.0))
    u = 2.0 - r
    t = wrapped(np.arctan2(eta, xi) + np.arctan2(r, -2.0))
    v = wrapped(phi - _HALF - t)
    return _where((rho >= 2.0) & (t >= 0.0) & (u <= 0.0) & (v <= 0.0), t, u, v)


def _lrsr(x: Array, y: Array, phi: Array) -> _Solved:
    xi, eta = x + np.sin(phi), y - 1.0 - np.cos(phi)
    rho, t = np.hypot(xi, eta), np.arctan2(xi, -eta)
    u = 2.0 - rho
    v = wrapped(t + _HALF - phi)
    return _where((rho >= 2.0) & (t >= 0.0) & (u <= 0.0) & (v <= 0.0), t, u, v)


def _lrslr(x: Array, y: Array, phi: Array) -> _Solved:
    xi, eta = x + np.sin(phi), y - 1.0 - np.cos(phi)
    rho = np.hypot(xi, eta)
    u = 4.0 - np.sqrt(np.maximum(rho * rho - 4.0, 0.0))
    t = wrapped(np.arctan2((4.0 - u) * xi - 2.0 * eta, -2.0 * xi + (u - 4.0) * eta))
    v = wrapped(t - phi)
    return _where((rho >= 2.0) & (u <= 0.0) & (t >= 0.0) & (v >= 0.0), t, u, v)


def _plain(t: Array, u: Array, v: Array) -> list[Array]:
    return [t, u, v]


def _swapped(t: Array, u: Array, v: Array) -> list[Array]:
    return [v, u, t]


# formula, seen from the far end?, letters, how t, u, v become the lengths
_Family = tuple[Callable[[Array, Array, Array], _Solved], bool, str, Callable[[Array, Array, Array], list[Array]]]
_FAMILIES: tuple[_Family, ...] = (
    (_lsl, False, "LSL", _plain),
    (_lsr, False, "LSR", _plain),
    (_lrl, False, "LRL", _plain),
    (_lrl, True, "LRL", _swapped),
    (_lrlr_inner, False, "LRLR", lambda t, u, v: [t, u, -u, v]),
    (_lrlr_outer, False, "LRLR", lambda t, u, v: [t, u, u, v]),
    (_lrsl, False, "LRSL", lambda t, u, v: [t, np.full_like(t, -_HALF), u, v]),
    (_lrsr, False, "LRSR", lambda t, u, v: [t, np.full_like(t, -_HALF), u, v]),
    (_lrsl, True, "LSRL", lambda t, u, v: [v, u, np.full_like(t, -_HALF), t]),
    (_lrsr, True, "RSRL", lambda t, u, v: [v, u, np.full_like(t, -_HALF), t]),
    (_lrslr, False, "LRSLR", lambda t, u, v: [t, np.full_like(t, -_HALF), u, np.full_like(t, -_HALF), v]),
)
_TURN = {"L": 1.0, "S": 0.0, "R": -1.0}
WORD_TURNS: Array = np.array(
    [
        [mirror * _TURN[c] for c in letters] + [0.0] * (5 - len(letters))
        for _, _, letters, _ in _FAMILIES
        for mirror in (1.0, 1.0, -1.0, -1.0)
    ]
)


def reeds_shepp(start: Array, goal: Array, radius: float) -> Array:
    """(n, 44, 5) signed arc lengths [m] of every word from start (n, 3) to goal (n, 3) or (3,); nan where a word does not exist.

    `WORD_TURNS` (44, 5) holds each piece's turn: +1 left, 0 straight, -1 right.
    """
    start, goal = np.broadcast_arrays(np.atleast_2d(start), np.atleast_2d(goal))
    c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
    gx, gy = (goal[:, 0] - start[:, 0]) / radius, (goal[:, 1] - start[:, 1]) / radius
    x, y = c * gx + s * gy, -s * gx + c * gy
    phi = wrapped(goal[:, 2] - start[:, 2])
    flips, mirrors = np.array([1.0, -1.0, 1.0, -1.0])[:, None], np.array([1.0, 1.0, -1.0, -1.0])[:, None]
    xs, ys, phis = flips * x, mirrors * y, flips * mirrors * phi
    far_x = xs * np.cos(phis) + ys * np.sin(phis)
    far_y = xs * np.sin(phis) - ys * np.cos(phis)
    lengths = np.zeros((len(x), 4 * len(_FAMILIES), 5))
    with np.errstate(invalid="ignore"):
        for k, (formula, from_far, _, arrange) in enumerate(_FAMILIES):
            solved = formula(far_x, far_y, phis) if from_far else formula(xs, ys, phis)
            for piece, length in enumerate(arrange(*solved)):
                lengths[:, 4 * k : 4 * k + 4, piece] = np.where(np.isnan(solved[0]), np.nan, flips * length * radius).T
    return lengths
