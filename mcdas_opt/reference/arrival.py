"""The speed that brings a car to its destination within its window, and at the speed that is asked for there."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.rules import Array
from mcdas_opt.reference.speed_profile import SpeedProfile

_SPARE_S = 0.5  # to be there earlier than at the last moment, and not before the first
_SHORTEST_S, _LONGEST_S = 0.1, 1e9  # left; more is any time
_RESPONSE_S = 0.3  # until an acceleration is built up
_BEGINS_S = 0.3  # who has to change its speed so soon begins now
_SPEEDS, _MOMENTS = 65, 25
_EVERY_M, _SLOWEST_MPS = 2.0, 0.5  # a way is timed in such steps, no slower than so
_TIMED_M = 20_000.0  # of a way that is timed in steps: what follows is driven as fast as its last one
_INSIDE_M = 0.5  # of the place that is asked for, kept from either end where they are so far apart
_INSIDE_MPS = 0.5  # the same of speeds


def arrival_speed_mps(
    destination: Destination,
    host: HostState,
    time_s: float,
    desired_mps: float,
    *,
    fastest_mps: float,
    rising_mps2: float,
    falling_mps2: float,
) -> float:
    """The speed to drive towards now: the nearest to the desired one, up to the fastest, that is there in time, and not before.

    The desired speed is held for as long as slowing down then, to the one that is asked for there or to a stop, brings the host there;
    where that is early, it waits there. Else another speed is reached at those rates, held, and left for the one that is asked for as late
    as that can be. As desired where nothing of this is asked for, and once the host is there.
    """
    if destination.s_m is None or host.s_m >= destination.s_m[1]:
        return desired_mps
    asked = destination.speed_mps
    spare_m = min(_INSIDE_M, 0.25 * (destination.s_m[1] - destination.s_m[0]))
    begin_m, end_m = destination.s_m[0] + spare_m - host.s_m, destination.s_m[1] - spare_m - host.s_m
    if destination.time_s is None:
        if asked is None:
            return desired_mps
        last = float(np.clip(desired_mps, *_inside(asked)))
        changing_m = (host.speed_mps**2 - last**2) / (2.0 * falling_mps2)
        return last if begin_m <= max(changing_m, 0.0) + _BEGINS_S * host.speed_mps else desired_mps
    early_s, late_s = (
        min(max(moment - time_s, _SHORTEST_S), _LONGEST_S)
        for moment in (destination.time_s[0] + _SPARE_S, destination.time_s[1] - _SPARE_S)
    )
    last = 0.0 if asked is None else float(np.clip(desired_mps, *_inside(asked)))
    if last < desired_mps:
        after_s = _slows_after_s(host.speed_mps, desired_mps, last, (early_s, late_s), (begin_m, end_m), rising_mps2, falling_mps2)
        if after_s is not None and (asked is None or after_s <= early_s - (desired_mps - last) / falling_mps2):
            return last if after_s <= _BEGINS_S else desired_mps
    speeds = np.linspace(0.0, max(fastest_mps, desired_mps), _SPEEDS)
    there = speeds if asked is None else np.clip(speeds, *_inside(asked))
    least = float(np.interp(max(begin_m, 0.0), _ways_m(speeds, there, host.speed_mps, late_s, rising_mps2, falling_mps2), speeds))
    most = float(np.interp(end_m, _ways_m(speeds, there, host.speed_mps, early_s, rising_mps2, falling_mps2), speeds))
    held = min(max(desired_mps, least), most) if least <= most else 0.5 * (least + most)
    if asked is None:
        return held
    last = float(np.clip(held, *_inside(asked)))
    rate = falling_mps2 if last < held else rising_mps2
    passes_s = 0.5 * (max(begin_m, 0.0) + end_m) / held if held > 0.0 else late_s
    asked_by_s = max(early_s, min(0.5 * (early_s + late_s), passes_s))
    return last if asked_by_s - abs(held - last) / rate <= _BEGINS_S else held


def comes_late(
    destination: Destination | None, host: HostState, time_s: float, profile: SpeedProfile, wanted_mps: float, rising_mps2: float
) -> bool:
    """Whether the destination's time is over before a host that drives as the profile allows, and gains speed at that rate, is at its
    place."""
    if destination is None or destination.s_m is None or destination.time_s is None or destination.s_m[0] <= host.s_m:
        return False
    left_m = destination.s_m[0] - host.s_m
    way_m = np.arange(0.5 * _EVERY_M, min(left_m, _TIMED_M), _EVERY_M)
    gained = 2.0 * rising_mps2 * way_m
    speeds = np.minimum(profile.at(host.s_m + way_m), np.sqrt(host.speed_mps**2 + gained))
    speeds = np.maximum(np.minimum(speeds, max(host.speed_mps, wanted_mps)), _SLOWEST_MPS)
    rest_s = (left_m - _TIMED_M) / float(speeds[-1]) if left_m > _TIMED_M else 0.0
    return float((_EVERY_M / speeds).sum()) + rest_s > destination.time_s[1] - time_s - _SPARE_S


def _inside(asked: tuple[float, float]) -> tuple[float, float]:
    """The speeds that are asked for without what lies next to either end."""
    spare = min(_INSIDE_MPS, 0.25 * (asked[1] - asked[0]))
    return max(asked[0] + spare, 0.0), max(asked[1] - spare, 0.0)


def _slows_after_s(
    begun_mps: float,
    desired_mps: float,
    last_mps: float,
    times_s: tuple[float, float],
    places_m: tuple[float, float],
    rising_mps2: float,
    falling_mps2: float,
) -> float | None:
    """How long the desired speed is held before the slower last one is gone to and held in turn; None where that is too fast or slow."""
    after = np.linspace(0.0, times_s[1], _SPEEDS)
    early, late = (
        _sum_m(_slowing(np.linspace(0.0, until, _MOMENTS), after, begun_mps, desired_mps, last_mps, rising_mps2, falling_mps2), until)
        for until in times_s
    )
    fits = np.flatnonzero((early <= places_m[1]) & (late >= places_m[0]))
    return float(after[fits[-1]]) if fits.size else None


def _slowing(
    t: Array, after: Array, begun_mps: float, desired_mps: float, last_mps: float, rising_mps2: float, falling_mps2: float
) -> Array:
    """(n, m): the speed at each time t (m,) of a car that goes to the desired speed, and after so long (n,) to the last one."""
    v = np.clip(desired_mps, begun_mps - falling_mps2 * t, begun_mps + rising_mps2 * t)
    return np.asarray(np.minimum(v, np.maximum(last_mps, desired_mps - falling_mps2 * (t - after[:, None] - _RESPONSE_S))))


def _sum_m(speeds: Array, within_s: float) -> Array:
    return np.asarray(0.5 * (speeds[:, 1:] + speeds[:, :-1]).sum(axis=1) * within_s / (speeds.shape[1] - 1))


def _ways_m(speeds: Array, there: Array, begun_mps: float, within_s: float, rising_mps2: float, falling_mps2: float) -> Array:
    """(n,): how far a car comes that goes from its speed to each of `speeds` (n,), holds it, and has the one of `there` (n,) in the end."""
    t = np.linspace(0.0, within_s, _MOMENTS)
    left = within_s - t
    v = np.minimum(speeds[:, None], there[:, None] + falling_mps2 * left)
    v = np.maximum(v, there[:, None] - rising_mps2 * left)
    v = np.minimum(v, begun_mps + rising_mps2 * np.maximum(t - _RESPONSE_S, 0.0))
    v = np.maximum(v, begun_mps - falling_mps2 * np.maximum(t - _RESPONSE_S, 0.0))
    return _sum_m(v, within_s)
