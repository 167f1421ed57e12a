"""Signed separations of one rectangle's drives from others over time: every drive from every other, in C where there is a compiler."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.rectangle import separation_of_poses
from mcdas_opt.native.library import library


class Rectangles(NamedTuple):
    """x, y, yaw, and the sine and cosine of that, each (count, n): rows of times; half length and half width (count, 2)."""

    x: Array
    y: Array
    yaw: Array
    sine: Array
    cosine: Array
    half: Array

    @classmethod
    def of(cls, x: Array, y: Array, yaw: Array, half: Array) -> Rectangles:
        """Sines and cosines are numpy's, whatever they are then used in."""
        return cls(*map(np.ascontiguousarray, (x, y, yaw, np.sin(yaw), np.cos(yaw), half)))


def separations(mine: Rectangles, others: Rectangles) -> Array:
    """(mine, others, n): `separation_of_poses` at each of n times, of drives that are all of the first one's size. The same bits in both
    forms."""
    compiled, half = library(), mine.half[0]
    if compiled is None:
        away_x, away_y = others.x - mine.x[:, None], others.y - mine.y[:, None]
        return separation_of_poses(away_x, away_y, mine.yaw[:, None], others.yaw, half.tolist(), (others.half[:, :1], others.half[:, 1:]))
    (count, n), many = mine.x.shape, len(others.x)
    apart = np.empty((count, many, n))
    own = mine.x, mine.y, mine.sine, mine.cosine, half
    compiled.mcdas_separations(count, many, n, *own, others.x, others.y, others.sine, others.cosine, others.half, apart)
    return apart
