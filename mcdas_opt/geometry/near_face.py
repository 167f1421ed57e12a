"""Where the line of sight meets a body: a radar point against the body's centre.

A radar point is taken to lie where the line of sight to the body's centre enters the rectangle: on the rear bumper of a car ahead,
the front bumper of one behind, the flank of one alongside, and without a jump in between. The point then has the centre's azimuth,
and its range plus the half extent in that direction is the centre's range.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array

_TINY = 1e-12


def half_extent(bearing: Any, length: Any, width: Any) -> Array:
    """Centre to edge [m] of a length x width rectangle in the direction `bearing` from its long axis; arrays broadcast."""
    along = 0.5 * length / np.maximum(np.abs(np.cos(bearing)), _TINY)
    across = 0.5 * width / np.maximum(np.abs(np.sin(bearing)), _TINY)
    return np.asarray(np.minimum(along, across))


def half_extent_and_slope(bearing: float, length: float, width: float) -> tuple[float, float]:
    """`half_extent` of one bearing [m], and its derivative by it [m/rad]: e tan(bearing) on a bumper, -e / tan(bearing) on a flank."""
    c, s = math.cos(bearing), math.sin(bearing)
    if width * abs(c) >= length * abs(s):
        extent = 0.5 * length / abs(c)
        return extent, extent * s / c
    extent = 0.5 * width / abs(s)
    return extent, -extent * c / s
