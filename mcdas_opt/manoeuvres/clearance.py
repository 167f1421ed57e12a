"""Members against predicted bodies: signed separations in the road's frame, exact rectangles only where bodies are near."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import BodyMotion, PredictedBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array, non_negative, require
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.rectangle import separation_of_poses
from mcdas_opt.manoeuvres.paths import Paths

NEAR_M = 1.5  # bodies farther apart than this along the road are not looked at more closely
BOW = 0.2  # times kappa and both lengths squared: how far a lane bows over the bodies (0.125), and that distances shrink with d


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """Bodies are grown by these [m] on each side, and by so much of the prediction's own margins."""

    along_m: float = 0.0
    across_m: float = 0.0
    share_of_prediction: float = 0.0

    def __post_init__(self) -> None:
        require(self, non_negative, "along_m", "across_m", "share_of_prediction", of="margins")


@dataclass(frozen=True, slots=True, kw_only=True)
class Clearance:
    """`separation_m` (..., T): of the nearest body, a lower bound, at most NEAR_M; `nearest` (..., T): its index, -1 for none near."""

    separation_m: Array
    nearest: NDArray[np.intp]


def clearance(
    members: Paths,
    times_s: Array,
    bodies: Sequence[PredictedBody],
    vehicle: Vehicle,
    road: Road,
    margins: Margins | None = None,
) -> Clearance:
    """How far the members stay from everybody at the times of the grid; `times_s` is (T,), or broadcasts with the members' (..., T).

    The separating-axis test on the axes of both rectangles, in the road's frame: on a bend distances along the road are those of the
    lane between the two, and the bend's bow over a car's length is taken off.
    """
    grown = margins or Margins()
    shape = members.s_m.shape
    best, who = np.full(shape, NEAR_M, dtype=members.s_m.dtype), np.full(shape, -1, dtype=np.intp)
    reach = 0.5 * np.hypot(vehicle.length_m, vehicle.width_m)
    bend = BOW * road.sharpest_1pm
    host = [np.ravel(q) for q in (members.s_m, members.d_m, members.heading_rad)]
    index = np.broadcast_to(np.arange(times_s.size).reshape(times_s.shape), shape) if times_s.ndim > 1 else None
    for number, body in enumerate(bodies):
        motion = _in_precision_of(members.s_m, body.at(times_s))
        bow = bend * (body.length_m**2 + vehicle.length_m**2)
        long = _half(body.length_m, grown.along_m, grown.share_of_prediction, body.margin_along_m, times_s)
        wide = _half(body.width_m, grown.across_m, grown.share_of_prediction, body.margin_across_m, times_s)
        span = (reach + np.hypot(long, wide) + NEAR_M) * (2.0 if bow else 1.0)
        near = np.flatnonzero(np.abs(members.s_m - motion.s_m) < span)
        if not near.size:
            continue
        at = near % times_s.size if index is None else index.reshape(-1)[near]
        x, y, heading, its_heading = _place(host, near, motion, at, road if bow else None)
        half, its_half = (0.5 * vehicle.length_m, 0.5 * vehicle.width_m), (long.reshape(-1)[at], wide.reshape(-1)[at])
        gap = separation_of_poses(x, y, heading, its_heading, half, its_half) - bow
        flat = best.reshape(-1)
        nearer = gap < flat[near]
        flat[near[nearer]] = gap[nearer]
        who.reshape(-1)[near[nearer]] = number
    return Clearance(separation_m=best, nearest=who)


def _in_precision_of(like: Array, motion: BodyMotion) -> BodyMotion:
    columns = (motion.s_m, motion.d_m, motion.heading_rad, motion.speed_s_mps, motion.speed_d_mps)
    s, d, heading, speed_s, speed_d = (column.astype(like.dtype, copy=False) for column in columns)
    return BodyMotion(s_m=s, d_m=d, heading_rad=heading, speed_s_mps=speed_s, speed_d_mps=speed_d)


def _half(size_m: float, margin_m: float, share: float, predicted: Callable[[Array], Array], times_s: Array) -> Array:
    """Half a grown size [m] at each time."""
    fixed = np.full(times_s.shape, 0.5 * size_m + margin_m, dtype=times_s.dtype)
    return fixed + (share * predicted(times_s)).astype(times_s.dtype) if share else fixed


def _place(
    host: list[Array], i: NDArray[np.intp], motion: BodyMotion, k: NDArray[np.intp], bent: Road | None
) -> tuple[Array, Array, Array, Array]:
    """Where a body is as seen from the host's centre, along and across the road [m], and both headings [rad]."""
    s, d = motion.s_m.reshape(-1)[k], motion.d_m.reshape(-1)[k]
    x, y = s - host[0][i], d - host[1][i]
    if bent is not None:
        x = x * (1.0 - bent.curvature_at(s) * 0.5 * (d + host[1][i]))
    return x, y, host[2][i], motion.heading_rad.reshape(-1)[k]
