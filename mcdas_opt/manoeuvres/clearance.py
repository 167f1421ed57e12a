"""Members against predicted bodies: signed separations in the road's frame, exact rectangles only where bodies are near."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import PredictedBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.manoeuvres.sidesteps import Ways

NEAR_M = 1.5  # bodies farther apart than this along the road are not looked at more closely
_ARM_M2 = 12.0  # half the square of the longest distance over which the road's bend is left out


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """Bodies are grown by these [m] on each side, and by so much of the prediction's own margins."""

    along_m: float = 0.0
    across_m: float = 0.0
    share_of_prediction: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Clearance:
    """`separation_m` (..., T): of the nearest body, a lower bound, at most NEAR_M; `nearest` (..., T): its index, -1 for none near."""

    separation_m: Array
    nearest: NDArray[np.intp]


def clearance(
    members: Ways, times_s: Array, bodies: Sequence[PredictedBody], vehicle: Vehicle, road: Road, margins: Margins | None = None
) -> Clearance:
    """How far the members stay from everybody at the times of the grid.

    The separating-axis test on the axes of both rectangles, in the road's frame: on a bend distances along the road are those of the
    lane between the two, and the bend's bow over a car's length is taken off.
    """
    grown = margins or Margins()
    best = np.full(members.s_m.shape, NEAR_M)
    who = np.full(members.s_m.shape, -1, dtype=np.intp)
    long, wide = 0.5 * vehicle.length_m, 0.5 * vehicle.width_m
    bow = 0.0 if road.is_straight else _ARM_M2 * max(abs(kappa) for _, kappa in road.curvature)
    reach = np.hypot(long, wide)
    flat_s, flat_d, flat_sine, flat_cosine = (np.ravel(q) for q in (members.s_m, members.d_m, members.sine, members.cosine))
    steps = times_s.size
    for index, body in enumerate(bodies):
        motion = body.at(times_s)
        half_long = 0.5 * body.length_m + grown.along_m + grown.share_of_prediction * body.margin_along_m(times_s)
        half_wide = 0.5 * body.width_m + grown.across_m + grown.share_of_prediction * body.margin_across_m(times_s)
        span = reach + np.hypot(half_long, half_wide) + NEAR_M + bow
        if bow:
            span = span * 2.0
        near = np.flatnonzero(np.abs(members.s_m - motion.s_m) < span)
        if not near.size:
            continue
        k = near % steps
        x, y = motion.s_m[k] - flat_s[near], motion.d_m[k] - flat_d[near]
        if bow:
            x = x * (1.0 - road.curvature_at(motion.s_m[k]) * 0.5 * (motion.d_m[k] + flat_d[near]))
        gap = _separation(x, y, flat_sine[near], flat_cosine[near], long, wide, motion.heading_rad[k], half_long[k], half_wide[k])
        if bow:
            gap -= bow
        flat = best.reshape(-1)
        nearer = gap < flat[near]
        at = near[nearer]
        flat[at] = gap[nearer]
        who.reshape(-1)[at] = index
    return Clearance(separation_m=best, nearest=who)


def _separation(
    x: Array, y: Array, sine: Array, cosine: Array, long: float, wide: float, heading: Array, other_long: Any, other_wide: Any
) -> Array:
    """Signed separation of the host's rectangle from others' whose centres lie (x, y) from its own; the largest gap of four axes."""
    other_sine, other_cosine = np.sin(heading), np.cos(heading)
    # sine and cosine of the angle between the two
    c, s = np.abs(cosine * other_cosine + sine * other_sine), np.abs(sine * other_cosine - cosine * other_sine)
    ahead = np.abs(x * cosine + y * sine) - (long + other_long * c + other_wide * s)
    aside = np.abs(y * cosine - x * sine) - (wide + other_long * s + other_wide * c)
    other_ahead = np.abs(x * other_cosine + y * other_sine) - (other_long + long * c + wide * s)
    other_aside = np.abs(y * other_cosine - x * other_sine) - (other_wide + long * s + wide * c)
    return np.asarray(np.maximum(np.maximum(ahead, aside), np.maximum(other_ahead, other_aside)))
