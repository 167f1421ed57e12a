"""Signed separations of the car's poses from the obstacles: `PolygonField.separation`, in C where there is a compiler."""

from __future__ import annotations

import ctypes
from functools import lru_cache

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body, PolygonField
from mcdas_opt.native.addresses import address
from mcdas_opt.native.kernels import c_text, library, wanted

_BUILDS = ("-O2 -ffp-contract=off -fno-math-errno -lm",)  # no fused operations: the same bits as the array operations


def separation(field: PolygonField, poses: Array, body: Body) -> Array:
    """(n, m) signed distance [m] of the body at poses (n, 3) to each of the field's m polygons.

    Sines and cosines are numpy's in both forms, so that both give the same bits.
    """
    compiled = _built() if wanted() else None
    return field.separation(poses, body) if compiled is None else compiled(field, poses, body, least=False)


def clearance(field: PolygonField, poses: Array, body: Body) -> Array:
    """(n,) least of the `separation`s; infinite without polygons."""
    compiled = _built() if wanted() else None
    return field.clearance(poses, body) if compiled is None else compiled(field, poses, body, least=True)


class _CompiledSeparation:
    def __init__(self, library: ctypes.CDLL) -> None:
        whole, pointer = ctypes.c_ssize_t, ctypes.c_void_p
        self._separation = library.mcdas_parking_separation
        self._separation.restype = None
        self._separation.argtypes = [whole, whole, whole, *[pointer] * 8]

    def __call__(self, field: PolygonField, poses: Array, body: Body, *, least: bool) -> Array:
        poses = np.ascontiguousarray(poses, dtype=np.float64)
        n, m, heading = len(poses), len(field.polygons), np.ascontiguousarray(poses[:, 2])
        arrays = (field.first, poses, np.cos(heading), np.sin(heading), np.array(body), body.corners, field.edges)
        apart = np.empty(n if least else (n, m))
        self._separation(n, m, least, *map(address, arrays), address(apart))
        return apart


@lru_cache(maxsize=1)
def _built() -> _CompiledSeparation | None:
    found = library([c_text("mcdas_opt.parking", "obstacle_separations.c")], _BUILDS)
    return None if found is None else _CompiledSeparation(found)
