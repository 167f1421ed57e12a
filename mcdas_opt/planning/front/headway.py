"""The headway that is asked of the host: the settings', reached gradually from what it finds."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import HeadwaySettings
from mcdas_opt.native.library import library

ORDINARY_MPS2 = 2.0  # braking where nothing threatens, or behind a front car for whom it is enough
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

    In C where there is a compiler, with the same bits.
    """
    compiled = library()
    if compiled is None:
        return _interpreted(room_m, front_mps, speed_mps, times_s, headway, closing_s, since_s)
    room, front = np.ascontiguousarray(room_m), np.ascontiguousarray(front_mps)
    found = np.empty(room.shape)
    n = times_s.size
    compiled.mcdas_time_gaps(room.size // n, n, times_s, room, front, speed_mps, _numbers(headway), closing_s, since_s, found)
    return found


def _interpreted(
    room_m: Array, front_mps: Array, speed_mps: float, times_s: Array, headway: HeadwaySettings, closing_s: float, since_s: float
) -> Array:
    after = np.maximum(times_s - since_s, 0.0)
    slowest = np.where(times_s < since_s, speed_mps, np.clip(front_mps, 0.0, max(speed_mps, 0.0)))
    speed = np.maximum(speed_mps - headway.braking_mps2 * np.maximum(after - _BUILT_UP_S, 0.0), slowest)
    counted = np.maximum(speed, front_mps)  # a gap that a faster one opens is his
    gone = np.zeros_like(speed)
    gone[..., 1:] = np.cumsum(0.5 * (counted[..., 1:] + counted[..., :-1]) * (times_s[1:] - times_s[:-1]), axis=-1)
    free = room_m - gone - headway.standstill_m - closing_s * np.maximum(speed - front_mps, 0.0)
    found = np.maximum(free / np.maximum(speed, _SLOWEST_MPS), 0.0)
    return np.asarray(np.minimum(headway.time_gap_s, found + headway.opening * after * after / (after + _BEGINNING_S)))


def missing_headway(drives: Array, others: BodyMotion, halves_m: Array, host: HostState, headway: HeadwaySettings) -> Array:
    """(drives, n): the share that is missing of the front distance asked for, of drives as tables (drives, 9, n).

    `others` are motions as rows (J, n), J > 0; `halves_m` (J, 2) half of both bodies together, along and across. The distance opens from
    what is found behind whom the host follows; of whom it does not follow yet all of it is asked for at once.

    In C where there is a compiler, with the same bits.
    """
    compiled = library()
    if compiled is not None:
        rows = tuple(map(np.ascontiguousarray, (others.s_m, others.d_m, others.speed_s_mps)))
        (bodies, n), start = rows[0].shape, np.array((host.s_m, host.d_m, host.speed_mps))
        missing = np.empty((len(drives), n))
        work = np.empty((bodies, n))
        compiled.mcdas_missing_headway(len(drives), bodies, n, drives, start, halves_m, *rows, _numbers(headway), work, missing)
        return missing
    lengths, widths = halves_m.T[:, :, None]
    follows = np.abs(others.d_m[:, :1] - host.d_m) < widths
    found = asked_time_gap_s(others.s_m - host.s_m - lengths, others.speed_s_mps, host.speed_mps, drives[0, 0], headway)
    time_gap = np.where(follows, found, headway.time_gap_s)
    s, d, v = drives[:, 1, None], drives[:, 2, None], drives[:, 4, None]
    asked = headway.standstill_m + time_gap * np.maximum(v, 0.0)
    ahead = (np.abs(others.d_m - d) < widths) & (others.s_m > s)
    short = np.where(ahead, 1.0 - (others.s_m - s - lengths) / asked, 0.0)
    return np.asarray(np.clip(short, 0.0, 1.0).max(axis=1))


@lru_cache(maxsize=16)
def _numbers(headway: HeadwaySettings) -> Array:
    """The record `Headway` of the C text."""
    asked = headway.time_gap_s, headway.standstill_m, headway.opening
    return np.array((*asked, headway.braking_mps2, _BUILT_UP_S, _BEGINNING_S, _SLOWEST_MPS))
