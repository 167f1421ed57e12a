"""The best few of different kind: which side, early or late, slower or faster; what a local optimiser is told to begin with."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.manoeuvres.clearance import Margins
from mcdas_opt.manoeuvres.family import Member, Scoring, best_of_each
from mcdas_opt.manoeuvres.lane_change_profiles import LaneChangeProfiles
from mcdas_opt.manoeuvres.members import Members, members
from mcdas_opt.manoeuvres.phases import Phases

# what the family is spread over: shares of what car and road can do
LATERAL_SHARES = (0.3, 0.5, 0.7, 0.88)  # of mu g
DELAYS_S = (0.0, 0.3, 0.7, 1.2, 1.9)
EARLY_S = 0.5  # a delay up to this is early
SPEEDS: tuple[tuple[float, float, float], ...] = (  # share, until [s], share; negative shares brake
    *((share, 0.0, share) for share in (0.0, -0.3, -0.6, -0.92, 0.45, 0.95)),
    (-0.92, 0.8, 0.0),
    (-0.5, 1.2, 0.0),
    (0.95, 1.0, 0.0),
    (0.95, 1.2, -0.6),
)
KEEPING_MPS2 = 1.0  # how hard the car is brought back to the middle of its lane
DODGE_ROOM_M = 0.35  # from flank to flank, where no lane change is clear and the car only dodges the one ahead or behind
MOST_DODGED = 16  # bodies in the way, the nearest: the work stays bounded
SOFTNESS = 50.0  # b of the sigmoid
APART_MPS = 1.5  # a member that is faster (slower) ends so by this much
CLEAR_M = 0.05  # left to everybody
USUAL = Scoring(margins=Margins(along_m=0.5, across_m=0.25, share_of_prediction=1.0), clear_m=CLEAR_M)
TIGHT = Scoring(margins=Margins(along_m=0.1, across_m=0.1), clear_m=CLEAR_M)  # where nothing is clear with those

_STEP_S = 0.1
STEERABLE_MPS = 0.5  # who is slower stands


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """One member: numbers to build a reference from, and its sampled states (N + 1, 6) for a guess.

    `member.feasible` false: nothing of this kind keeps clear; the one that has its first contact last, or the most room.
    """

    side: Side
    early: bool
    pace: str  # "slower", "same", "faster"
    target_d_m: float
    lateral_mps2: float
    delay_s: float
    softness: float
    end_speed_mps: float
    states: Array
    member: Member


def next_lane_m(situation: Situation, vehicle: Vehicle, side: Side) -> float | None:
    """The middle of the next lane, else of a shoulder that holds the car; None when there is neither."""
    road = situation.road
    lane = situation.lane_beside(side)
    if road.goes_on(lane, situation.host.s_m, situation.host.speed_mps):
        return road.lane_centre_m(lane, situation.host.s_m)
    shoulder, edge = (
        (road.shoulder_left_m, float(road.left_edge_at(situation.host.s_m)))
        if side is Side.LEFT
        else (road.shoulder_right_m, float(road.right_edge_at(situation.host.s_m)))
    )
    return edge - side.sign * 0.5 * shoulder if shoulder >= vehicle.width_m + 0.5 else None


def _times(grid: TimeGrid) -> Array:
    return _even(round(float(grid.times_s[-1]) / _STEP_S))


@lru_cache(maxsize=16)
def _even(steps: int) -> Array:
    times = np.round(np.arange(steps + 1) * _STEP_S, 9)
    times.setflags(write=False)
    return times


def best_of_kind(
    situation: Situation,
    vehicle: Vehicle,
    prediction: Prediction,
    *,
    most: int = 4,
    grid: TimeGrid | None = None,
) -> tuple[Choice, ...]:
    """The cheapest member of each kind that keeps clear of everybody, at most `most` of them, cheapest first.

    Keeping the lane is a kind for each pace, without early or late. Where no member at all is clear: the ones that are so for longest.
    Where nothing is clear with the usual margins, tight ones do, and then members that only dodge those in the way (`target_d_m`).
    `grid` is the one that `states` are sampled on (the family itself is looked at every 0.1 s).
    """
    times = _times(grid or TimeGrid())
    found = _found(_profiles(situation, _lane_changes(situation, vehicle)), times, situation, vehicle, prediction)
    best = found.members.best(USUAL, found.kinds) or found.members.best(TIGHT, found.kinds)
    if not best:
        dodges = _dodges(situation, vehicle, prediction)
        if dodges:
            other = _found(_profiles(situation, dodges), times, situation, vehicle, prediction)
            best = other.members.best(TIGHT, other.kinds)
            found = other if best else found
    best = best or _least_bad(found)
    wanted = None if grid is None else grid.times_s
    if wanted is not None and wanted.shape == times.shape and np.abs(wanted - times).max() <= 1e-6:
        wanted = None
    return tuple(_choice(member, found, times, wanted, situation) for member in best[:most])


@dataclass(frozen=True, slots=True, kw_only=True)
class _Found:
    """Lane-change profiles and their sides (1, Q: 1 left, -1 right, 0 keep), the kinds (P, Q) of the members, and these."""

    profiles: LaneChangeProfiles
    sides: NDArray[np.intp]
    kinds: NDArray[np.intp]
    members: Members


def _found(
    changes: tuple[LaneChangeProfiles, NDArray[np.intp]],
    times: Array,
    situation: Situation,
    vehicle: Vehicle,
    prediction: Prediction,
) -> _Found:
    speed, (profiles, sides) = situation.host.speed_mps, changes
    phases = _phases(vehicle, situation.road, speed, situation.wanted_speed_mps)
    these = members(phases, profiles, times, situation, vehicle, prediction)
    end = these.end_speed_mps
    pace = np.where(end > speed + APART_MPS, 2, np.where(end < speed - APART_MPS, 0, 1))
    early = (profiles.delay_s <= EARLY_S) | (sides == 0)
    return _Found(profiles=profiles, sides=sides, kinds=pace + (3 * early + 6 * (sides + 1)), members=these)


def _least_bad(found: _Found) -> list[Member]:
    """Where nothing is clear: of each kind what the car and the road allow, and is so for longest."""
    scored = found.members.scored(USUAL)
    lost = 1e6 * ~scored.possible + 1e4 * ~scored.on_road
    cost = lost - 10.0 * np.minimum(scored.contact_s, 100.0) - scored.separation_m + 1e-3 * scored.cost
    return best_of_each(cost, scored, found.kinds)


def _lane_changes(situation: Situation, vehicle: Vehicle) -> list[tuple[float, float]]:
    """(target d, side) of the next lanes or shoulders."""
    ends = [(next_lane_m(situation, vehicle, side), sign) for side, sign in ((Side.LEFT, 1.0), (Side.RIGHT, -1.0))]
    return [(target, sign) for target, sign in ends if target is not None]


def _dodges(situation: Situation, vehicle: Vehicle, prediction: Prediction) -> list[tuple[float, float]]:
    """(target d, side) just past the flanks of those in the host's way, the nearest so many, as far as the road goes."""
    host, road, now = situation.host, situation.road, np.zeros(1)
    half = 0.5 * vehicle.width_m
    lowest, highest = float(road.right_edge_at(host.s_m)) + half, float(road.left_edge_at(host.s_m)) - half
    places = [(body, body.at(now)) for body in prediction.bodies]
    places = [(body, place) for body, place in places if abs(place.d_m[0] - host.d_m) < half + 0.5 * body.width_m]
    if len(places) > MOST_DODGED:
        places = sorted(places, key=lambda one: abs(float(one[1].s_m[0]) - host.s_m))[:MOST_DODGED]
    ends = [
        (float(place.d_m[0]) + sign * (half + 0.5 * body.width_m + DODGE_ROOM_M), sign) for body, place in places for sign in (1.0, -1.0)
    ]
    return [(target, sign) for target, sign in ends if lowest < target < highest]


