"""The library of candidate manoeuvres that escapes are sought among."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array, finite, positive, within
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.axle_limits import driving_mps2
from mcdas_opt.manoeuvres.clearance import Margins
from mcdas_opt.manoeuvres.family import Demand
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.time_to_react.evasive_profiles import EvasiveProfiles
from mcdas_opt.time_to_react.predicted_traffic import PredictedTraffic

KINDS = ("brake", "accelerate", "left", "right")
SIDEWAYS = 2  # kinds from here on steer
SHORTEST_S = 0.5
_JUST = 0.98  # of what is comfortable
_BEND_SHARE = 0.9  # of the grip: no bend is counted to take more
_FASTER = 0.1  # of what a bend takes, more when it is driven faster


CLEAR_S = 4.0  # a candidate is open when it stays clear for so long after its start, and ends with room for what still closes in
LATEST_S = 10.0  # starts are not sought beyond it

# The manoeuvres were chosen, one by one, out of a library ten times as large for what they add to the last moments of 900 random
# situations. In the lane: (share of what the car can do, until [s]), 0 for until the front (rear) car's speed is reached; less than the
# least share for the shortest while is no braking (accelerating). Steering: (share of braking (-) or accelerating (+), until [s], share of
# the grip that this leaves).
BRAKING: tuple[tuple[float, float], ...] = (
    (0.99, 99.0),
    *((0.97, until) for until in (0.0, 0.5, 1.9)),
    *((0.96, until) for until in (0.6, 0.75, 0.9, 1.9)),
    *((0.95, until) for until in (0.0, 0.7, 0.85, 1.2, 1.4, 1.8, 2.8)),
    *((0.9, until) for until in (0.5, 0.85, 1.1, 1.6, 2.5, 3.6, 99.0)),
    *((0.84, until) for until in (0.5, 0.6, 1.8, 3.2)),
    *((0.78, until) for until in (0.5, 0.6, 0.75, 1.2, 1.35)),
    *((0.72, until) for until in (0.6, 1.35, 1.9, 3.1)),
    *((0.66, until) for until in (0.5, 1.0, 1.2, 2.2)),
    *((0.6, until) for until in (0.5, 0.6)),
    *((0.54, until) for until in (0.5, 0.6)),
    *((0.48, until) for until in (0.6, 3.1)),
    *((0.42, until) for until in (1.1, 1.35, 1.6, 1.9)),
    (0.36, 1.6),
    *((0.3, until) for until in (0.6, 0.7, 0.75, 0.85, 0.9, 1.4, 3.1, 99.0)),
    *((0.24, until) for until in (0.5, 0.6, 0.7, 0.75, 2.8)),
    *((0.18, until) for until in (0.5, 0.6, 0.9, 3.7)),
    *((0.12, until) for until in (0.5, 0.6, 1.9)),
)
ACCELERATING: tuple[tuple[float, float], ...] = (
    *((0.99, until) for until in (0.0, 0.7, 1.2, 1.4, 1.6, 2.2, 2.8, 3.2)),
    *((0.97, until) for until in (1.1, 1.35, 1.9, 2.6, 3.7)),
    *((0.96, until) for until in (0.9, 1.9, 2.2, 3.1)),
    *((0.95, until) for until in (0.0, 1.6, 1.8, 2.2, 2.8)),
    *((0.9, until) for until in (0.7, 0.85, 1.2, 2.0, 2.2, 99.0)),
    *((0.84, until) for until in (0.5, 0.7, 0.85, 1.0, 1.35, 3.2)),
    *((0.8, until) for until in (0.0, 3.5)),
    *((0.78, until) for until in (1.2, 1.9, 2.2, 2.5, 99.0)),
    *((0.72, until) for until in (0.0, 0.5, 0.85, 1.8, 2.2, 3.7)),
    *((0.66, until) for until in (0.5, 0.75, 1.6, 1.9, 2.2)),
    (0.54, 0.85),
    *((0.48, until) for until in (0.9, 1.8)),
    *((0.42, until) for until in (0.5, 2.6)),
    (0.36, 3.6),
    *((0.3, until) for until in (0.85, 1.35)),
    *((0.18, until) for until in (0.6, 0.7, 2.2, 3.1, 99.0)),
    *((0.12, until) for until in (0.5, 0.75, 1.6, 2.2, 3.1)),
)
STEERING: tuple[tuple[float, float, float], ...] = (
    *((0.0, 0.0, share) for share in (1.0, 0.97, 0.9, 0.5, 0.25, 0.13)),
    (0.97, 0.7, 1.08),
    *((0.97, 1.2, share) for share in (1.08, 0.85, 0.35, 0.15)),
    *((0.97, 2.0, share) for share in (1.08, 0.65)),
    *((0.97, 9.0, share) for share in (1.04, 1.0, 0.3, 0.25, 0.15)),
    *((0.95, 2.0, share) for share in (1.02, 0.5)),
    (0.95, 9.0, 0.2),
    (0.65, 0.7, 1.08),
    *((0.65, 1.2, share) for share in (1.08, 0.97)),
    (0.65, 2.0, 1.08),
    *((0.65, 9.0, share) for share in (0.85, 0.35)),
    (0.3, 0.7, 1.03),
    (-0.2, 9.0, 1.0),
    *((0.3, 1.2, share) for share in (1.08, 1.03, 1.02, 0.9)),
    *((0.3, 2.0, share) for share in (1.08, 0.97)),
    (-0.2, 0.45, 1.08),
    (-0.2, 0.5, 1.02),
    (-0.2, 0.8, 1.08),
    (-0.2, 1.2, 1.0),
    *((-0.4, 0.45, share) for share in (1.08, 1.03)),
    *((-0.4, until, 0.5) for until in (0.5, 0.8)),
    (-0.4, 0.9, 0.97),
    (-0.4, 2.0, 1.02),
    (-0.4, 9.0, 0.97),
    (-0.6, 0.45, 0.75),
    *((-0.6, 9.0, share) for share in (1.08, 0.97, 0.3)),
    (-0.75, 0.45, 0.92),
    (-0.75, 0.9, 1.02),
    (-0.75, 1.2, 0.97),
    (-0.8, 1.4, 0.65),
    (-0.9, 0.45, 1.08),
    (-0.9, 0.8, 1.08),
    *((-0.9, 1.2, share) for share in (1.08, 0.85, 0.3, 0.25, 0.15)),
    (-0.9, 1.8, 0.65),
    (-0.9, 2.5, 1.0),
    (-0.92, 2.0, 0.5),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class EscapeSettings:
    """A candidate is comfortable that asks no more of the tyres than `comfort_mps2` and `comfort_share` of the grip. `clear_m` is kept
    from bodies (less than 0: they may overlap by so much); `margins` grow them. `demand` is what may be asked of car and road."""

    comfort_mps2: float = 3.0
    comfort_share: float = 0.7
    clear_m: float = 0.01
    demand: Demand = field(default_factory=lambda: Demand(friction=1.0, steering=1.0))
    margins: Margins = field(default_factory=Margins)

    def __post_init__(self) -> None:
        require_types(self)
        positive("escapes.comfort_mps2", self.comfort_mps2, "m/s^2")
        within("escapes.comfort_share", self.comfort_share, 0.05, 1.0)
        finite("escapes.clear_m", self.clear_m, "m")

    def comfort_on(self, friction: float) -> float:
        """What counts as comfortable there [m/s^2]."""
        return min(self.comfort_mps2, self.comfort_share * friction * GRAVITY_MPS2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Members:
    """Columns (M,): which kind, and what it does. A phase ends by the clock, or where `until_mps` is reached (NaN without). And which
    members are of each kind."""

    kind: NDArray[np.intp]
    of_kind: tuple[NDArray[np.intp], ...]
    level_mps2: Array
    until_s: Array
    until_mps: Array
    target_d_m: Array
    lateral_mps2: Array
    shortest_s: float
    straightening_mps2: float

    def varied(self, member: int, factors: Array) -> Members:
        """One member, its level, its time and its push times these factors (V, 3)."""
        same = np.full(len(factors), member)
        level, until, push = factors.T
        return replace(
            self,
            kind=self.kind[same],
            level_mps2=self.level_mps2[same] * level,
            until_s=self.until_s[same] * until,
            until_mps=self.until_mps[same],
            target_d_m=self.target_d_m[same],
            lateral_mps2=self.lateral_mps2[same] * push,
        )

    def rows(self, member: Any, speed_mps: Array) -> tuple[EvasiveProfiles, NDArray[np.bool_]]:
        """Members (R,) begun at these speeds (R,), and which of them do anything."""
        level, ends = self.level_mps2[member], self.until_mps[member]
        matching = ~np.isnan(ends)
        until = np.where(matching, (ends - speed_mps) / np.where(level == 0.0, 1.0, level), self.until_s[member])
        acts = ~matching | (until >= self.shortest_s)
        rows = EvasiveProfiles(
            level_mps2=np.where(acts, level, 0.0),
            until_s=np.where(acts, until, 0.0),
            target_d_m=self.target_d_m[member],
            lateral_mps2=self.lateral_mps2[member],
        )
        return rows, acts


def members(situation: Situation, vehicle: Vehicle, traffic: PredictedTraffic, chosen: EscapeSettings) -> Members:
    sides = next_lane_m(situation, vehicle, Side.LEFT), next_lane_m(situation, vehicle, Side.RIGHT)
    of = forces(situation.road, situation.host, vehicle, chosen)
    spread = spread_of(sides[0] is not None, sides[1] is not None)
    level, push = _taken(spread, of)
    targets = np.array([np.nan, np.nan, *(np.nan if side is None else side for side in sides)])
    ends = np.array([*_speeds_of_nearest(situation, traffic), np.nan])
    return Members(
        kind=spread.kind,
        of_kind=spread.of_kind,
        level_mps2=level,
        until_s=spread.until_s,
        until_mps=ends[spread.matching],
        target_d_m=targets[spread.kind],
        lateral_mps2=push,
        shortest_s=SHORTEST_S,
        straightening_mps2=of.gentle,
    )


class Forces(NamedTuple):
    """What there is [m/s^2]: the grip, what a bend takes of it, braking, accelerating, what is comfortable, and what is gentle."""

    grip: float
    bend: float
    brake: float
    accelerate: float
    comfort: float
    gentle: float


class Spread(NamedTuple):
    """Columns (M,) that no situation changes: the kind; the pace as a share of the braking (-) or the accelerating there is, and which of
    the two; until [s]; the share across, 0 for what is comfortable; whose speed is matched: 0 ahead, 1 behind, 2 nobody's."""

    kind: NDArray[np.intp]
    pace: Array
    limit: NDArray[np.intp]
    until_s: Array
    push: Array
    matching: NDArray[np.intp]
    comfortable: NDArray[np.intp]
    in_lane: int
    of_kind: tuple[NDArray[np.intp], ...]


