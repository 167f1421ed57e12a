"""Middles of lanes as polylines (n, 2) in SUMO's plane: how long they are, beside one another, one after the other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from mcdas_opt.domain.rules import Array

_SAMPLE_M = 1.0
_OVERLAP_M = 10.0  # of two lanes, the one leading to the other, at most


def stations_m(shape: Array) -> Array:
    """Of its points, from the first on (n,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(shape, axis=0).T))])


def length_m(shape: Array) -> float:
    return float(np.hypot(*np.diff(shape, axis=0).T).sum())


def shifted(shape: Array, right_m: float | Array) -> Array:
    """The polyline moved to its right: by as much everywhere, or by (n, 1) point by point."""
    if not np.any(right_m):
        return shape
    way = np.gradient(shape, axis=0)
    way /= np.maximum(np.hypot(*way.T), 1e-9)[:, None]
    return np.asarray(shape + right_m * np.column_stack([way[:, 1], -way[:, 0]]))


def led_over(pieces: Sequence[Array], left_m: float) -> list[Array]:
    """The same polylines, one after the other, with a way over: the last begins `left_m` to the left of where those before come to. The
    first begins where it did, and the last ends so."""
    sampled = [even([piece]) for piece in pieces]
    ends_m = np.cumsum([length_m(piece) for piece in sampled])
    led = []
    for piece, end_m in zip(sampled, ends_m, strict=True):
        share = (end_m - length_m(piece) + stations_m(piece)) / ends_m[-1]
        over_m = left_m * (0.5 - 0.5 * np.cos(np.pi * share))
        led.append(shifted(piece, ((left_m if piece is sampled[-1] else 0.0) - over_m)[:, None]))
    return led


def even(pieces: Iterable[Array]) -> Array:
    """A point every metre along polylines, one after the other. Where one begins before the end of that before it, its beginning is left
    out."""
    kept: list[Array] = []
    for piece in pieces:
        overlaps = len(kept) > 1
        for point in piece:
            step = point - kept[-1] if kept else np.ones(2)
            far_m = float(np.hypot(*step))
            overlaps = overlaps and far_m < _OVERLAP_M and float(step @ (kept[-1] - kept[-2])) <= 0.0
            if far_m > 0.05 and not overlaps:
                kept.append(point)
    line = np.array(kept)
    along = stations_m(line)
    at = np.linspace(0.0, along[-1], max(round(along[-1] / _SAMPLE_M), 8) + 1)
    return np.column_stack([np.interp(at, along, line[:, i]) for i in (0, 1)])
