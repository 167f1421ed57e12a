"""Evasive profiles in closed form: speed and offset are sums of ramps, so that thousands of states cost a few array operations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.geometry.edges import beyond_edges
from mcdas_opt.manoeuvres.family import Demand
from mcdas_opt.manoeuvres.paths import body_paths
from mcdas_opt.manoeuvres.starts import Starts, rear_axle

EDGE_M = 0.01  # kept from the edges, for what a driver deviates
SHARE = 0.98  # of the vehicle's jerk, steering rate and top speed
SLOWEST_MPS = 0.5  # steering is not followed below it
STEEPEST = 0.9  # sine of the heading
LEAST_M = 1e-4
GENTLE_S = 0.6  # in so long a car that keeps its lane builds up its lateral acceleration
CURVIEST_1PM = 0.08
ROUNDS = 3  # of shrinking the peak of a lane change that is too short for it


@dataclass(frozen=True, slots=True, kw_only=True)
class EvasiveProfiles:
    """Rows (R,): one manoeuvre each.

    Along the lane: this acceleration until then, afterwards none. Across: a lane change by the clock, to `target_d_m` (of the rear axle),
    at this peak of lateral acceleration; where `target_d_m` is NaN the car straightens up along the road as it drives, at this lateral
    acceleration, and stays where it then is.
    """

    level_mps2: Array
    until_s: Array
    target_d_m: Array
    lateral_mps2: Array

    @property
    def timed(self) -> NDArray[np.bool_]:
        return ~np.isnan(self.target_d_m)

    def __getitem__(self, index: Any) -> EvasiveProfiles:
        parts = (self.level_mps2, self.until_s, self.target_d_m, self.lateral_mps2)
        level, until, target, lateral = (q[index] for q in parts)
        return EvasiveProfiles(level_mps2=level, until_s=until, target_d_m=target, lateral_mps2=lateral)

    def and_straight(self, count: int, lateral_mps2: float) -> EvasiveProfiles:
        """With so many rows behind them that keep their speed and straighten up."""
        none = np.zeros(count)
        return EvasiveProfiles(
            level_mps2=np.concatenate([self.level_mps2, none]),
            until_s=np.concatenate([self.until_s, none]),
            target_d_m=np.concatenate([self.target_d_m, none + np.nan]),
            lateral_mps2=np.concatenate([self.lateral_mps2, none + lateral_mps2]),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Motions:
    """What rows of profiles do (R, T): body centre, heading relative to the road by its sine and cosine; speed, acceleration and
    curvature [1/m] of the rear axle. For each row (R,): what it asks of the tyres; the share of the car's limits that is left, and how far
    the body stays from the road's edges and end, both negative where that is too much."""

    s_m: Array
    d_m: Array
    sine: Array
    cosine: Array
    speed_mps: Array
    acceleration_mps2: Array
    curvature_1pm: Array
    demand_mps2: Array
    ability: Array
    edge_m: Array

    @property
    def possible(self) -> NDArray[np.bool_]:
        return np.asarray(self.ability >= 0.0)

    @property
    def on_road(self) -> NDArray[np.bool_]:
        return np.asarray(self.edge_m >= 0.0)