def _phases(vehicle: Vehicle, road: Road, speed_mps: float, wanted_mps: float) -> Phases:
    """(P, 1): hold, one phase, two phases; and towards the wanted speed, when that is another."""
    brake, accelerate = available_mps2(vehicle, road.friction)
    rows = list(SPEEDS)
    levels = [tuple(x * (accelerate if x > 0.0 else brake) for x in (first, then)) for first, _, then in rows]
    gap = wanted_mps - speed_mps
    if abs(gap) > 0.5:
        pull = min(max(gap / 2.0, -0.3 * brake), 0.6 * accelerate)
        rows.append((0.0, gap / pull, 0.0))
        levels.append((pull, 0.0))
    first, then = np.array(levels).T[..., None]
    return Phases(first_mps2=first, switch_s=np.array([[t] for _, t, _ in rows]), then_mps2=then)


def _profiles(situation: Situation, ends: list[tuple[float, float]]) -> tuple[LaneChangeProfiles, NDArray[np.intp]]:
    """(1, Q): keep the lane, and to each of the ends (target d, side)."""
    host, road = situation.host, situation.road
    grip = road.grip_mps2
    rows = [(road.lane_centre_m(situation.host_lane, host.s_m), min(KEEPING_MPS2, 0.5 * grip), 0.0, 0.0)]
    if host.speed_mps >= STEERABLE_MPS:
        spread = tuple(product(LATERAL_SHARES, DELAYS_S))
        rows += [(target, share * grip, delay, sign) for target, sign in ends for share, delay in spread]
    target_d, push, delay, sides = np.array(rows).T[:, None, :]
    softness = np.full(target_d.shape, SOFTNESS)
    return LaneChangeProfiles(target_d_m=target_d, lateral_mps2=push, delay_s=delay, b=softness), sides.astype(np.intp)


def _choice(
    member: Member,
    found: _Found,
    times: Array,
    wanted: Array | None,
    situation: Situation,
) -> Choice:
    profiles, p, q = found.profiles, member.phase, member.profile
    states = found.members.states(p, q)
    states[0] = situation.host.to_vector()
    if wanted is not None:
        states = np.column_stack([np.interp(wanted, times, column) for column in states.T])
    sign, delay = int(found.sides[0, q]), float(profiles.delay_s[0, q])
    gained = float(states[-1, 3]) - situation.host.speed_mps
    pace = "faster" if gained > APART_MPS else "slower" if gained < -APART_MPS else "same"
    return Choice(
        side={1: Side.LEFT, -1: Side.RIGHT, 0: Side.NONE}[sign],
        early=sign == 0 or delay <= EARLY_S,
        pace=pace,
        target_d_m=float(profiles.target_d_m[0, q]),
        lateral_mps2=float(profiles.lateral_mps2[0, q]),
        delay_s=delay,
        softness=float(profiles.b[0, q]),
        end_speed_mps=float(states[-1, 3]),
        states=states,
        member=member,
    )
