"""Everybody else on the lattice of times that starts and drives are looked at on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import PredictedBody, together
from mcdas_opt.domain.rules import Array
from mcdas_opt.manoeuvres.clearance import Margins

LATTICE_S = 0.02  # starts and times are multiples of it
TURNED_STEPS = 5  # of the lattice: so often bodies are looked at for how they are turned

Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictedTraffic:
    """Bodies on the lattice (J, N): places along and across the road, speeds along it, half sizes grown by margins.

    A body at an angle counts as the box around it, as it is turned at that time.
    """

    s_m: Array
    d_m: Array
    speed_mps: Array
    half_length_m: Array
    half_width_m: Array

    @classmethod
    def of(cls, bodies: Sequence[PredictedBody], until_s: float, margins: Margins) -> PredictedTraffic:
        times = lattice_s(round(until_s / LATTICE_S) + 1)
        motion = together(bodies, times)
        cosine, sine = _box(motion.heading_rad)
        sizes = np.array([(body.length_m, body.width_m) for body in bodies], dtype=np.float64).reshape(-1, 2)
        length, width, share = sizes[:, :1], sizes[:, 1:], margins.share_of_prediction
        half_length = 0.5 * (length + width * sine)
        half_width = 0.5 * (width * cosine + length * sine)
        if share:
            half_length += share * np.array([[np.max(body.margin_along_m(times))] for body in bodies]).reshape(-1, 1)
            half_width += share * np.array([[np.max(body.margin_across_m(times))] for body in bodies]).reshape(-1, 1)
        half_length += margins.along_m
        half_width += margins.across_m
        return cls(s_m=motion.s_m, d_m=motion.d_m, speed_mps=motion.speed_s_mps, half_length_m=half_length, half_width_m=half_width)


@lru_cache(maxsize=8)
def lattice_s(count: int) -> Array:
    """The first times of the lattice, which nobody can write into."""
    times = np.asarray(LATTICE_S * np.arange(count), dtype=np.float64)
    times.setflags(write=False)
    return times


def _box(heading_rad: Array) -> tuple[Array, Array]:
    """Cosine and sine (J, N) of angles no less than these: the greatest that there is from this time to the next that is looked at."""
    turned = np.abs(heading_rad)
    if not turned.any():
        return np.ones_like(turned), turned
    size = turned.shape[-1]
    few = np.maximum.reduceat(turned, np.arange(0, size, TURNED_STEPS), axis=-1)
    np.maximum(few[:, 1:], turned[:, TURNED_STEPS - 1 : -1 : TURNED_STEPS], out=few[:, 1:])
    cosine, sine = np.cos(few), np.sin(few)
    return np.repeat(cosine, TURNED_STEPS, axis=-1)[:, :size], np.repeat(sine, TURNED_STEPS, axis=-1)[:, :size]