def evasive_motions(rows: EvasiveProfiles, times_s: Array, start: Starts, vehicle: Vehicle, road: Road, demand: Demand) -> Motions:
    """The rows from their starts (R,), at times (T,) that increase from 0.

    Both motions are chains of ramps, jerk by jerk. Across, they are the quickest there is for a bounded lateral acceleration, built up
    no faster than the steering turns: one pulse out, one back, which also takes up the heading and the curvature that the car has.
    The rear axle's exact kinematics, no small angles: sin(psi) = d'/v.
    """
    v, a, travelled = pace(rows, times_s, start, vehicle)
    s0, d0, sine0, bend0 = rear_axle(start, vehicle, road)

    timed = rows.timed[:, None]
    d, first, second, fits = _across(rows, v, times_s, travelled, start.speed_mps, a[:, 0], d0, sine0, bend0, vehicle)
    per_way = np.where(timed, 1.0 / np.maximum(v, SLOWEST_MPS), 1.0)
    sine = first * per_way
    steep = np.abs(sine).max(-1)
    np.clip(sine, -STEEPEST, STEEPEST, out=sine)
    cosine = np.sqrt(1.0 - sine * sine)
    curvature = (second - np.where(timed, a, 0.0) * sine) * per_way * per_way / cosine
    paths = body_paths(s0[:, None], travelled, d, sine, cosine, curvature, vehicle, road)
    s, d, sine, cosine, curvature = paths.s_m, paths.d_m, paths.sine, paths.cosine, paths.curvature_1pm
    lateral = v * v * curvature
    effort = np.sqrt((a * a + lateral * lateral).max(-1))
    steering = np.arctan(vehicle.wheelbase_m * curvature)
    turned = (np.abs(np.diff(steering, axis=-1)) / np.diff(times_s)).max(-1)
    used = np.maximum(effort / (demand.friction * road.friction * GRAVITY_MPS2), steep / STEEPEST)
    np.maximum(used, np.abs(steering).max(-1) / (demand.steering * vehicle.steering_max_rad), out=used)
    np.maximum(used, turned / (demand.steering * vehicle.steering_rate_max_radps), out=used)
    room = 0.5 * (vehicle.width_m * cosine + vehicle.length_m * np.abs(sine))
    edge = -beyond_edges(s, d - room, d + room, vehicle, road).max(-1)
    if road.road_end_s_m is not None:
        edge = np.minimum(edge, road.road_end_s_m - s[:, -1] - 0.5 * vehicle.length_m)
    return Motions(
        s_m=s,
        d_m=d,
        sine=sine,
        cosine=cosine,
        speed_mps=v,
        acceleration_mps2=a,
        curvature_1pm=curvature,
        demand_mps2=effort,
        ability=np.where(fits, 1.0 - used, -1.0),
        edge_m=edge - EDGE_M,
    )


def pace(rows: EvasiveProfiles, times_s: Array, start: Starts, vehicle: Vehicle) -> tuple[Array, Array, Array]:
    """Speed, acceleration and distance travelled (R, T) at times (T,), or (R, T), in order.

    A car that has come to rest stands; one at top speed keeps it. The distance to rest is that to the last time before it.
    """
    rise, fall = SHARE * vehicle.jerk_max_mps3, SHARE * vehicle.jerk_min_mps3
    level, a0 = rows.level_mps2, start.acceleration_mps2
    rates = np.array([np.where(level >= a0, rise, fall), np.where(level > 0.0, fall, rise)])
    changes = np.array([level - a0, -level])
    lasting = changes / rates
    begins = np.array([np.zeros_like(lasting[0]), np.maximum(rows.until_s, lasting[0])])
    added, summed, twice = _ramps(times_s, begins[..., None], lasting[..., None], rates[..., None])
    added += a0[:, None]
    summed += start.speed_mps[:, None] + a0[:, None] * times_s
    twice += (start.speed_mps[:, None] + 0.5 * a0[:, None] * times_s) * times_s
    a, v, travelled = added, summed, twice
    if v.min(initial=1.0) <= 0.0:
        standing = np.logical_or.accumulate(v <= 0.0, axis=-1)
        v, a = np.where(standing, 0.0, v), np.where(standing, 0.0, a)
        travelled = np.maximum.accumulate(travelled, axis=-1)
    top = np.maximum(SHARE * vehicle.speed_max_mps, start.speed_mps)[:, None]
    fast = np.asarray((v > top).any(-1))
    if fast.any():
        a = np.where(v > top, 0.0, a)
        v = np.minimum(v, top)
        driven = travelled[:, :1] + np.cumsum(0.5 * (v[:, 1:] + v[:, :-1]) * np.diff(times_s), axis=-1)
        travelled = np.where(fast[:, None], np.concatenate([travelled[:, :1], driven], axis=-1), travelled)
    return v, a, travelled


