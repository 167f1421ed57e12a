"""Whether a drive may end where it ends: the front car may brake fully and the follower not at all, and nobody is hit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.safe_end import EndKind, SafeEnd, SafeEndSettings
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle

_IN_THE_WAY_M = 0.2  # a body that overlaps the host's width by so little less is in its way
_STANDING_MPS = 0.05
_ROUNDING_M, _ROUNDING_MPS2 = 0.1, 0.05


def distance_to_hold(
    speed_mps: Array | float, front_mps: Array | float, vehicle: Vehicle, road: Road, settings: SafeEndSettings | None = None
) -> Array:
    """The gap [m] at which the host can stop behind a front car that brakes fully (RSS, lemma 2, with a host that holds its speed while
    it responds). Arrays broadcast; never negative.
    """
    cfg = settings or SafeEndSettings()
    grip = road.friction * GRAVITY_MPS2
    own = cfg.braking_share * min(-vehicle.acceleration_min_mps2, grip)
    front = min(cfg.front_braking_mps2, grip)
    v, ahead = np.asarray(speed_mps, dtype=np.float64), np.maximum(np.asarray(front_mps, dtype=np.float64), 0.0)
    needed = np.asarray(v * cfg.response_s + v**2 / (2.0 * own) - ahead**2 / (2.0 * front))
    return np.maximum(needed, 0.0)


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
    standing: Array
    safe: Array
    front_fails: Array
    follower_fails: Array

    def at(self, k: int, t_s: float) -> SafeEnd:
        """The record of sample k."""
        margin, demand = float(self.front_margin_m[k]), float(self.follower_demand_mps2[k])
        nobody_ahead, nobody_behind = margin == math.inf, demand == -math.inf
        kind = EndKind.OPEN
        if self.safe[k]:
            kind = EndKind.STOPPED if self.standing[k] else EndKind.CLEAR if nobody_ahead and nobody_behind else EndKind.HELD
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
) -> Ends:
    """What ending at each of `samples` would mean, judged against the plan's beginning at `start`.

    The front car is any body whose width overlaps the host's there and that is ahead; a standing host asks nothing of it. The end of the
    road is a car that stands.
    """
    cfg = settings or SafeEndSettings()
    s, d, psi, v = (getattr(drive, name)[samples] for name in ("s_m", "d_m", "heading_rad", "speed_mps"))
    standing = v <= _STANDING_MPS
    margin, demand = np.full(s.shape, math.inf), np.full(s.shape, -math.inf)
    front_fails = ~standing & (np.abs(psi) > cfg.settled_rad)
    follower_fails = np.zeros(s.shape, dtype=bool)
    others = prediction.rows_on(drive.t_s)
    its_s, its_v = others.s_m[:, samples], others.speed_s_mps[:, samples]
    lengths = np.array([0.5 * (body.length_m + vehicle.length_m) for body in prediction.bodies])
    widths = np.array([0.5 * (body.width_m + vehicle.width_m) for body in prediction.bodies])
    in_way = np.abs(others.d_m[:, samples] - d) < widths.reshape(-1, 1) + _IN_THE_WAY_M
    near = np.flatnonzero(in_way.any(axis=-1))
    if near.size:
        in_way, its_s, its_v, lengths = in_way[near], its_s[near], its_v[near], lengths[near]
        first_s, first_v = (row[near] for row in _beginning(prediction, drive.t_s))
        ahead = in_way & (its_s >= s)
        room = its_s - s - lengths[:, None] - distance_to_hold(v, its_v, vehicle, road, cfg)
        before = first_s - start.s_m - lengths - distance_to_hold(start.speed_mps, first_v, vehicle, road, cfg)
        owed = np.where(first_s > start.s_m, np.minimum(before, 0.0), 0.0)
        margin = np.where(ahead, room, math.inf).min(axis=0)
        front_fails |= (ahead & (room < owed[:, None] - _ROUNDING_M)).any(axis=0) & ~standing
        behind = in_way & (its_s < s)
        asked = demand_on_follower(s - its_s - lengths[:, None], its_v - v, cfg.follower_response_s)
        asked_before = demand_on_follower(start.s_m - first_s - lengths, first_v - start.speed_mps, cfg.follower_response_s)
        allowed = np.maximum(np.where(first_s < start.s_m, asked_before, 0.0), cfg.follower_demand_mps2)
        demand = np.where(behind, asked, -math.inf).max(axis=0)
        follower_fails |= (behind & (asked > allowed[:, None] + _ROUNDING_MPS2)).any(axis=0)
    if road.road_end_s_m is not None:
        room = road.road_end_s_m - s - 0.5 * vehicle.length_m - distance_to_hold(v, 0.0, vehicle, road, cfg)
        margin = np.minimum(margin, room)
        front_fails |= ~standing & (room < 0.0)
    return Ends(margin, demand, standing, ~front_fails & ~follower_fails, front_fails, follower_fails)


def _beginning(prediction: Prediction, t_s: Array) -> tuple[Array, Array]:
    """Place and speed of every body at the situation's time."""
    rows = prediction.rows_on(t_s if t_s[0] == 0.0 else np.zeros(1))
    return rows.s_m[:, 0], rows.speed_s_mps[:, 0]
