"""Whether a drive may end where it ends: the front car may brake fully and the follower not at all, and nobody is hit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import BodyMotion, Prediction, sizes_on_road
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.safe_end import EndKind, SafeEnd, SafeEndSettings
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.native.library import library

IN_THE_WAY_M = 0.2  # a body that overlaps the host's width by so little less is in its way
_STANDING_MPS = 0.05
_ROUNDING_M, _ROUNDING_MPS2 = 0.1, 0.05
_NOW = np.zeros(1)
_NOW.setflags(write=False)


def distance_to_hold(
    speed_mps: Array | float, front_mps: Array | float, vehicle: Vehicle, road: Road, settings: SafeEndSettings | None = None
) -> Array:
    """The gap [m] at which the host can stop behind a front car that brakes fully (RSS, lemma 2, with a host that holds its speed while
    it responds). Arrays broadcast; never negative.
    """
    v, ahead = np.asarray(speed_mps, dtype=np.float64), np.maximum(np.asarray(front_mps, dtype=np.float64), 0.0)
    needed = Braking.of(vehicle, road, settings or SafeEndSettings()).needed(v, ahead)
    return np.asarray(np.maximum(needed, 0.0), dtype=np.float64)


class Braking(NamedTuple):
    """Twice what the host and a front car can brake with [m/s^2], and how late the host does [s]."""

    twice_own: float
    twice_front: float
    response_s: float

    @classmethod
    def of(cls, vehicle: Vehicle, road: Road, cfg: SafeEndSettings) -> Braking:
        grip = road.grip_mps2
        own = cfg.braking_share * min(-vehicle.acceleration_min_mps2, grip)
        return cls(2.0 * own, 2.0 * min(cfg.front_braking_mps2, grip), cfg.response_s)

    def needed(self, v: Any, ahead: Any) -> Any:
        """The gap that holds behind a front car that drives so fast, at least 0; negative: none is needed."""
        return v * self.response_s + v * v / self.twice_own - ahead * ahead / self.twice_front


def demand_on_follower(gap_m: Array | float, closing_mps: Array | float, response_s: float) -> Array:
    """The constant braking [m/s^2] by which a follower that closes at `closing_mps` just avoids the host, begun after `response_s`.

    Zero when it does not close, infinite when it is there before it responds. Arrays broadcast.
    """
    closing = np.maximum(np.asarray(closing_mps, dtype=np.float64), 0.0)
    left = np.asarray(gap_m, dtype=np.float64) - closing * response_s
    demand = np.divide(closing**2, 2.0 * left, out=np.full(np.broadcast(closing, left).shape, math.inf), where=left > 0.0)
    return np.asarray(np.where((closing <= 0.0) & (np.asarray(gap_m) > 0.0), 0.0, demand), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Ends:
    """For each of n samples, what ending there would mean: least margin to who is ahead, most demand on who is behind, safe or not."""

    front_margin_m: Array
    follower_demand_mps2: Array
    standing: NDArray[np.bool_]
    safe: NDArray[np.bool_]
    front_fails: NDArray[np.bool_]
    follower_fails: NDArray[np.bool_]

    def at(self, k: int, t_s: float) -> SafeEnd:
        """The record of sample k."""
        return _record(float(self.front_margin_m[k]), float(self.follower_demand_mps2[k]), t_s, self.safe[k], self.standing[k])


@dataclass(frozen=True, slots=True)
class LastEnd:
    """The end of a drive as it is, and what is not safe about it."""

    end: SafeEnd
    front_fails: bool
    follower_fails: bool


def _record(margin: float, demand: float, t_s: float, safe: Any, standing: Any) -> SafeEnd:
    nobody_ahead, nobody_behind = margin == math.inf, demand == -math.inf
    kind = EndKind.OPEN
    if safe:
        kind = EndKind.STOPPED if standing else EndKind.CLEAR if nobody_ahead and nobody_behind else EndKind.HELD
    return SafeEnd(
        kind=kind,
        t_s=t_s,
        front_margin_m=None if nobody_ahead else margin,
        follower_demand_mps2=None if nobody_behind else demand,
    )


def ends(
    drive: Trajectory,
    first: int,
    start: HostState,
    vehicle: Vehicle,
    road: Road,
    prediction: Prediction,
    settings: SafeEndSettings | None = None,
    owed_m: Mapping[str, float] | None = None,
) -> Ends:
    """What ending at each sample from the `first` on would mean, judged against the plan's beginning at `start`.

    `owed_m` says by name how short of the distance that can be held (at most 0) others made it; who is not named, by all that is short at
    the beginning.

    The front car is any body whose width overlaps the host's there and that is ahead; a standing host asks nothing of it. The end of the
    road, or of the lane there, is a car that stands.

    In C where there is a compiler, with the same bits.
    """
    cfg, first = settings or SafeEndSettings(), range(len(drive))[first]
    turned = lane_end = None
    if not road.is_straight:  # a body in a bend is turned out of it by its sideslip at the centre
        turned = drive.heading_rad[first:] + vehicle.centre_m * road.curvature_at(drive.s_m[first:])
    if road.road_end_s_m is not None or road.lanes:
        places = zip(drive.s_m[first:].tolist(), drive.d_m[first:].tolist(), strict=True)
        lane_end = np.array([_end_m(road, *place, vehicle) for place in places])
    bodies, others = prediction.bodies, prediction.rows_on(drive.t_s)
    taken = sizes_on_road(bodies, others.heading_rad[:, first:])
    begun = others if drive.t_s[0] == 0.0 else prediction.rows_on(_NOW)
    owed = [math.nan] * len(bodies) if owed_m is None else [owed_m.get(body.id, math.nan) for body in bodies]
    now = np.array((begun.s_m[:, 0], begun.speed_s_mps[:, 0], owed))  # of everybody
    compiled = library()
    if compiled is None:
        return _interpreted(drive, first, turned, lane_end, others, taken, now, start, vehicle, road, cfg)
    count = len(drive) - first
    found, numbers = np.empty((4, count), dtype=np.bool_), np.empty((2, count))
    bounds = cfg.follower_response_s, cfg.follower_demand_mps2, cfg.settled_rad, IN_THE_WAY_M, _STANDING_MPS, _ROUNDING_M, _ROUNDING_MPS2
    rule = np.array((vehicle.length_m, vehicle.width_m, start.s_m, start.speed_mps, *Braking.of(vehicle, road, cfg), *bounds))
    rows = map(np.ascontiguousarray, (others.s_m, others.d_m, others.speed_s_mps))
    sizes = map(np.ascontiguousarray, taken)
    each = taken[0].shape[1] == count > 1
    compiled.mcdas_ends(len(drive), first, drive.table, turned, lane_end, len(owed), *rows, each, *sizes, now, rule, found, numbers)
    standing, safe, front_fails, follower_fails = found
    return Ends(numbers[0], numbers[1], standing, safe, front_fails, follower_fails)


def _interpreted(
    drive: Trajectory,
    first: int,
    turned: Array | None,
    lane_end: Array | None,
    others: BodyMotion,
    taken: tuple[Array, Array],
    now: Array,
    start: HostState,
    vehicle: Vehicle,
    road: Road,
    cfg: SafeEndSettings,
) -> Ends:
    """`now`: of everybody the place, the speed and what is owed, NaN where that is not known."""
    s, d, psi, v = (column[first:] for column in (drive.s_m, drive.d_m, drive.heading_rad, drive.speed_mps))
    standing = v <= _STANDING_MPS
    margin, demand = np.full(s.shape, math.inf), np.full(s.shape, -math.inf)
    front_fails = ~standing & (np.abs(psi if turned is None else turned) > cfg.settled_rad)
    follower_fails = np.zeros(s.shape, dtype=bool)
    its_s, its_d, its_v = (row[:, first:] for row in (others.s_m, others.d_m, others.speed_s_mps))
    if len(its_s):
        first_s, first_v, known = now
        lengths, widths = 0.5 * (taken[0] + vehicle.length_m), 0.5 * (taken[1] + vehicle.width_m)
        in_way = np.abs(its_d - d) < widths + IN_THE_WAY_M
        ahead = in_way & (its_s >= s)
        room = its_s - s - lengths - distance_to_hold(v, its_v, vehicle, road, cfg)
        before = first_s - start.s_m - lengths[:, 0] - distance_to_hold(start.speed_mps, first_v, vehicle, road, cfg)
        owed = np.where(np.isnan(known), np.where(first_s > start.s_m, np.minimum(before, 0.0), 0.0), known)
        margin = np.where(ahead, room, math.inf).min(axis=0)
        front_fails |= (ahead & (room < owed[:, None] - _ROUNDING_M)).any(axis=0) & ~standing
        behind = in_way & (its_s < s)
        asked = demand_on_follower(s - its_s - lengths, its_v - v, cfg.follower_response_s)
        asked_before = demand_on_follower(start.s_m - first_s - lengths[:, 0], first_v - start.speed_mps, cfg.follower_response_s)
        allowed = np.maximum(np.where(first_s < start.s_m, asked_before, 0.0), cfg.follower_demand_mps2)
        demand = np.where(behind, asked, -math.inf).max(axis=0)
        follower_fails |= (behind & (asked > allowed[:, None] + _ROUNDING_MPS2)).any(axis=0)
    if lane_end is not None:
        room = lane_end - s - 0.5 * vehicle.length_m - distance_to_hold(v, 0.0, vehicle, road, cfg)
        margin = np.minimum(margin, room)
        front_fails |= ~standing & (room < 0.0)
    return Ends(margin, demand, standing, ~front_fails & ~follower_fails, front_fails, follower_fails)


def last_end(
    drive: Trajectory,
    start: HostState,
    vehicle: Vehicle,
    road: Road,
    prediction: Prediction,
    settings: SafeEndSettings | None = None,
    owed_m: Mapping[str, float] | None = None,
) -> LastEnd:
    """`ends` of the last sample alone."""
    found = ends(drive, -1, start, vehicle, road, prediction, settings, owed_m)
    return LastEnd(found.at(0, drive.t_s.item(-1)), bool(found.front_fails[0]), bool(found.follower_fails[0]))


def _end_m(road: Road, s_m: float, d_m: float, vehicle: Vehicle) -> float:
    """Where a host that is there comes to an end in its lane."""
    if not road.lanes:
        assert road.road_end_s_m is not None
        return road.road_end_s_m
    return road.ends_m(road.lane_of(d_m, s_m), s_m, vehicle.width_m)
