"""A family of manoeuvres: lane-change profiles x speed phases, rolled out and scored against predicted bodies in one vectorised pass."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.cost_weights import NEARNESS_M, CostWeights
from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array, non_negative, positive, require, require_every
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.geometry.edges import beyond_edges
from mcdas_opt.manoeuvres.clearance import Clearance, Margins, clearance
from mcdas_opt.manoeuvres.lane_change_profiles import LaneChangeProfiles, paths
from mcdas_opt.manoeuvres.paths import Paths
from mcdas_opt.manoeuvres.phases import Phases, SpeedHistory, speed_history

EDGE_M = 0.02  # bodies keep this far from the road's edges
TICK = 1e-9  # costs closer than this are the same
WEIGHTS = CostWeights()  # what a member costs: as a plan does


@dataclass(frozen=True, slots=True, kw_only=True)
class Demand:
    """What may be asked of car and road, as shares of their limits."""

    friction: float = 0.97
    steering: float = 0.98

    def __post_init__(self) -> None:
        require(self, positive, "friction", "steering", of="demand")


@dataclass(frozen=True, slots=True, kw_only=True)
class Rolled:
    """Every member's motion (..., T) and whether the car and the road allow it (...)."""

    times_s: Array
    speeds: SpeedHistory
    paths: Paths
    steering_rad: Array
    lateral_mps2: Array
    possible: NDArray[np.bool_]
    on_road: NDArray[np.bool_]

    def states(self, member: tuple[int, ...]) -> Array:
        """(T, 6): s, d, psi, v, a, delta of one member, given by its index in the members' broadcast shape."""
        shape = self.paths.s_m.shape
        v, a = (np.broadcast_to(q, shape)[member] for q in (self.speeds.speed_mps, self.speeds.acceleration_mps2))
        return np.column_stack(
            [self.paths.s_m[member], self.paths.d_m[member], self.paths.heading_rad[member], v, a, self.steering_rad[member]]
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Scored:
    """`separation_m`: the least of each member (at most `clearance.NEAR_M`); `contact_s`: its first contact, infinite without;
    `contact_with`: the index of that body, -1 without; `possible` and `on_road`: as rolled; `feasible`: both,
    and clear; `cost`: the smaller the better.
    """

    separation_m: Array
    contact_s: Array
    contact_with: NDArray[np.intp]
    possible: NDArray[np.bool_]
    on_road: NDArray[np.bool_]
    feasible: NDArray[np.bool_]
    cost: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """One member, by the indices of its phase and its lane-change profile, and what became of it."""

    phase: int
    profile: int
    cost: float
    separation_m: float
    contact_s: float
    contact_with: int
    feasible: bool


def roll_out(
    phases: Phases,
    profiles: LaneChangeProfiles,
    times_s: Array,
    host: HostState,
    vehicle: Vehicle,
    road: Road,
    demand: Demand | None = None,
) -> Rolled:
    """Motions of the members, at the broadcast shape of `phases` and `profiles`, on an even grid of times from 0.

    Possible means: the friction circle with the exact v^2 kappa, the steering angle, and the steering rate between samples.
    """
    share = demand or Demand()
    speeds = speed_history(phases, times_s, host.speed_mps, host.acceleration_mps2, vehicle)
    members = paths(profiles, speeds, times_s, host, vehicle, road)
    v, a = speeds.speed_mps, speeds.acceleration_mps2
    lateral = v * v * members.curvature_1pm
    steering = np.arctan(vehicle.wheelbase_m * members.curvature_1pm)
    grip = share.friction * road.friction * GRAVITY_MPS2
    turned = np.abs(np.diff(steering, axis=-1)).max(-1) / float(times_s[1] - times_s[0])
    possible = (
        ((a * a + lateral * lateral).max(-1) <= grip * grip)
        & (np.abs(steering).max(-1) <= share.steering * vehicle.steering_max_rad)
        & (turned <= share.steering * vehicle.steering_rate_max_radps)
    )
    room = 0.5 * (vehicle.width_m * members.cosine + vehicle.length_m * np.abs(members.sine)) + EDGE_M
    on_road = beyond_edges(members.s_m, members.d_m - room, members.d_m + room, vehicle, road).max(-1) <= 0.0
    if road.road_end_s_m is not None:
        on_road &= members.s_m.max(-1) + 0.5 * vehicle.length_m + EDGE_M <= road.road_end_s_m
    return Rolled(
        times_s=times_s, speeds=speeds, paths=members, steering_rad=steering, lateral_mps2=lateral, possible=possible, on_road=on_road
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Scoring:
    """How members are scored: the margins that bodies get, and the separation left that makes one feasible [m]."""

    margins: Margins = field(default_factory=Margins)
    clear_m: float = 0.0

    def __post_init__(self) -> None:
        require_types(self)
        require_every(self, non_negative)


def score(
    rolled: Rolled,
    prediction: Prediction,
    vehicle: Vehicle,
    road: Road,
    desired_speed_mps: float,
    lane_d_m: float,
    half_lane_m: float,
    scoring: Scoring,
) -> Scored:
    """Every member against everybody: separations, first contact, cost. The lane that it comes from has its middle at `lane_d_m`, and is
    twice `half_lane_m` wide."""
    times, members = rolled.times_s, rolled.paths
    near = clearance(members, times, prediction.bodies, vehicle, road, scoring.margins)
    contact_s, contact_with = first_contact(near, times, scoring.clear_m)
    least = near.separation_m.min(-1)
    feasible = rolled.possible & rolled.on_road & (least > scoring.clear_m)
    v, a = rolled.speeds.speed_mps, rolled.speeds.acceleration_mps2
    h = float(times[1] - times[0])
    along = h * (WEIGHTS.acceleration * (a * a).sum(-1) + WEIGHTS.speed * ((v - desired_speed_mps) ** 2).sum(-1))
    lateral = rolled.lateral_mps2
    across = h * WEIGHTS.lateral_acceleration * np.einsum("...t,...t->...", lateral, lateral)
    cost = np.asarray(across + along)
    close = np.flatnonzero(near.nearest.max(-1) >= 0)
    rows = near.separation_m.reshape(-1, times.size)[close]
    cost.reshape(-1)[close] += h * WEIGHTS.nearness * np.exp(np.maximum(rows, 0.0) * (-1.0 / NEARNESS_M)).sum(-1)
    away = np.abs(members.d_m[..., -1] - lane_d_m) > half_lane_m
    cost += WEIGHTS.lane_change * away
    cost += _end_closing(rolled, prediction, vehicle)
    return Scored(
        separation_m=least,
        contact_s=contact_s,
        contact_with=contact_with,
        possible=np.broadcast_to(rolled.possible, least.shape),
        on_road=np.broadcast_to(rolled.on_road, least.shape),
        feasible=feasible,
        cost=cost,
    )


def best_of_each(cost: Array, scored: Scored, kinds: NDArray[np.intp]) -> list[Member]:
    """The member of least cost of each kind, the cheapest first; in whole TICKs, ties to the first, and who costs infinitely is none."""
    order = np.argsort(np.rint(cost / TICK), axis=None, kind="stable")
    order = order[np.isfinite(cost.ravel()[order])]
    _, first = np.unique(kinds.ravel()[order], return_index=True)
    found = []
    for index in order[np.sort(first)]:
        p, q = (int(i) for i in np.unravel_index(index, cost.shape))
        own_cost, separation, contact = (float(of[p, q]) for of in (scored.cost, scored.separation_m, scored.contact_s))
        who, feasible = int(scored.contact_with[p, q]), bool(scored.feasible[p, q])
        found.append(
            Member(phase=p, profile=q, cost=own_cost, separation_m=separation, contact_s=contact, contact_with=who, feasible=feasible)
        )
    return found


def first_contact(near: Clearance, times_s: Array, clear_m: float) -> tuple[Array, NDArray[np.intp]]:
    """When each member first has no more than `clear_m` of separation left, and from whom; infinite and -1 where it never has."""
    hit = near.separation_m <= clear_m
    first = hit.argmax(-1)
    touched = hit.any(-1)
    who = np.take_along_axis(near.nearest, first[..., None], axis=-1)[..., 0]
    return np.where(touched, times_s[first], np.inf), np.where(touched, who, -1)


def _end_closing(rolled: Rolled, prediction: Prediction, vehicle: Vehicle) -> Array:
    """The cost of ending in front of somebody faster, or behind somebody slower."""
    members, end = rolled.paths, rolled.times_s[-1:]
    s, d, v = members.s_m[..., -1], members.d_m[..., -1], rolled.speeds.speed_mps[..., -1]
    total = np.zeros(s.shape)
    for body in prediction.bodies:
        motion = body.at(end)
        ahead = float(motion.s_m[0]) - s
        gap = np.maximum(np.abs(ahead) - 0.5 * (vehicle.length_m + body.length_m), 1.0)
        beside = np.abs(float(motion.d_m[0]) - d) - 0.5 * (body.width_m + vehicle.width_m) > WEIGHTS.end_room_m
        closing = np.maximum(np.sign(ahead) * (v - float(motion.speed_s_mps[0])), 0.0)
        total += np.where(beside, 0.0, WEIGHTS.end_closing * closing * closing / gap)
    return total
