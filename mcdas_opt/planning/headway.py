"""The headway that is asked of the host: the settings', reached gradually from what it finds."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import HeadwaySettings

ORDINARY_MPS2 = 2.0  # braking behind a front car, where that is enough
INTRUSION_M = 0.2  # a body that reaches further than this into a lane is in it
_GENTLE_MPS2 = 1.2  # what is asked for leaves room to brake by so much
_BUILT_UP_S = 1.0  # until braking counts: it begins with a comfortable jerk
_BEGINNING_S = 1.5  # until a gap opens at its full rate
_SLOWEST_MPS = 1.0  # time gaps are those of at least this speed


def asked_time_gap_s(
    room_m: Array,
    front_mps: Array,
    speed_mps: float,
    times_s: Array,
    headway: HeadwaySettings,
    *,
    closing_s: float = 0.0,
    since_s: float = 0.0,
) -> Array:
    """The time gap [s] to keep at each of the times: what a host finds that brakes gently from `since_s` on, opening from there.

    `room_m` (..., n) is how far the host's centre may go up to the front car, counted from where it is now; `front_mps` that car's speed.
    `closing_s` times the closing speed is kept free besides. Where braking gently does not do, nothing is asked for but that.
    """
    after = np.maximum(times_s - since_s, 0.0)
    slowest = np.where(times_s < since_s, speed_mps, np.clip(front_mps, 0.0, max(speed_mps, 0.0)))
    speed = np.maximum(speed_mps - _GENTLE_MPS2 * np.maximum(after - _BUILT_UP_S, 0.0), slowest)
    counted = np.maximum(speed, np.broadcast_to(front_mps, speed.shape))  # a gap that a faster one opens is his
    gone = np.zeros_like(speed)
    gone[..., 1:] = np.cumsum(0.5 * (counted[..., 1:] + counted[..., :-1]) * (times_s[1:] - times_s[:-1]), axis=-1)
    free = room_m - gone - headway.standstill_m - closing_s * np.maximum(speed - front_mps, 0.0)
    found = np.maximum(free / np.maximum(speed, _SLOWEST_MPS), 0.0)
    return np.asarray(np.minimum(headway.time_gap_s, found + headway.opening * after * after / (after + _BEGINNING_S)))