def forces(road: Road, host: HostState, vehicle: Vehicle, chosen: EscapeSettings) -> Forces:
    """What this host has there; nothing of the host matters where the road is straight."""
    grip = road.grip_mps2
    bend = 0.0
    if not road.is_straight:
        bend = min(host.speed_mps**2 * abs(float(road.curvature_at(host.s_m))), _BEND_SHARE * grip)
    spare = math.sqrt(grip * grip - bend * bend)
    brake, accelerate = min(-vehicle.acceleration_min_mps2, spare), min(driving_mps2(vehicle, road.friction), spare - _FASTER * bend)
    return Forces(grip, bend, brake, accelerate, _JUST * chosen.comfort_on(road.friction), min(1.0, 0.2 * grip))


@lru_cache(maxsize=4)
def spread_of(left: bool, right: bool) -> Spread:
    """With lanes to these sides: each kind's own, and behind them the comfortable ones."""
    rows: list[tuple[int, float, float, float]] = []
    comfortable: list[int] = []
    for kind, sign, own in ((0, -1.0, BRAKING), (1, 1.0, ACCELERATING)):
        rows += [(kind, sign * share, until, 1.0) for share, until in (*own, (1.0, 0.0), (1.0, 2.0))]
        comfortable += [len(rows) - 2, len(rows) - 1]
    in_lane = len(rows)
    for kind, there in ((2, left), (3, right)):
        if there:
            rows += [(kind, *own) for own in (*STEERING, (0.0, 0.0, 0.0))]
    kinds, pace, until, push = np.ascontiguousarray(np.array(rows).T)
    kind = kinds.astype(np.intp)
    matching = np.where((until > 0.0) | (kind >= SIDEWAYS), 2, kind)
    of_kind = tuple(np.flatnonzero(kind == k) for k in range(len(KINDS)))
    return Spread(kind, pace, (pace > 0.0).astype(np.intp), until, push, matching, np.array(comfortable), in_lane, of_kind)


