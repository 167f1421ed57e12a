"""Rows of manoeuvres against everybody at once: what they run into, and which gaps they need to begin in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import PredictedBody, together
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.manoeuvres.clearance import Margins
from mcdas_opt.manoeuvres.sidesteps import Starts
from mcdas_opt.time_to_react.evasive_profiles import Motions, Swerves, pace

LATTICE_S = 0.02  # starts and times are multiples of it
ROOM_SHARE = 0.95  # of the braking or accelerating that ends what still closes in at the end
NOWHERE_M = 1e4
HELD_STEPS = 2  # of the lattice: the host that keeps on is known so often
ARRIVED_M = 1.0  # who steps aside is so near to the middle of the next lane at the end: no longer in the old one
ABILITY_M = 10.0  # a share of the car's limits as a distance: only where it changes sign matters
STEP_REACH_M = 3.0  # more than bodies move against each other in a step
BOW = 0.2  # times kappa and both lengths squared: how far a lane bows over the bodies (0.125), and that distances shrink with d
TURNED_STEPS = 5  # of the lattice: so often bodies are looked at for how they are turned

Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class Company:
    """Everybody on the lattice (J, N): places along and across the road, speeds along it, half sizes grown by margins.

    A body at an angle counts as the box around it, as it is turned at that time.
    """

    s_m: Array
    d_m: Array
    speed_mps: Array
    half_length_m: Array
    half_width_m: Array

    @classmethod
    def of(cls, bodies: Sequence[PredictedBody], until_s: float, margins: Margins) -> Company:
        times = lattice_s(round(until_s / LATTICE_S) + 1)
        motion = together(bodies, times)
        cosine, sine = _box(motion.heading_rad)
        sizes = np.array([(body.length_m, body.width_m) for body in bodies], dtype=np.float64).reshape(-1, 2)
        length, width, share = sizes[:, :1], sizes[:, 1:], margins.share_of_prediction
        half_length = 0.5 * (length + width * sine)
        half_width = 0.5 * (width * cosine + length * sine)
        if share:
            half_length += share * np.array([[np.max(body.margin_along_m(times))] for body in bodies]).reshape(-1, 1)
            half_width += share * np.array([[np.max(body.margin_across_m(times))] for body in bodies]).reshape(-1, 1)
        half_length += margins.along_m
        half_width += margins.across_m
        return cls(s_m=motion.s_m, d_m=motion.d_m, speed_mps=motion.speed_s_mps, half_length_m=half_length, half_width_m=half_width)


@lru_cache(maxsize=8)
def lattice_s(count: int) -> Array:
    """The first times of the lattice, which nobody can write into."""
    times = np.asarray(LATTICE_S * np.arange(count), dtype=np.float64)
    times.setflags(write=False)
    return times


def _box(heading_rad: Array) -> tuple[Array, Array]:
    """Cosine and sine (J, N) of angles no less than these: the greatest that there is from this time to the next that is looked at."""
    turned = np.abs(heading_rad)
    if not turned.any():
        return np.ones_like(turned), turned
    size = turned.shape[-1]
    few = np.maximum.reduceat(turned, np.arange(0, size, TURNED_STEPS), axis=-1)
    np.maximum(few[:, 1:], turned[:, TURNED_STEPS - 1 : -1 : TURNED_STEPS], out=few[:, 1:])
    cosine, sine = np.cos(few), np.sin(few)
    return np.repeat(cosine, TURNED_STEPS, axis=-1)[:, :size], np.repeat(sine, TURNED_STEPS, axis=-1)[:, :size]


def touched(motions: Motions, clock: Rows, company: Company, vehicle: Vehicle, road: Road, clear_m: float) -> tuple[Rows, Rows]:
    """The step (R,) in which each row first has no more than `clear_m` left, and to whom; -1 without. `clock` (R, T): lattice indices.

    Rectangles on the axes of both, in the road's frame. Motion is linear within a step, and there the axes that part the two may
    take turns, but never leave a moment without one.
    """
    rows, steps = motions.s_m.shape[0], motions.s_m.shape[1] - 1
    count = company.s_m.shape[0]
    none = np.full(rows, -1, dtype=np.intp)
    if not count:
        return none, none
    apart = company.s_m[:, clock] - motions.s_m
    long, wide = 0.5 * vehicle.length_m, 0.5 * vehicle.width_m
    bend = 0.0 if road.is_straight else max(abs(kappa) for _, kappa in road.curvature)
    reach = (np.hypot(long, wide) + company.half_length_m.max(-1) + clear_m + STEP_REACH_M) * (2.0 if bend else 1.0)
    close = np.abs(apart) < reach[:, None, None]
    near = np.flatnonzero(close[..., :-1] | close[..., 1:])
    if not near.size:
        return none, none
    row, k = np.divmod(near % (rows * steps), steps)
    who = near // (rows * steps)
    at = row * (steps + 1) + k
    place = np.array([at, at + 1])
    x = apart.reshape(-1)[who * apart[0].size + place]
    across = motions.d_m.reshape(-1)[place]
    there = who * company.d_m.shape[1] + clock.reshape(-1)[place]
    other = company.d_m.reshape(-1)[there]
    length, width = (q.reshape(-1)[there].max(0) for q in (company.half_length_m, company.half_width_m))
    y = other - across
    sine, cosine = motions.sine.reshape(-1)[place], motions.cosine.reshape(-1)[place]
    kept_m = clear_m
    extra: Any = 0.0
    if bend:
        x = x * (1.0 - road.curvature_at(motions.s_m.reshape(-1)[place] + x) * 0.5 * (other + across))
        extra = BOW * bend * (4.0 * length**2 + vehicle.length_m**2)
    tilt = np.abs(sine)
    free = np.empty((8, *x.shape))
    for axis, (offset, extent) in enumerate(
        (
            (x, long * cosine + wide * tilt + length),
            (y, long * tilt + wide * cosine + width),
            (x * cosine + y * sine, length * cosine + width * tilt + long),
            (y * cosine - x * sine, length * tilt + width * cosine + wide),
        )
    ):
        extent += kept_m + extra
        np.subtract(offset, extent, out=free[2 * axis])
        np.subtract(-offset, extent, out=free[2 * axis + 1])
    doubtful = np.flatnonzero(np.minimum(free[:, 0], free[:, 1]).max(0) <= 0.0)
    hit = doubtful[~_handed_over(free[:, :, doubtful])]
    first = np.full(rows, steps * count, dtype=np.intp)
    np.minimum.at(first, row[hit], k[hit] * count + who[hit])
    met = first < steps * count
    return np.where(met, first // count, -1), np.where(met, first % count, -1)


def _handed_over(free: Array) -> NDArray[np.bool_]:
    """For steps that no single axis parts at both ends (8, 2, n): whether one parts the two until another one does."""
    begin, end = free[:, 0], free[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = begin / (begin - end)
    until = np.where(begin > 0.0, turn, -1.0).max(0)
    since = np.where(end > 0.0, turn, 2.0).min(0)
    return np.asarray(until > since)


def doomed(motions: Motions, clock: Rows, company: Company, vehicle: Vehicle, road: Road, clear_m: float = 0.0) -> Rows:
    """For each row (R,) the body that it ends up with no room for: closing in on it at its end, in its way, and too near for braking
    (one ahead) or accelerating (one behind) to end that; -1 without. What only puts a collision off is no way out."""
    end = clock[:, -1]
    who = np.full(end.shape, -1, dtype=np.intp)
    if not company.s_m.shape[0]:
        return who
    apart = company.s_m[:, end] - motions.s_m[:, -1]
    ahead, behind = room_needed(motions.speed_mps[:, -1], company.speed_mps[:, end], company.half_length_m[:, end], vehicle, road)
    late = np.where(apart > 0.0, apart < ahead + clear_m, -apart < behind + clear_m)
    late &= np.abs(company.d_m[:, end] - motions.d_m[:, -1]) < company.half_width_m[:, end] + 0.5 * vehicle.width_m
    return np.where(late.any(0), late.argmax(0), who)


def room_needed(speed_mps: Array, others_mps: Array, half_length_m: Array, vehicle: Vehicle, road: Road) -> tuple[Array, Array]:
    """How far bodies (J, ...) must be ahead of a host at these speeds that then brakes, or else behind one that accelerates: of centres."""
    grip = road.friction * GRAVITY_MPS2
    brake, accelerate = min(-vehicle.acceleration_min_mps2, grip), min(vehicle.acceleration_max_mps2, grip)
    closing = speed_mps - others_mps
    bodies = half_length_m + 0.5 * vehicle.length_m
    ahead = bodies + np.maximum(closing, 0.0) ** 2 / (2.0 * ROOM_SHARE * brake)
    behind = bodies + np.minimum(closing, 0.0) ** 2 / (2.0 * ROOM_SHARE * accelerate)
    return ahead, behind


def blocked(motions: Motions, clock: Rows, company: Company, vehicle: Vehicle, road: Road) -> tuple[Array, Array]:
    """Between which distances ahead of the host (J, R) [m], centre to centre at a row's start, each body would be met.

    `-NOWHERE_M` above `NOWHERE_M` reversed where it never is. Looked at between the times of the grid no closer than that.
    """
    long, wide = 0.5 * vehicle.length_m, 0.5 * vehicle.width_m
    length, width = company.half_length_m[:, clock], company.half_width_m[:, clock]
    sine, cosine = motions.sine, motions.cosine
    tilt = np.abs(sine)
    y = company.d_m[:, clock] - motions.d_m
    gained = (motions.s_m - motions.s_m[:, :1]) - (company.s_m[:, clock] - company.s_m[:, clock[:, 0]][..., None])
    across = y * cosine
    across *= np.sign(sine)
    flank = length * tilt + (width * cosine + wide)
    tilt = tilt + 1e-9
    extent = length + (long * cosine + wide * tilt)
    low, high = (across - flank) / tilt, (across + flank) / tilt
    np.maximum(low, -extent, out=low)
    np.minimum(high, extent, out=high)
    apart = (low >= high) | (np.abs(y) >= width + (long * tilt + wide * cosine))
    ahead, behind = room_needed(motions.speed_mps[:, -1], company.speed_mps[:, clock[:, -1]], length[..., -1], vehicle, road)
    in_way = np.abs(y[..., -1]) < width[..., -1] + wide
    apart[..., -1] &= ~in_way
    low[..., -1] = np.where(in_way, np.minimum(low[..., -1], -behind), low[..., -1])
    high[..., -1] = np.where(in_way, np.maximum(high[..., -1], ahead), high[..., -1])
    low += gained
    high += gained
    low[apart] = NOWHERE_M
    high[apart] = -NOWHERE_M
    return low.min(-1), high.max(-1)


def blocked_in_lane(
    rows: Swerves, begin: Starts, clock: Rows, clear_s: float, company: Company, vehicle: Vehicle, road: Road
) -> tuple[Array, Array]:
    """The same for rows that keep their lane (starts on the lattice `clock`, (R,)), of bodies that keep their speed: gaps are least, or
    greatest, where the speeds are the same, where either phase ends, at rest or at the end, so that only those moments are looked at."""
    count, size = company.s_m.shape[0], clock.size
    others = company.speed_mps[:, clock]
    level = rows.level_mps2
    change = level - begin.acceleration_mps2
    rise, fall = vehicle.jerk_max_mps3, vehicle.jerk_min_mps3
    built = np.where(change >= 0.0, change / rise, change / fall)
    reached = begin.speed_mps + 0.5 * (begin.acceleration_mps2 + level) * built
    steady = np.where(level == 0.0, 1.0, level)
    ended = np.maximum(rows.until_s, built)
    moments = np.zeros((count, size, 6))
    moments[..., 1] = built + (others - reached) / steady
    moments[..., 2] = built - reached / steady
    moments[..., 3] = ended
    moments[..., 4] = ended + np.abs(level) / np.where(level > 0.0, -fall, rise)
    moments[..., 5] = clear_s
    np.clip(moments, 0.0, clear_s, out=moments)
    moments.sort(axis=-1)
    each = np.tile(np.arange(size), count)
    speed, _, travelled = pace(rows[each], moments.reshape(-1, 6), begin[each], vehicle)
    v, way = speed.reshape(moments.shape), travelled.reshape(moments.shape)
    gained = way - others[..., None] * moments
    half_length = company.half_length_m[:, clock]
    ahead, behind = room_needed(v[..., -1], others, half_length, vehicle, road)
    bodies = half_length + 0.5 * vehicle.length_m
    low = np.minimum(gained.min(-1) - bodies, gained[..., -1] - behind)
    high = np.maximum(gained.max(-1) + bodies, gained[..., -1] + ahead)
    half = np.minimum(clock + round(0.5 * clear_s / LATTICE_S), company.s_m.shape[1] - 1)
    room = company.half_width_m[:, clock] + 0.5 * vehicle.width_m
    beside = np.minimum(np.abs(company.d_m[:, clock] - begin.d_m), np.abs(company.d_m[:, half] - begin.d_m)) >= room
    return np.where(beside, NOWHERE_M, low), np.where(beside, -NOWHERE_M, high)
