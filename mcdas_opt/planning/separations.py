"""Signed separations of one rectangle's drives from others over time: every drive from every other, in C where there is a compiler."""

from __future__ import annotations

import ctypes
from functools import lru_cache

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.rectangle import separation_of_poses
from mcdas_opt.native.addresses import address
from mcdas_opt.native.kernels import c_text, library, wanted

Poses = tuple[Array, Array, Array]  # x, y and yaw, each (count, n): rows of times
_BUILDS = ("-O2 -ffp-contract=off -lm",)  # no fused operations: the same bits as the array operations


def separations(mine: Poses, others: Poses, half: tuple[float, float], other_half: Array) -> Array:
    """(mine, others, n): `separation_of_poses` at each of n times, of rectangles (half length, half width) and (others, 2) such halves.

    Sines and cosines are numpy's in both forms, so that both give the same bits.
    """
    x, y, yaw = mine
    its_x, its_y, its_yaw = others
    compiled = _built() if wanted() else None
    if compiled is None:
        away_x, away_y = its_x - x[:, None], its_y - y[:, None]
        return separation_of_poses(away_x, away_y, yaw[:, None], its_yaw, half, (other_half[:, :1], other_half[:, 1:]))
    return compiled((x, y, np.sin(yaw), np.cos(yaw)), (its_x, its_y, np.sin(its_yaw), np.cos(its_yaw)), half, other_half)


class _CompiledSeparations:
    def __init__(self, library: ctypes.CDLL) -> None:
        whole, pointer = ctypes.c_long, ctypes.c_void_p
        self._separations = library.mcdas_separations
        self._separations.restype = None
        self._separations.argtypes = [*[whole] * 3, *[pointer] * 11]

    def __call__(self, mine: tuple[Array, ...], others: tuple[Array, ...], half: tuple[float, float], other_half: Array) -> Array:
        mine, others = tuple(map(np.ascontiguousarray, mine)), tuple(map(np.ascontiguousarray, others))
        (count, n), many = mine[0].shape, len(others[0])
        apart, own, its = np.empty((count, many, n)), np.array(half), np.ascontiguousarray(other_half)
        self._separations(count, many, n, *map(address, (*mine, own, *others, its, apart)))
        return apart


def build_separations() -> None:
    """Builds now what the first call would build."""
    if wanted():
        _built()


@lru_cache(maxsize=1)
def _built() -> _CompiledSeparations | None:
    found = library([c_text("mcdas_opt.planning", "separations.c")], _BUILDS)
    return None if found is None else _CompiledSeparations(found)
