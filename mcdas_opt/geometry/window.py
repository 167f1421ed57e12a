"""The piece of road around a place: a Frenet frame tabulated near s, however far the drive has gone."""

from __future__ import annotations

import math
from functools import lru_cache

from mcdas_opt.domain.road import Road
from mcdas_opt.geometry.frenet import FrenetFrame

_STRIDE_M = 500.0
REACH_M = 450.0  # a frame near s holds at least [s - REACH_M, s + REACH_M]


def frame_near(road: Road, s_m: float, reach_m: float = REACH_M) -> FrenetFrame:
    """The frame of `road` around `s_m`, for so much road either way at least. Frames of different places differ by a shift of the plane:
    compare within one only."""
    strides = max(math.ceil((reach_m - REACH_M) / _STRIDE_M), 0)
    return _frame(road, 0.0 if road.is_straight else round(s_m / _STRIDE_M) * _STRIDE_M, strides)


@lru_cache(maxsize=16)
def _frame(road: Road, middle: float, strides_more: int) -> FrenetFrame:
    reach = REACH_M + (0.5 + strides_more) * _STRIDE_M
    return FrenetFrame(road=road, s_min_m=middle - reach, s_max_m=middle + reach)
