"""Speed over time in one or two phases, jerk- and acceleration-limited, for many members at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle

SHARE = 0.98  # of the vehicle's jerk and top speed


@dataclass(frozen=True, slots=True, kw_only=True)
class Phases:
    """Accelerations [m/s^2] of the first phase, when it ends [s], and of the second; arrays of one shape (members)."""

    first_mps2: Array
    switch_s: Array
    then_mps2: Array

    def __getitem__(self, index: Any) -> Phases:
        return Phases(first_mps2=self.first_mps2[index], switch_s=self.switch_s[index], then_mps2=self.then_mps2[index])


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedHistory:
    """Acceleration [m/s^2], speed [m/s] and distance travelled [m] of the rear axle, (..., T): members by the times of an even grid."""

    acceleration_mps2: Array
    speed_mps: Array
    travelled_m: Array


def speed_history(phases: Phases, times_s: Array, speed_mps: Any, acceleration_mps2: Any, vehicle: Vehicle) -> SpeedHistory:
    """What the phases make of a car that has this speed and acceleration now (numbers, or arrays that broadcast with the phases).

    Acceleration is linear between the times of the even grid, ramped at most at the vehicle's jerk; the second phase begins when the
    first one has been reached, at the earliest. A car that has come to rest stands; one that comes to (0.98 of) top speed keeps it.
    The precision is that of the times.
    """
    rise, fall = SHARE * vehicle.jerk_max_mps3, SHARE * vehicle.jerk_min_mps3
    given = (phases.first_mps2, phases.then_mps2, phases.switch_s, speed_mps, acceleration_mps2)
    first, then, switch, v0, a0 = (np.asarray(q, dtype=times_s.dtype)[..., None] for q in given)
    change = first - a0
    reached = np.where(change >= 0.0, change / rise, change / fall)
    since = np.maximum(times_s - np.maximum(switch, reached), 0.0)
    a = a0 + _ramp(times_s, change, rise, fall) + _ramp(since, then - first, rise, fall)
    h = float(times_s[1] - times_s[0])
    v = _summed(a, v0, h)
    over = v > np.maximum(SHARE * vehicle.speed_max_mps, v0)
    if over.any():
        over = np.logical_or.accumulate(over, axis=-1)
        last = np.take_along_axis(a, np.maximum(over.argmax(-1) - 1, 0)[..., None], axis=-1)
        a = np.where(over, np.maximum(last + fall * h * np.cumsum(over, axis=-1), 0.0), a).astype(times_s.dtype)
        v = _summed(a, v0, h)
    standing = v <= 1e-6
    stepped = h * (v[..., :-1] + h * (2.0 * a[..., :-1] + a[..., 1:]) / 6.0)
    if standing.any():
        standing = np.logical_or.accumulate(standing, axis=-1)
        stopping = standing[..., 1:] & ~standing[..., :-1]
        last = np.minimum(0.5 * v[..., :-1] ** 2 / np.maximum(-a[..., :-1], 1e-3), h * np.maximum(v[..., :-1], 0.0))
        stepped = np.where(stopping, last, np.where(standing[..., 1:], 0.0, stepped))
        v, a = np.where(standing, 0.0, v), np.where(standing, 0.0, a)
    travelled = np.zeros_like(v)
    np.cumsum(stepped, axis=-1, out=travelled[..., 1:])
    return SpeedHistory(acceleration_mps2=a, speed_mps=v, travelled_m=travelled)


def _summed(a: Array, v0: Array, h: float) -> Array:
    """The speed (..., T) of an acceleration that is linear between samples."""
    v = np.empty_like(a)
    v[...] = v0
    v[..., 1:] += np.cumsum(0.5 * h * (a[..., 1:] + a[..., :-1]), axis=-1)
    return v


def _ramp(t: Array, change: Array, rise: float, fall: float) -> Array:
    """From 0 to `change` at the jerk `rise` (upwards) or `fall` (downwards)."""
    return np.asarray(np.where(change >= 0.0, np.minimum(rise * t, change), np.maximum(fall * t, change)))