def _taken(spread: Spread, f: Forces) -> tuple[Array, Array]:
    level = spread.pace * np.array([f.brake, f.accelerate])[spread.limit]
    level[spread.comfortable] = np.minimum(np.maximum(level[spread.comfortable], -f.comfort), f.comfort)
    push = spread.push * np.maximum(np.sqrt(f.grip * f.grip - level * level) - f.bend, 0.1 * f.grip)
    push[spread.push == 0.0] = min(f.comfort, f.grip)
    push[: spread.in_lane] = f.gentle
    return level, push


def _speeds_of_nearest(situation: Situation, traffic: PredictedTraffic) -> tuple[float, float]:
    """Speed of the nearest body ahead and behind in the host's way; -inf and inf where there is nobody."""
    host, width = situation.host, 0.5 * situation.road.lane_width_m + 0.5
    ahead, behind, front, rear = np.inf, np.inf, -np.inf, np.inf
    for s, d, speed in zip(traffic.s_m[:, 0].tolist(), traffic.d_m[:, 0].tolist(), traffic.speed_mps[:, 0].tolist(), strict=True):
        apart = s - host.s_m
        if abs(d - host.d_m) < width and 0.0 < apart < ahead:
            ahead, front = apart, speed
        if abs(d - host.d_m) < width and 0.0 < -apart < behind:
            behind, rear = -apart, speed
    return front, rear
