"""The manoeuvres that the escape map is measured against: its own, some ten times more around them, and variations of the best."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.manoeuvres.family import Rolled
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.manoeuvres.lane_change_profiles import LaneChangeProfiles
from mcdas_opt.manoeuvres.paths import Paths
from mcdas_opt.manoeuvres.phases import Phases, SpeedHistory
from mcdas_opt.time_to_react.effort import LEAST
from mcdas_opt.time_to_react.evasive_profiles import Motions
from mcdas_opt.time_to_react.library import KINDS, EscapeSettings, Members, members
from mcdas_opt.time_to_react.predicted_traffic import PredictedTraffic, Rows

STEP_S = 0.02
DRIVE_NODES = np.arange(201)
_DRIVE_S = np.round(DRIVE_NODES * STEP_S, 9)
_DRIVEN = 32


def finer(situation: Situation, vehicle: Vehicle, traffic: PredictedTraffic, prediction: Prediction, settings: EscapeSettings) -> Members:
    """The map's own members, and a grid around them that is some ten times finer."""
    own = members(situation, vehicle, traffic, settings)
    grip = situation.road.friction * GRAVITY_MPS2
    brake, accelerate = available_mps2(vehicle, situation.road.friction)
    speeds = [float(body.at(np.zeros(1)).speed_s_mps[0]) for body in prediction.bodies]
    grid: list[tuple[float, ...]] = []
    for kind, most in enumerate((-brake, accelerate)):
        for level in most * np.linspace(0.12, 1.0, 23):
            ends = [(99.0, np.nan), *((end, np.nan) for end in np.arange(0.5, 4.0, 0.25)), *((0.0, speed) for speed in speeds)]
            grid += [(kind, level, *end, np.nan, min(1.0, 0.2 * grip)) for end in ends]
    paces = [(0.0, 0.0)] + [(x * accelerate, t) for x in (0.3, 0.6, 0.97) for t in (0.7, 1.2, 2.0, 9.0)]
    paces += [(-x * brake, t) for x in (0.2, 0.4, 0.6, 0.75, 0.9) for t in (0.4, 0.8, 1.2, 1.8, 9.0)]
    shares = (0.12, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.88, 0.94, 0.98, 1.0)
    shares += (1.03, 1.08)  # the lane change leaves some of it for what braking does across
    for kind, side in ((2, Side.LEFT), (3, Side.RIGHT)):
        target = next_lane_m(situation, vehicle, side)
        if target is not None:
            spread = product(paces, shares)
            grid += [(kind, level, until, np.nan, target, share * np.sqrt(grip**2 - level**2)) for (level, until), share in spread]
    columns = (own.kind, own.level_mps2, own.until_s, own.until_mps, own.target_d_m, own.lateral_mps2)
    kind, level, until, speed, target_d, push = (np.concatenate(q) for q in zip(columns, np.array(grid).T, strict=True))
    kinds = kind.astype(np.intp)
    return replace(
        own,
        kind=kinds,
        of_kind=tuple(np.flatnonzero(kinds == k) for k in range(len(KINDS))),
        level_mps2=level,
        until_s=until,
        until_mps=speed,
        target_d_m=target_d,
        lateral_mps2=push,
    )


def some_of(among: Members, found: Rows) -> Members:
    """Some members, at most so many, from all over."""
    chosen = spread(found)
    columns = ("kind", "level_mps2", "until_s", "until_mps", "target_d_m", "lateral_mps2")
    return replace(among, **{name: getattr(among, name)[chosen] for name in columns})


def varied_around(known: Members, width: tuple[float, float, float], brake_mps2: float, accelerate_mps2: float) -> Members:
    """Around each of these a grid of levels, times and pushes."""
    level, until, push = (np.array(q) for q in zip(*product(*((1.0 - x, 1.0, 1.0 + x) for x in width)), strict=True))
    each = {name: np.repeat(getattr(known, name), level.size) for name in ("kind", "until_mps", "target_d_m")}
    levels, untils = np.outer(known.level_mps2, level).reshape(-1), np.outer(known.until_s, until).reshape(-1)
    low = np.where(each["kind"] == 1, LEAST * accelerate_mps2, -brake_mps2)  # less is no braking, no accelerating
    high = np.where(each["kind"] == 0, -LEAST * brake_mps2, accelerate_mps2)
    return replace(
        known,
        **each,
        level_mps2=np.clip(levels, low, high),
        until_s=np.where((each["kind"] < 2) & np.isnan(each["until_mps"]), np.maximum(untils, known.shortest_s), untils),
        lateral_mps2=np.outer(known.lateral_mps2, push).reshape(-1),
    )


