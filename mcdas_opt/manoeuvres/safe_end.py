"""Whether a drive may end where it ends: the front car may brake fully and the follower not at all, and nobody is hit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction, sizes_on_road
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.safe_end import EndKind, SafeEnd, SafeEndSettings
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle

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
        grip = road.friction * GRAVITY_MPS2
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
    samples: slice,
    start: HostState,
    vehicle: Vehicle,
    road: Road,
    prediction: Prediction,
    settings: SafeEndSettings | None = None,
    owed_m: Mapping[str, float] | None = None,
) -> Ends:
    """What ending at each of `samples` would mean, judged against the plan's beginning at `start`.

    `owed_m` says by name how short of the distance that can be held (at most 0) others made it; who is not named, by all that is short at
    the beginning.

    The front car is any body whose width overlaps the host's there and that is ahead; a standing host asks nothing of it. The end of the
    road, or of the lane there, is a car that stands.
    """
    cfg = settings or SafeEndSettings()
    s, d, psi, v = (column[samples] for column in (drive.s_m, drive.d_m, drive.heading_rad, drive.speed_mps))
    standing = v <= _STANDING_MPS
    margin, demand = np.full(s.shape, math.inf), np.full(s.shape, -math.inf)
    front_fails = ~standing & (np.abs(_turned_rad(s, psi, vehicle, road)) > cfg.settled_rad)
    follower_fails = np.zeros(s.shape, dtype=bool)
    others = prediction.rows_on(drive.t_s)
    its_s, its_v = others.s_m[:, samples], others.speed_s_mps[:, samples]
    taken_m, taken_across_m = sizes_on_road(prediction.bodies, others.heading_rad[:, samples])
    lengths, widths = 0.5 * (taken_m + vehicle.length_m), 0.5 * (taken_across_m + vehicle.width_m)
    in_way = np.abs(others.d_m[:, samples] - d) < widths + IN_THE_WAY_M
    near = np.flatnonzero(in_way.any(axis=-1))
    if near.size:
        in_way, its_s, its_v, lengths = in_way[near], its_s[near], its_v[near], lengths[near]
        first_s, first_v = (row[near] for row in _beginning(prediction, drive.t_s))
        ahead = in_way & (its_s >= s)
        room = its_s - s - lengths - distance_to_hold(v, its_v, vehicle, road, cfg)
        before = first_s - start.s_m - lengths[:, 0] - distance_to_hold(start.speed_mps, first_v, vehicle, road, cfg)
        owed = np.where(first_s > start.s_m, np.minimum(before, 0.0), 0.0)
        if owed_m:
            owed = np.array([owed_m.get(prediction.bodies[i].id, own) for i, own in zip(near.tolist(), owed.tolist(), strict=True)])
        margin = np.where(ahead, room, math.inf).min(axis=0)
        front_fails |= (ahead & (room < owed[:, None] - _ROUNDING_M)).any(axis=0) & ~standing
        behind = in_way & (its_s < s)
        asked = demand_on_follower(s - its_s - lengths, its_v - v, cfg.follower_response_s)
        asked_before = demand_on_follower(start.s_m - first_s - lengths[:, 0], first_v - start.speed_mps, cfg.follower_response_s)
        allowed = np.maximum(np.where(first_s < start.s_m, asked_before, 0.0), cfg.follower_demand_mps2)
        demand = np.where(behind, asked, -math.inf).max(axis=0)
        follower_fails |= (behind & (asked > allowed[:, None] + _ROUNDING_MPS2)).any(axis=0)
    if road.road_end_s_m is not None or road.lanes:
        end = np.array([_end_m(road, *place, vehicle) for place in zip(s.tolist(), d.tolist(), strict=True)])
        room = end - s - 0.5 * vehicle.length_m - distance_to_hold(v, 0.0, vehicle, road, cfg)
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
    """`ends` of the last sample alone, number by number: every plan is asked for it, and one sample fills no array."""
    cfg = settings or SafeEndSettings()
    s, d, psi, v = (row.item(-1) for row in (drive.s_m, drive.d_m, drive.heading_rad, drive.speed_mps))
    braking, response, standing = Braking.of(vehicle, road, cfg), cfg.follower_response_s, v <= _STANDING_MPS
    margin, demand = math.inf, -math.inf
    front_fails, follower_fails = not standing and abs(_turned_rad(s, psi, vehicle, road)) > cfg.settled_rad, False
    others = prediction.rows_on(drive.t_s)
    lasts = zip(*(row[:, -1].tolist() for row in (others.s_m, others.d_m, others.speed_s_mps)), strict=True)
    firsts = zip(*(row.tolist() for row in _beginning(prediction, drive.t_s)), strict=True)
    taken = zip(*(size[:, -1].tolist() for size in sizes_on_road(prediction.bodies, others.heading_rad[:, -1:])), strict=True)
    for body, (its_s, its_d, its_v), (first_s, first_v), (length, width) in zip(prediction.bodies, lasts, firsts, taken, strict=True):
        if not abs(its_d - d) < 0.5 * (width + vehicle.width_m) + IN_THE_WAY_M:
            continue
        lengths = 0.5 * (length + vehicle.length_m)
        if its_s >= s:
            room = its_s - s - lengths - max(braking.needed(v, max(its_v, 0.0)), 0.0)
            margin, owed = min(margin, room), 0.0
            known = None if owed_m is None else owed_m.get(body.id)
            if known is not None:
                owed = known
            elif first_s > start.s_m:
                owed = first_s - start.s_m - lengths - max(braking.needed(start.speed_mps, max(first_v, 0.0)), 0.0)
            front_fails = front_fails or (not standing and room < min(owed, 0.0) - _ROUNDING_M)
        else:
            asked, asked_before = _demand(s - its_s - lengths, its_v - v, response), 0.0
            if first_s < start.s_m:
                asked_before = _demand(start.s_m - first_s - lengths, first_v - start.speed_mps, response)
            demand = max(demand, asked)
            follower_fails = follower_fails or asked > max(cfg.follower_demand_mps2, asked_before) + _ROUNDING_MPS2
    if road.road_end_s_m is not None or road.lanes:
        room = _end_m(road, s, d, vehicle) - s - 0.5 * vehicle.length_m - max(braking.needed(v, 0.0), 0.0)
        margin, front_fails = min(margin, room), front_fails or (not standing and room < 0.0)
    end = _record(margin, demand, drive.t_s.item(-1), not front_fails and not follower_fails, standing)
    return LastEnd(end, front_fails, follower_fails)


def _turned_rad(s_m: Any, psi_rad: Any, vehicle: Vehicle, road: Road) -> Any:
    """Off the heading of a body that goes along the road, which in a bend is turned out of it by its sideslip at the centre."""
    return psi_rad if road.is_straight else psi_rad + vehicle.centre_m * road.curvature_at(s_m)


def _end_m(road: Road, s_m: float, d_m: float, vehicle: Vehicle) -> float:
    """Where a host that is there comes to an end in its lane."""
    if not road.lanes:
        assert road.road_end_s_m is not None
        return road.road_end_s_m
    return road.ends_m(road.lane_of(d_m, s_m), s_m, vehicle.width_m)


def _demand(gap_m: float, closing_mps: float, response_s: float) -> float:
    """`demand_on_follower`, of numbers."""
    if closing_mps <= 0.0 and gap_m > 0.0:
        return 0.0
    closing = max(closing_mps, 0.0)
    left = gap_m - closing * response_s
    return closing * closing / (2.0 * left) if left > 0.0 else math.inf


def _beginning(prediction: Prediction, t_s: Array) -> tuple[Array, Array]:
    """Place and speed of every body at the situation's time."""
    rows = prediction.rows_on(t_s if t_s[0] == 0.0 else _NOW)
    return rows.s_m[:, 0], rows.speed_s_mps[:, 0]
