"""Signed separations of one rectangle's drives from others over time: every drive from every other, in C where there is a compiler."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.rectangle import separation_of_poses
from mcdas_opt.native.library import library

Poses = tuple[Array, Array, Array]  # x, y and yaw, each (count, n): rows of times


def separations(mine: Poses, others: Poses, half: tuple[float, float], other_half: Array) -> Array:
    """(mine, others, n): `separation_of_poses` at each of n times, of rectangles (half length, half width) and (others, 2) such halves.

    Sines and cosines are numpy's in both forms, so that both give the same bits.
    """
    x, y, yaw = mine
    its_x, its_y, its_yaw = others
    compiled = library()
    if compiled is None:
        away_x, away_y = its_x - x[:, None], its_y - y[:, None]
        return separation_of_poses(away_x, away_y, yaw[:, None], its_yaw, half, (other_half[:, :1], other_half[:, 1:]))
    (count, n), many = x.shape, len(its_x)
    apart = np.empty((count, many, n))
    own = map(np.ascontiguousarray, (x, y, np.sin(yaw), np.cos(yaw), half))
    their = map(np.ascontiguousarray, (its_x, its_y, np.sin(its_yaw), np.cos(its_yaw), other_half))
    compiled.mcdas_separations(count, many, n, *own, *their, apart)
    return apart
