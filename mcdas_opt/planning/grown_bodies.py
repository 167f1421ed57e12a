"""Neighbours' bodies as the optimiser keeps clear of them: grown by a clearance and by the uncertainty of their estimates."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from mcdas_opt.domain.prediction import CruisingBody, PredictedBody, all_cruise, margins_together
from mcdas_opt.domain.rules import Array
from mcdas_opt.native.addresses import address
from mcdas_opt.native.kernels import c_text, library, wanted

_BUILDS = ("-O2 -ffp-contract=off -fno-math-errno -lm",)  # no fused operations: the same bits as the array operations


def grown_bodies(bodies: Sequence[PredictedBody], times_s: Array, along_m: float, across_m: float) -> Array:
    """(bodies, 2, n): half of each along and across [m] at these times, with its clearance and its margins.

    In C where there is a compiler and all of them move in the one closed form, with the same bits as the array operations.
    """
    compiled = _built() if wanted() else None
    if compiled is not None and bodies and all_cruise(bodies):
        numbers = np.array([_numbers(body, along_m, across_m) for body in bodies])
        grown, times = np.empty((len(bodies), 2, times_s.size)), np.ascontiguousarray(times_s)
        compiled.mcdas_grown(len(bodies), times.size, address(times), address(numbers), address(grown))
        return grown
    sizes = np.array([(0.5 * body.length_m + along_m, 0.5 * body.width_m + across_m) for body in bodies]).reshape(-1, 2, 1)
    return np.asarray(sizes + np.array(margins_together(bodies, times_s)).swapaxes(0, 1))


def build_grown_bodies() -> None:
    """Builds now what the first call would build."""
    if wanted():
        _built()


@lru_cache(maxsize=1)
def _built() -> ctypes.CDLL | None:
    found = library([c_text("mcdas_opt.planning", "grown_bodies.c")], _BUILDS)
    if found is not None:
        whole, pointer = ctypes.c_long, ctypes.c_void_p
        found.mcdas_grown.restype, found.mcdas_grown.argtypes = None, [whole, whole, *[pointer] * 3]
    return found


def _numbers(body: CruisingBody, along_m: float, across_m: float) -> tuple[float, ...]:
    """The record `Grown` of the C text."""
    half = 0.5 * body.length_m + along_m, 0.5 * body.width_m + across_m
    (s, s_and_speed, _, _), (_, speed_s, _, _), (_, _, d, d_and_speed), (_, _, _, speed_d) = body.covariance.tolist()
    caps = body.cap_along_m, body.cap_across_m
    return *half, body.sigmas, body.growth_s, *caps, s, d, s_and_speed, d_and_speed, speed_s, speed_d
