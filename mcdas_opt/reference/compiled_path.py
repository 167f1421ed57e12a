"""The search for the steepest bent path in C; `offset_path` says what it does, and does it itself where there is no compiler."""

from __future__ import annotations

import ctypes
from functools import lru_cache

from mcdas_opt.domain.rules import Array
from mcdas_opt.native.kernels import c_text, defined, library, wanted
from mcdas_opt.solvers.vector_math import BUILDS, DECLARED


class CompiledSearch:
    """`tables`: places along the path, the sigmoid there, places around the bend, the hump there, one behind the other."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self._sharpest = library.mcdas_sharpest
        self._sharpest.restype = ctypes.c_double
        self._sharpest.argtypes = [ctypes.c_void_p, *[ctypes.c_double] * 8]

    def __call__(
        self, tables: Array, low: float, high: float, bound: float, b: float, amplitude: float, bend: float, bend_x: float, width: float
    ) -> float:
        return float(self._sharpest(tables.ctypes.data, low, high, bound, b, amplitude, bend, bend_x, width))


def compiled_search(along: int, around: int, rounds: int, tried: int) -> CompiledSearch | None:
    """The search on so many places, in so many rounds of so many tries; None where there is no compiler, or it is forbidden."""
    return _built(along, around, rounds, tried) if wanted() else None


@lru_cache(maxsize=2)
def _built(along: int, around: int, rounds: int, tried: int) -> CompiledSearch | None:
    sizes = {"ALONG": along, "AROUND": around, "ROUNDS": rounds, "TRIED": tried}
    found = library([DECLARED, defined(sizes), c_text("mcdas_opt.reference", "sharpest_path.c")], BUILDS)
    return None if found is None else CompiledSearch(found)