def sigmoids(target_d_m: float, road: Road, vehicle: Vehicle) -> tuple[Phases, LaneChangeProfiles]:
    """Sigmoids to there, in rows (R,)."""
    grip = road.friction * GRAVITY_MPS2
    brake, accelerate = available_mps2(vehicle, road.friction)
    paces = [(0.0, 9.0), (0.4 * accelerate, 9.0), (0.9 * accelerate, 1.0), (0.9 * accelerate, 9.0)]
    paces += [(-x * brake, t) for x in (0.3, 0.6, 0.8) for t in (0.8, 1.5, 9.0)]
    pushes = [share * grip for share in (0.2, 0.35, 0.5, 0.6, 0.7, 0.8, 0.9)]
    rows = [(a, t, push, b) for (a, t), push, b in product(paces, pushes, (50.0, 20.0, 8.0))]
    first, until, push_mps2, b = np.array(rows).T
    nothing = np.zeros(len(rows))
    phases = Phases(first_mps2=first, switch_s=until, then_mps2=nothing)
    return phases, LaneChangeProfiles(target_d_m=nothing + target_d_m, lateral_mps2=push_mps2, delay_s=nothing, b=b)


def spread(found: Rows) -> Rows:
    """At most so many of them, from all over."""
    if found.size <= _DRIVEN:
        return found
    return found[np.linspace(0, found.size - 1, _DRIVEN).astype(np.intp)]


def rows_of(motions: Motions, chosen: Rows) -> Motions:
    return Motions(**{name: getattr(motions, name)[chosen] for name in Motions.__dataclass_fields__})


def rolled_from(motions: Motions, vehicle: Vehicle) -> Rolled:
    heading = np.arcsin(motions.sine)
    return Rolled(
        times_s=_DRIVE_S,
        speeds=SpeedHistory(acceleration_mps2=motions.acceleration_mps2, speed_mps=motions.speed_mps, travelled_m=motions.s_m),
        paths=Paths(
            s_m=motions.s_m,
            d_m=motions.d_m,
            heading_rad=heading,
            sine=motions.sine,
            cosine=motions.cosine,
            curvature_1pm=motions.curvature_1pm,
        ),
        steering_rad=np.arctan(vehicle.wheelbase_m * motions.curvature_1pm),
        lateral_mps2=motions.speed_mps**2 * motions.curvature_1pm,
        possible=motions.possible,
        on_road=motions.on_road,
    )


def motions_from(rolled: Rolled) -> Motions:
    paths = rolled.paths
    return Motions(
        s_m=paths.s_m,
        d_m=paths.d_m,
        sine=paths.sine,
        cosine=paths.cosine,
        speed_mps=np.broadcast_to(rolled.speeds.speed_mps, paths.s_m.shape),
        acceleration_mps2=np.broadcast_to(rolled.speeds.acceleration_mps2, paths.s_m.shape),
        curvature_1pm=paths.curvature_1pm,
        demand_mps2=np.zeros(paths.s_m.shape[0]),
        ability=np.where(rolled.possible, 0.0, -1.0),
        edge_m=np.where(rolled.on_road, 0.0, -1.0),
    )


def motions_driven(drive: Trajectory) -> Motions:
    sine, cosine = np.sin(drive.heading_rad), np.cos(drive.heading_rad)
    return Motions(
        s_m=drive.s_m[None],
        d_m=drive.d_m[None],
        sine=sine[None],
        cosine=cosine[None],
        speed_mps=drive.speed_mps[None],
        acceleration_mps2=drive.acceleration_mps2[None],
        curvature_1pm=sine[None],
        demand_mps2=np.zeros(1),
        ability=np.zeros(1),
        edge_m=np.zeros(1),
    )


def only(rolled: Rolled, chosen: NDArray[np.intp]) -> Rolled:
    speeds = rolled.speeds
    return replace(
        rolled,
        speeds=SpeedHistory(
            acceleration_mps2=speeds.acceleration_mps2[chosen], speed_mps=speeds.speed_mps[chosen], travelled_m=speeds.travelled_m[chosen]
        ),
        paths=rolled.paths.only(chosen),
        steering_rad=rolled.steering_rad[chosen],
        lateral_mps2=rolled.lateral_mps2[chosen],
        possible=rolled.possible[chosen],
        on_road=rolled.on_road[chosen],
    )
