"""Rows of evasive profiles against everybody at once: what they run into, and which gaps they need to begin in."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.manoeuvres.clearance import BOW
from mcdas_opt.manoeuvres.starts import Starts
from mcdas_opt.time_to_react.evasive_profiles import EvasiveProfiles, Motions, pace
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S, PredictedTraffic, Rows

ROOM_SHARE = 0.95  # of the braking or accelerating that ends what still closes in at the end
NOWHERE_M = 1e4
ARRIVED_M = 1.0  # who changes lanes is so near to the middle of the next one at the end: no longer in the old one
ABILITY_M = 10.0  # a share of the car's limits as a distance: only where it changes sign matters
STEP_REACH_M = 3.0  # more than bodies move against each other in a step


def touched(motions: Motions, clock: Rows, traffic: PredictedTraffic, vehicle: Vehicle, road: Road, clear_m: float) -> tuple[Rows, Rows]:
    """The step (R,) in which each row first has no more than `clear_m` left, and to whom; -1 without. `clock` (R, T): lattice indices.

    Rectangles on the axes of both, in the road's frame. Motion is linear within a step, and there the axes that separate the
    two may take turns, but never leave a moment without one.
    """
    rows, steps = motions.s_m.shape[0], motions.s_m.shape[1] - 1
    count = traffic.s_m.shape[0]
    none = np.full(rows, -1, dtype=np.intp)
    if not count:
        return none, none
    apart = traffic.s_m[:, clock] - motions.s_m
    long, wide = 0.5 * vehicle.length_m, 0.5 * vehicle.width_m
    bend = road.sharpest_1pm
    reach = (np.hypot(long, wide) + traffic.half_length_m.max(-1) + clear_m + STEP_REACH_M) * (2.0 if bend else 1.0)
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
    there = who * traffic.d_m.shape[1] + clock.reshape(-1)[place]
    other = traffic.d_m.reshape(-1)[there]
    length, width = (q.reshape(-1)[there].max(0) for q in (traffic.half_length_m, traffic.half_width_m))
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
    """For steps at both ends of which no single axis separates the two (8, 2, n): whether one does until another one does."""
    begin, end = free[:, 0], free[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = begin / (begin - end)
    until = np.where(begin > 0.0, turn, -1.0).max(0)
    since = np.where(end > 0.0, turn, 2.0).min(0)
    return np.asarray(until > since)


def inevitable_collision(
    motions: Motions, clock: Rows, traffic: PredictedTraffic, vehicle: Vehicle, road: Road, clear_m: float = 0.0
) -> Rows:
    """For each row (R,) the body that it ends up with no room for: closing in on it at its end, in its way, and too near for braking
    (one ahead) or accelerating (one behind) to end that; -1 without. What only puts a collision off is no escape."""
    end = clock[:, -1]
    who = np.full(end.shape, -1, dtype=np.intp)
    if not traffic.s_m.shape[0]:
        return who
    apart = traffic.s_m[:, end] - motions.s_m[:, -1]
    ahead, behind = room_needed(motions.speed_mps[:, -1], traffic.speed_mps[:, end], traffic.half_length_m[:, end], vehicle, road)
    late = np.where(apart > 0.0, apart < ahead + clear_m, -apart < behind + clear_m)
    late &= np.abs(traffic.d_m[:, end] - motions.d_m[:, -1]) < traffic.half_width_m[:, end] + 0.5 * vehicle.width_m
    return np.where(late.any(0), late.argmax(0), who)


def room_needed(speed_mps: Array, others_mps: Array, half_length_m: Array, vehicle: Vehicle, road: Road) -> tuple[Array, Array]:
    """How far bodies (J, ...) must be ahead of a host at these speeds that then brakes, or else behind one that accelerates: of centres."""
    brake, accelerate = available_mps2(vehicle, road.friction)
    closing = speed_mps - others_mps
    bodies = half_length_m + 0.5 * vehicle.length_m
    ahead = bodies + np.maximum(closing, 0.0) ** 2 / (2.0 * ROOM_SHARE * brake)
    behind = bodies + np.minimum(closing, 0.0) ** 2 / (2.0 * ROOM_SHARE * accelerate)
    return ahead, behind


def blocked(motions: Motions, clock: Rows, traffic: PredictedTraffic, vehicle: Vehicle, road: Road) -> tuple[Array, Array]:
    """Between which distances ahead of the host (J, R) [m], centre to centre at a row's start, each body would be met.

    `-NOWHERE_M` above `NOWHERE_M` reversed where it never is. Looked at between the times of the grid no closer than that.
    """
    long, wide = 0.5 * vehicle.length_m, 0.5 * vehicle.width_m
    length, width = traffic.half_length_m[:, clock], traffic.half_width_m[:, clock]
    sine, cosine = motions.sine, motions.cosine
    tilt = np.abs(sine)
    y = traffic.d_m[:, clock] - motions.d_m
    gained = (motions.s_m - motions.s_m[:, :1]) - (traffic.s_m[:, clock] - traffic.s_m[:, clock[:, 0]][..., None])
    across = y * cosine
    across *= np.sign(sine)
    flank = length * tilt + (width * cosine + wide)
    tilt = tilt + 1e-9
    extent = length + (long * cosine + wide * tilt)
    low, high = (across - flank) / tilt, (across + flank) / tilt
    np.maximum(low, -extent, out=low)
    np.minimum(high, extent, out=high)
    apart = (low >= high) | (np.abs(y) >= width + (long * tilt + wide * cosine))
    ahead, behind = room_needed(motions.speed_mps[:, -1], traffic.speed_mps[:, clock[:, -1]], length[..., -1], vehicle, road)
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
    rows: EvasiveProfiles, begin: Starts, clock: Rows, clear_s: float, traffic: PredictedTraffic, vehicle: Vehicle, road: Road
) -> tuple[Array, Array]:
    """The same for rows that keep their lane (starts on the lattice `clock`, (R,)), of bodies that keep their speed: gaps are least, or
    greatest, where the speeds are the same, where either phase ends, at rest or at the end, so that only those moments are looked at."""
    count, size = traffic.s_m.shape[0], clock.size
    others = traffic.speed_mps[:, clock]
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
    speed, _, distance = pace(rows[each], moments.reshape(-1, 6), begin[each], vehicle)
    v, travelled = speed.reshape(moments.shape), distance.reshape(moments.shape)
    gained = travelled - others[..., None] * moments
    half_length = traffic.half_length_m[:, clock]
    ahead, behind = room_needed(v[..., -1], others, half_length, vehicle, road)
    bodies = half_length + 0.5 * vehicle.length_m
    low = np.minimum(gained.min(-1) - bodies, gained[..., -1] - behind)
    high = np.maximum(gained.max(-1) + bodies, gained[..., -1] + ahead)
    half = np.minimum(clock + round(0.5 * clear_s / LATTICE_S), traffic.s_m.shape[1] - 1)
    room = traffic.half_width_m[:, clock] + 0.5 * vehicle.width_m
    beside = np.minimum(np.abs(traffic.d_m[:, clock] - begin.d_m), np.abs(traffic.d_m[:, half] - begin.d_m)) >= room
    return np.where(beside, NOWHERE_M, low), np.where(beside, -NOWHERE_M, high)
