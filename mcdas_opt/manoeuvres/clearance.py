"""Members against predicted bodies: signed separations in the road's frame, exact rectangles only where bodies are near."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import BodyMotion, PredictedBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.rectangle import separation_of_poses
from mcdas_opt.manoeuvres.lane_change_profiles import Paths

Place = tuple[Array, ...]  # where a body is as seen from the host's centre, along and across the road [m], and both headings [rad]
NEAR_M = 1.5  # bodies farther apart than this along the road are not looked at more closely
BOW = 0.2  # times kappa and both lengths squared: how far a lane bows over the bodies (0.125), and that distances shrink with d


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
    members: Paths,
    times_s: Array,
    bodies: Sequence[PredictedBody],
    vehicle: Vehicle,
    road: Road,
    margins: Margins | None = None,
    parts: int = 0,
) -> Clearance:
    """How far the members stay from everybody at the times of the grid; `times_s` is (T,), or broadcasts with the members' (..., T).

    The separating-axis test on the axes of both rectangles, in the road's frame: on a bend distances along the road are those of the
    lane between the two, and the bend's bow over a car's length is taken off. With `parts` the separation at a time is one that is
    kept until the next: motion is taken to be linear between samples, and in each of so many parts of a step one axis must part the
    two at both ends, on the same side; one that is negative says only that there may be an overlap.
    """
    grown = margins or Margins()
    shape = members.s_m.shape
    best, who = np.full(shape, NEAR_M, dtype=members.s_m.dtype), np.full(shape, -1, dtype=np.intp)
    reach = 0.5 * np.hypot(vehicle.length_m, vehicle.width_m)
    bend = 0.0 if road.is_straight else BOW * max(abs(kappa) for _, kappa in road.curvature)
    host = [np.ravel(q) for q in (members.s_m, members.d_m, members.heading_rad)]
    index = np.broadcast_to(np.arange(times_s.size).reshape(times_s.shape), shape) if times_s.ndim > 1 else None
    for number, body in enumerate(bodies):
        motion = _in_precision_of(members.s_m, body.at(times_s))
        bow = bend * (body.length_m**2 + vehicle.length_m**2)
        long = _half(body.length_m, grown.along_m, grown.share_of_prediction, body.margin_along_m, times_s)
        wide = _half(body.width_m, grown.across_m, grown.share_of_prediction, body.margin_across_m, times_s)
        span = (reach + np.hypot(long, wide) + NEAR_M) * (2.0 if bow else 1.0)
        apart = np.abs(members.s_m - motion.s_m)
        close = apart < span
        if parts:  # a step counts when either end is near, or when it jumps over
            close[..., :-1] |= close[..., 1:] | ((members.s_m - motion.s_m)[..., :-1] * (members.s_m - motion.s_m)[..., 1:] < 0.0)
        near = np.flatnonzero(close)
        if not near.size:
            continue
        at = near % times_s.size if index is None else index.reshape(-1)[near]
        ends = [near]
        others = [at]
        if parts:
            last = near % shape[-1] == shape[-1] - 1
            ends.append(np.where(last, near, near + 1))
            others.append(np.where(last, at, at + 1))
        places = [_places(host, i, motion, k, road if bow else None) for i, k in zip(ends, others, strict=True)]
        gap = _parted(places, parts, 0.5 * vehicle.length_m, 0.5 * vehicle.width_m, long.reshape(-1)[at], wide.reshape(-1)[at]) - bow
        flat = best.reshape(-1)
        nearer = gap < flat[near]
        flat[near[nearer]] = gap[nearer]
        who.reshape(-1)[near[nearer]] = number
    return Clearance(separation_m=best, nearest=who)


def _in_precision_of(like: Array, motion: BodyMotion) -> BodyMotion:
    names = ("s_m", "d_m", "heading_rad", "speed_s_mps", "speed_d_mps")
    return BodyMotion(**{name: getattr(motion, name).astype(like.dtype, copy=False) for name in names})


def _half(size_m: float, margin_m: float, share: float, predicted: Callable[[Array], Array], times_s: Array) -> Array:
    """Half a grown size [m] at each time."""
    fixed = np.full(times_s.shape, 0.5 * size_m + margin_m, dtype=times_s.dtype)
    return fixed + (share * predicted(times_s)).astype(times_s.dtype) if share else fixed


def _places(host: list[Array], i: NDArray[np.intp], motion: BodyMotion, k: NDArray[np.intp], bent: Road | None) -> Place:
    s, d = motion.s_m.reshape(-1)[k], motion.d_m.reshape(-1)[k]
    x, y = s - host[0][i], d - host[1][i]
    if bent is not None:
        x = x * (1.0 - bent.curvature_at(s) * 0.5 * (d + host[1][i]))
    return x, y, host[2][i], motion.heading_rad.reshape(-1)[k]


def _parted(places: list[Place], parts: int, long: float, wide: float, other_long: Any, other_wide: Any) -> Array:
    """The separation at the first of the places; with a second one, a lower bound of it all the way there.

    Where both ends are farther apart than the bodies move in between, the lesser end less half of that way will do.
    """
    gap = _separation(places[0], (long, wide), (other_long, other_wide))
    if not parts:
        return gap
    begin, end = places
    gap = np.minimum(gap, _separation(end, (long, wide), (other_long, other_wide)))
    reach = long + np.max(other_long)
    moved = np.hypot(end[0] - begin[0], end[1] - begin[1]) + reach * (np.abs(end[2] - begin[2]) + np.abs(end[3] - begin[3]))
    doubtful = np.flatnonzero((gap > 0.0) & (gap < moved))
    gap = np.where(gap > 0.0, gap - 0.5 * moved, gap)
    begin, end = (tuple(q[doubtful] for q in place) for place in (begin, end))
    other_long, other_wide = other_long[doubtful], other_wide[doubtful]
    kept = np.full(doubtful.size, np.inf)
    before = _axes(begin, long, wide, other_long, other_wide)
    for part in range(1, parts + 1):
        place = tuple(a + part / parts * (b - a) for a, b in zip(begin, end, strict=True))
        after = _axes(place, long, wide, other_long, other_wide)
        kept = np.minimum(kept, np.maximum(np.minimum(before[0], after[0]), np.minimum(before[1], after[1])).max(0))
        before = after
    gap[doubtful] = kept
    return np.asarray(gap)


def _separation(place: Place, half: tuple[Any, Any], other_half: tuple[Any, Any]) -> Array:
    x, y, heading, other_heading = place
    return separation_of_poses(x, y, heading, other_heading, half, other_half)


def _axes(place: Place, long: float, wide: float, other_long: Any, other_wide: Any) -> tuple[Array, Array]:
    """Gaps (4, n) on the axes of both rectangles: with the body on the positive side of the host, and on the negative one."""
    x, y, heading, other_heading = place
    sine, cosine, other_sine, other_cosine = np.sin(heading), np.cos(heading), np.sin(other_heading), np.cos(other_heading)
    c, s = np.abs(cosine * other_cosine + sine * other_sine), np.abs(sine * other_cosine - cosine * other_sine)
    offset = np.stack([x * cosine + y * sine, y * cosine - x * sine, x * other_cosine + y * other_sine, y * other_cosine - x * other_sine])
    extent = np.stack(
        [
            long + other_long * c + other_wide * s,
            wide + other_long * s + other_wide * c,
            other_long + long * c + wide * s,
            other_wide + long * s + wide * c,
        ]
    )
    return offset - extent, -offset - extent
