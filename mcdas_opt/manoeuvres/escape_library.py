"""The manoeuvres that escapes are sought among."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.manoeuvres.clearance import Margins
from mcdas_opt.manoeuvres.family import Demand
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.manoeuvres.swerves import Swerves

KINDS = ("brake", "accelerate", "left", "right")
SIDEWAYS = 2  # kinds from here on steer
_SHORTEST_S = 0.5
_JUST = 0.98  # of what is comfortable
_BEND_SHARE = 0.9  # of the grip: no bend is counted to take more
_FASTER = 0.1  # of what a bend takes, more when it is driven faster


@dataclass(frozen=True, slots=True, kw_only=True)
class EscapeSettings:
    """`clear_s`: a way out counts when it stays clear for so long after its start, and ends with room for what still closes in.
    `latest_s`: starts are not sought beyond it. A way out is comfortable that asks no more of the tyres than `comfort_mps2` and
    `comfort_share` of the grip. `clear_m` is kept from bodies; `margins` grow them.

    The manoeuvres were chosen, one by one, out of a library ten times as large for what they add to the last moments of 900 random
    situations. In the lane: (share of what the car can do, until [s]), 0 for until the front (rear) car's speed is reached; less than
    the least share for the shortest while is no braking (accelerating). Sideways: (share of braking (-) or accelerating (+), until [s],
    share of the grip that this leaves).
    """

    clear_s: float = 4.0
    latest_s: float = 10.0
    comfort_mps2: float = 3.0
    comfort_share: float = 0.7
    braking: tuple[tuple[float, float], ...] = (
        (0.99, 99.0),
        *((0.95, until) for until in (0.0, 0.7, 0.85, 1.2, 1.4, 1.8, 2.8)),
        *((0.9, until) for until in (0.85, 1.6, 2.5, 3.6, 99.0)),
        *((0.84, until) for until in (0.5, 0.6, 1.8, 3.2)),
        *((0.78, until) for until in (0.5, 0.6, 1.2)),
        *((0.66, until) for until in (0.5, 1.0, 1.2, 2.2)),
        *((0.6, until) for until in (0.5, 0.6)),
        *((0.54, until) for until in (0.5, 0.6)),
        (0.42, 1.6),
        *((0.3, until) for until in (0.6, 0.7, 0.85, 1.4, 99.0)),
        *((0.24, until) for until in (0.5, 0.7, 2.8)),
        *((0.18, until) for until in (0.5, 0.6)),
        (0.12, 0.5),
    )
    accelerating: tuple[tuple[float, float], ...] = (
        *((0.99, until) for until in (0.0, 0.7, 1.2, 1.4, 1.6, 2.2, 2.8, 3.2)),
        *((0.95, until) for until in (0.0, 1.6, 1.8, 2.2, 2.8)),
        *((0.9, until) for until in (0.7, 0.85, 1.2, 2.0, 99.0)),
        *((0.84, until) for until in (0.7, 0.85, 1.0, 3.2)),
        *((0.78, until) for until in (1.2, 2.5)),
        *((0.72, until) for until in (0.85, 1.8, 2.2)),
        *((0.66, until) for until in (0.5, 1.6)),
        (0.54, 0.85),
        (0.48, 1.8),
        (0.42, 0.5),
        (0.36, 3.6),
        (0.3, 0.85),
        *((0.18, until) for until in (0.6, 0.7, 2.2, 99.0)),
        *((0.12, until) for until in (0.5, 1.6)),
    )
    sideways: tuple[tuple[float, float, float], ...] = (
        *((0.0, 0.0, share) for share in (0.97, 0.9, 0.5, 0.25, 0.13)),
        *((0.95, 2.0, share) for share in (1.02, 0.8, 0.5, 0.15)),
        (0.95, 0.8, 1.02),
        (0.95, 9.0, 0.2),
        *((0.65, 2.0, share) for share in (0.97, 0.35)),
        (0.65, 0.8, 0.95),
        (0.35, 2.0, 0.9),
        *((0.3, 1.2, share) for share in (1.02, 0.9)),
        (0.65, 9.0, 0.5),
        (-0.2, 0.5, 1.02),
        (-0.2, 0.9, 0.2),
        (-0.4, 0.5, 0.5),
        (-0.4, 0.9, 0.97),
        (-0.6, 0.5, 0.97),
        (-0.8, 2.0, 0.97),
        (-0.9, 0.5, 0.35),
        (-0.9, 1.2, 0.3),
        (-0.75, 0.9, 1.02),
        *((-0.75, 2.0, share) for share in (0.5, 0.3)),
        *((-0.6, 9.0, share) for share in (0.97, 0.3)),
        (-0.4, 2.0, 1.02),
        (-0.8, 1.4, 0.65),
        (-0.92, 2.0, 0.5),
    )
    clear_m: float = 0.03
    demand: Demand = field(default_factory=lambda: Demand(friction=1.0, steering=1.0))
    margins: Margins = field(default_factory=Margins)

    def comfort_on(self, friction: float) -> float:
        """What counts as comfortable there [m/s^2]."""
        return min(self.comfort_mps2, self.comfort_share * friction * GRAVITY_MPS2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Members:
    """Columns (M,): which kind, and what it does. A phase ends by the clock, or where `until_mps` is reached (NaN without)."""

    kind: NDArray[np.intp]
    level_mps2: Array
    until_s: Array
    until_mps: Array
    target_d_m: Array
    lateral_mps2: Array
    shortest_s: float
    straightening_mps2: float

    def rows(self, member: Any, speed_mps: Array) -> tuple[Swerves, NDArray[np.bool_]]:
        """Members (R,) begun at these speeds (R,), and which of them do anything."""
        level, ends = self.level_mps2[member], self.until_mps[member]
        matching = ~np.isnan(ends)
        until = np.where(matching, (ends - speed_mps) / np.where(level == 0.0, 1.0, level), self.until_s[member])
        acts = ~matching | (until >= self.shortest_s)
        rows = Swerves(
            level_mps2=np.where(acts, level, 0.0),
            until_s=np.where(acts, until, 0.0),
            target_d_m=self.target_d_m[member],
            lateral_mps2=self.lateral_mps2[member],
        )
        return rows, acts


def members(situation: Situation, vehicle: Vehicle, prediction: Prediction, chosen: EscapeSettings) -> Members:
    road = situation.road
    grip = road.friction * GRAVITY_MPS2
    bend = min(situation.host.speed_mps**2 * abs(float(road.curvature_at(situation.host.s_m))), _BEND_SHARE * grip)
    spare = np.sqrt(grip * grip - bend * bend)
    brake, accelerate = min(-vehicle.acceleration_min_mps2, spare), min(vehicle.acceleration_max_mps2, spare - _FASTER * bend)
    comfort = _JUST * chosen.comfort_on(road.friction)
    braking, accelerating, sideways = _spread(chosen)
    gentle = min(1.0, 0.2 * grip)
    levels, untils, matches, targets, pushes = [], [], [], [], []
    for sign, most, spread in ((-1.0, brake, braking), (1.0, accelerate, accelerating)):
        speed = _speed_of_nearest(situation, prediction, -sign)
        level = spread[0] * most
        level[-2:] = min(comfort, most)
        levels.append(sign * level)
        untils.append(spread[1])
        matches.append(np.where(spread[1] > 0.0, np.nan, sign * np.inf if speed is None else speed))
        targets.append(np.full(level.size, np.nan))
        pushes.append(np.full(level.size, gentle))
    kinds = [np.repeat([0, 1], [levels[0].size, levels[1].size])]
    level = sideways[0] * np.where(sideways[0] > 0.0, accelerate, brake)
    push = sideways[2] * np.maximum(np.sqrt(grip * grip - level * level) - bend, 0.1 * grip)
    push[-1] = min(comfort, grip)
    for kind, side in ((2, Side.LEFT), (3, Side.RIGHT)):
        target = next_lane_m(situation, vehicle, side)
        if target is None:
            continue
        kinds.append(np.full(level.size, kind))
        levels.append(level)
        untils.append(sideways[1])
        matches.append(np.full(level.size, np.nan))
        targets.append(np.full(level.size, target))
        pushes.append(push)
    return Members(
        kind=np.concatenate(kinds).astype(np.intp),
        level_mps2=np.concatenate(levels),
        until_s=np.concatenate(untils),
        until_mps=np.concatenate(matches),
        target_d_m=np.concatenate(targets),
        lateral_mps2=np.concatenate(pushes),
        shortest_s=_SHORTEST_S,
        straightening_mps2=gentle,
    )


@lru_cache(maxsize=8)
def _spread(chosen: EscapeSettings) -> tuple[Array, Array, Array]:
    """Columns of shares, untils (and shares across): braking, accelerating, sideways; the last of each are the comfortable ones."""
    in_lane = [np.array([*spread, (0.0, 0.0), (0.0, 2.0)]).T for spread in (chosen.braking, chosen.accelerating)]
    return in_lane[0], in_lane[1], np.array([*chosen.sideways, (0.0, 0.0, 0.0)]).T


def _speed_of_nearest(situation: Situation, prediction: Prediction, sign: float) -> float | None:
    """Speed of the nearest body ahead (1) or behind (-1) in the host's way; None when there is nobody."""
    host, now = situation.host, np.zeros(1)
    best, speed = np.inf, None
    for body in prediction.bodies:
        motion = body.at(now)
        apart = sign * (float(motion.s_m[0]) - host.s_m)
        if 0.0 < apart < best and abs(float(motion.d_m[0]) - host.d_m) < 0.5 * situation.road.lane_width_m + 0.5:
            best, speed = apart, float(motion.speed_s_mps[0])
    return speed
