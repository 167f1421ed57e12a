"""The headway that is asked of the host: the settings', reached gradually from what is found."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import HeadwaySettings

_BEGINNING_S = 1.5  # until a gap opens at its full rate
_SLOWEST_MPS = 1.0  # time gaps are those of at least this speed


def found_time_gap_s(gap_m: Any, speed_mps: Any, headway: HeadwaySettings) -> Any:
    """The time gap [s] beyond the standstill distance; 0 where the gap is smaller than that. Arrays broadcast."""
    return np.maximum((gap_m - headway.standstill_m) / np.maximum(speed_mps, _SLOWEST_MPS), 0.0)


def asked_time_gap_s(found_s: Any, since_s: Array, headway: HeadwaySettings) -> Array:
    """The time gap [s] to keep so long after it was found: at once where it is there, else it opens. Arrays broadcast."""
    since = np.maximum(since_s, 0.0)
    return np.asarray(np.minimum(headway.time_gap_s, found_s + headway.opening * since * since / (since + _BEGINNING_S)))