def _across(
    rows: EvasiveProfiles,
    v: Array,
    times_s: Array,
    travelled: Array,
    v0: Array,
    a0: Array,
    d0: Array,
    sine0: Array,
    bend0: Array,
    vehicle: Vehicle,
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """d and its first two derivatives (R, T), by the clock or by the distance; and (R,) whether there is such a profile."""
    timed = rows.timed
    floor = np.maximum(v0, 1.0)
    rate0 = np.where(timed, v0 * sine0, sine0)
    curl0 = np.where(timed, a0 * sine0 + v0 * v0 * bend0, bend0)
    middle = np.searchsorted(times_s, 1.0)
    slow = np.maximum(np.minimum(v0, v[:, min(middle, v.shape[1] - 1)]), SLOWEST_MPS)
    turning = SHARE * vehicle.steering_rate_max_radps / vehicle.wheelbase_m
    peak = np.where(timed, rows.lateral_mps2, np.minimum(rows.lateral_mps2 / (floor * floor), CURVIEST_1PM))
    jerk = np.where(timed, turning * slow * slow, np.minimum(peak / (GENTLE_S * floor), turning / floor))

    undoing = np.where(timed, jerk, 0.5 * turning / floor)
    ends = np.abs(curl0) / undoing  # first the curvature that there is goes to 0
    u = rate0 + 0.5 * curl0 * ends
    left = np.where(timed, rows.target_d_m - (d0 + (rate0 + curl0 * ends / 3.0) * ends), 0.0)
    sign = np.where(left - 0.5 * u * np.abs(u) / peak >= 0.0, 1.0, -1.0)
    u, left = u * sign, left * sign
    far = np.maximum(np.abs(left), LEAST_M)
    # a car at an angle to the road turns more for the same motion across it (1 / cos(psi)), and braking then acts across too
    quick = np.minimum(far / np.maximum(np.sqrt(far / peak), 2.0 * np.cbrt(0.5 * far / jerk)) * np.where(timed, 1.0 / slow, 0.0), STEEPEST)
    upright = np.sqrt(1.0 - quick * quick)
    jerk = jerk * upright
    peak = np.maximum(peak * upright - np.where(timed, np.abs(rows.level_mps2) * quick, 0.0), 0.1 * peak)
    peak = np.minimum(peak, np.where(timed, jerk * np.cbrt(0.5 * far / jerk), np.sqrt(np.maximum(np.abs(u), 1e-9) * jerk)))
    for _ in range(ROUNDS):
        rising = peak / jerk
        half = 0.5 * (2.0 * u - peak * rising)
        out = (-half + np.sqrt(np.maximum(half * half - 0.5 * u * u + 0.5 * peak * rising * u + peak * left, 0.0))) / peak
        back = out + u / peak
        short = np.minimum(out, back)
        fits = ~timed | (short >= 2.0 * rising - 1e-9)
        if fits.all():
            break
        peak = np.where(fits, peak, np.maximum(0.49 * jerk * short, 0.3 * peak))
    up = sign * jerk
    turn = np.where(timed, ends + out - rising, ends)
    done = np.where(timed, ends + out + back - rising, ends + np.abs(u) / peak)
    begins = np.array([np.zeros_like(ends), ends, turn, done])
    lasting = np.array([ends, rising, np.where(timed, 2.0 * rising, rising), rising])
    up = np.where(timed, up, np.sign(u) * up)
    rates = np.array([-np.sign(curl0) * undoing, np.where(timed, up, 0.0), -up, up])
    z = np.where(timed[:, None], times_s, travelled)
    second, first, d = _ramps(z, begins[..., None], lasting[..., None], rates[..., None])
    first += rate0[:, None] + curl0[:, None] * z
    d += d0[:, None] + (rate0[:, None] + 0.5 * curl0[:, None] * z) * z
    second += curl0[:, None]
    return d, first, second, fits


def _ramps(z: Array, begins: Array, lasting: Array, rates: Array) -> tuple[Array, Array, Array]:
    """The sum of ramps (n, R, 1), each of a rate from its begin on for as long as it lasts, and its first two integrals: (R, T)."""
    u = z - begins
    np.maximum(u, 0.0, out=u)
    c = np.minimum(u, lasting)
    u -= c
    risen = rates * c
    c *= c
    rest = lasting * u
    once = (rates * (0.5 * c + rest)).sum(0)
    u += lasting
    twice = (c * risen * (1.0 / 6.0) + (0.5 * rates) * (rest * u)).sum(0)
    return risen.sum(0), once, twice
