"""Random traffic of many families, in single situations and in short sequences: what `same_plans.py`, `laws.py` and tests/laws ask about.

An `Episode` is a first situation and what its cars do then; it depends on its family's name and its number alone, never on the code under
test. `ask` plans it cycle by cycle: the host goes on along its own plan, so that the planner's memory takes part.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vocabulary import Request

CYCLE_S = 0.1
BASELINES = ("closed-form", "closed-form-corrected", "aeb", "un-r157", "idm-mobil")
_GRAVITY_MPS2, _LANE_M = 9.81, 3.7
_SHOULDERS_M = (0.0, 0.0, 1.5, 2.5)
_SIZES_M = ((4.5, 1.8),) * 6 + ((12.0, 2.5), (2.2, 0.8))  # cars, a lorry, a motorcycle
_COVARIANCES = (np.zeros((4, 4)), np.diag([0.15, 0.1, 0.1, 0.05]) ** 2, np.diag([1.0, 1.0, 0.4, 0.5]) ** 2)


class Asked(Protocol):
    """Who is asked: a `Planner`."""

    def plan(self, situation: Situation) -> Plan: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """What a family draws from: shares are of situations (`moving`: of cars), `bend` is the share of the grip that a bend asks for."""

    speed_mps: tuple[float, float] = (0.5, 36.0)
    frictions: tuple[float, ...] = (1.0, 0.9, 0.7, 0.5, 0.35, 0.25)
    lanes: int = 2  # to either side, at most
    bends: float = 0.3
    bend: float = 0.3
    front_gap_m: tuple[float, float] = (2.0, 70.0)
    rear_gap_m: tuple[float, float] = (2.0, 50.0)
    closing_mps: tuple[float, float] = (-2.0, 15.0)  # host over front car, rear car over host
    beside: int = 2  # cars in each other lane, at most
    dense: bool = False
    moving: float = 0.1
    standing: float = 0.02
    ends: float = 0.02
    blind: float = 0.05  # share of sectors
    askew: float = 1.0  # how far out of its lane and heading the host is
    overlap: float = 0.0
    surprises: float = 0.05  # share of cycles after the first in which a car appears, vanishes or jumps


KINDS = {
    "sandwich": Kind(speed_mps=(5.0, 33.0), lanes=1, front_gap_m=(5.0, 60.0), rear_gap_m=(3.0, 40.0), closing_mps=(0.0, 15.0), beside=1),
    "wide": Kind(),
    "dense": Kind(dense=True, closing_mps=(-3.0, 6.0)),
    "curved": Kind(bends=1.0, bend=0.9),
    "slippery": Kind(frictions=(0.3, 0.2, 0.12, 0.08)),
    "contradictory": Kind(overlap=0.8, surprises=0.5),
    "blind": Kind(blind=0.5),
    "road-end": Kind(ends=1.0, speed_mps=(0.5, 30.0)),
    "standing": Kind(standing=0.6, speed_mps=(0.0, 2.0), closing_mps=(-5.0, 5.0)),
    "quiet": Kind(front_gap_m=(40.0, 150.0), rear_gap_m=(30.0, 100.0), closing_mps=(-3.0, 3.0), beside=1, askew=0.5),
    "moving": Kind(moving=0.8, surprises=0.1),
    "queue": Kind(speed_mps=(0.5, 9.0), front_gap_m=(1.0, 10.0), rear_gap_m=(0.5, 8.0), closing_mps=(-2.0, 4.0), moving=0.3),
    "askew": Kind(askew=6.0),
    "lincoln": Kind(),
    "baselines": Kind(moving=0.3),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """`first` is planned at cycle 0; in the `cycles` - 1 that follow each car keeps its acceleration and its speed across."""

    family: str
    number: int
    first: Situation
    cycles: int
    method: str = "mpc"
    vehicle: str = "sedan"

    @property
    def name(self) -> str:
        return f"{self.family}/{self.number:05d}"


def episode(family: str, number: int) -> Episode:
    """The episode of that number: half of them are single situations, the others three to five cycles long."""
    kind, r = KINDS[family], _generator(family, number)
    v = 0.0 if r.random() < kind.standing else float(r.uniform(*kind.speed_mps))
    s = float(r.choice([0.0, 0.0, r.uniform(0.0, 2000.0)]))
    road = _road(kind, r, v, s)
    kappa = float(road.curvature_at(s))
    host = HostState(
        s_m=s,
        d_m=float(r.normal(0.0, 0.15 * kind.askew)),
        heading_rad=float(r.normal(0.0, 0.01 * kind.askew)),
        speed_mps=v,
        acceleration_mps2=float(r.uniform(-0.5, 0.5) * min(kind.askew, 3.0)) if v > 1.0 else 0.0,
        steering_rad=float(2.7 * kappa + r.normal(0.0, 0.002 * kind.askew)),
    )
    cars = _cars(kind, r, v, road)
    if r.random() < kind.overlap and cars:
        s_m, d_m, _ = cars[0] if r.random() < 0.8 else (0.0, host.d_m, v)
        cars.append((s_m + float(r.uniform(-3.0, 3.0)), d_m + float(r.uniform(-0.8, 0.8)), float(max(v + r.uniform(-8.0, 8.0), 0.0))))
    seen = r.random(4) >= kind.blind
    first = Situation(
        time_s=round(float(r.uniform(0.0, 100.0)), 1),
        host=host,
        tracks=tuple(_track(f"t{r.integers(100, 1000)}{k}", s, car, kind, r) for k, car in enumerate(cars)),
        coverage=Coverage(front=bool(seen[0]), rear=bool(seen[1]), left=bool(seen[2]), right=bool(seen[3])),
        road=road,
        vehicle="lincoln_mkz" if family == "lincoln" else "sedan",
        desired_speed_mps=float(max(v, 5.0) + r.choice([0.0, 0.0, 3.0, -2.0])),
        request=Request.PARK if v == 0.0 and r.random() < 0.3 else Request.DRIVE,
    )
    cycles = 1 if number % 2 == 0 else int(r.integers(3, 6))
    method = BASELINES[number // 2 % len(BASELINES)] if family == "baselines" else "mpc"
    return Episode(family=family, number=number, first=first, cycles=cycles, method=method, vehicle=first.vehicle)


def episodes(family: str, plans: int, first: int = 0) -> Iterator[Episode]:
    """As many episodes of the family, from that number on, as it takes for so many plans."""
    asked, number = 0, first
    while asked < plans:
        one = episode(family, number)
        yield one
        asked, number = asked + one.cycles, number + 1


def ask(one: Episode, planner: Asked) -> Iterator[tuple[Situation, Plan]]:
    """Cycle by cycle what is asked and what is answered, of a planner that begins with nothing remembered."""
    situation = one.first
    for cycle in range(one.cycles):
        plan = planner.plan(situation)
        yield situation, plan
        situation = _after(one, cycle + 1, situation, plan)


def _generator(family: str, *numbers: int) -> np.random.Generator:
    return np.random.default_rng([zlib.crc32(family.encode()), *numbers])


def _road(kind: Kind, r: np.random.Generator, v_mps: float, s_m: float) -> Road:
    friction = float(r.choice(kind.frictions))
    knots = ((0.0, 0.0),)
    if r.random() < kind.bends:
        most = min(kind.bend * friction * _GRAVITY_MPS2 / max(v_mps, 8.0) ** 2, 0.02)
        places = s_m + np.concatenate([[0.0], np.cumsum(r.uniform(15.0, 100.0, int(r.integers(1, 4))))]) - float(r.choice([0.0, 40.0]))
        knots = tuple((float(s), float(kappa)) for s, kappa in zip(places, r.uniform(-most, most, places.size), strict=True))
    left, right = (int(n) for n in r.integers(0, kind.lanes + 1, 2))
    if kind.dense:
        left, right = max(left, 1), max(right, 1)
    return Road(
        lanes_left=left,
        lanes_right=right,
        shoulder_left_m=float(r.choice(_SHOULDERS_M)),
        shoulder_right_m=float(r.choice(_SHOULDERS_M)),
        friction=friction,
        curvature=knots,
        road_end_s_m=s_m + float(r.uniform(15.0, 250.0)) if r.random() < kind.ends else None,
    )


def _cars(kind: Kind, r: np.random.Generator, v: float, road: Road) -> list[tuple[float, float, float]]:
    """(s from the host [m], d [m], speed [m/s]) of everybody."""
    found: list[tuple[float, float, float]] = []
    if r.random() < 0.9:
        found.append((4.5 + r.uniform(*kind.front_gap_m), r.normal(0.0, 0.4), max(v - r.uniform(*kind.closing_mps), 0.0)))
    if r.random() < 0.9:
        found.append((-4.5 - r.uniform(*kind.rear_gap_m), r.normal(0.0, 0.3), max(v + r.uniform(*kind.closing_mps), 0.0)))
    for lane in range(-road.lanes_right, road.lanes_left + 1):
        if lane == 0:
            continue
        pace = v * r.uniform(0.6, 1.3)
        if kind.dense:
            s = -70.0 + r.uniform(0.0, 10.0)
            while s < 90.0:
                found.append((s, lane * _LANE_M + r.normal(0.0, 0.2), max(pace + r.uniform(-2.0, 2.0), 0.0)))
                s += r.uniform(9.0, 30.0)
        else:
            for k in range(int(r.integers(0, kind.beside + 1))):
                found.append((r.uniform(-35.0, 35.0) + 40.0 * k, lane * _LANE_M, pace * r.uniform(0.9, 1.1)))
    return [(float(s), float(d), float(u)) for s, d, u in found[:32]]


def _track(name: str, from_s_m: float, car: tuple[float, float, float], kind: Kind, r: np.random.Generator) -> Track:
    s, d, v = car
    length, width = _SIZES_M[int(r.integers(len(_SIZES_M)))]
    pushes, drifts = r.random(2) < kind.moving
    known = (None, 0.3, 0.6, 1.0)[int(r.integers(4))]
    return Track(
        id=name,
        s_m=from_s_m + s,
        d_m=d,
        speed_s_mps=v,
        speed_d_mps=float(r.uniform(-2.0, 2.0)) if drifts and v > 2.0 else 0.0,
        covariance=_COVARIANCES[int(r.integers(len(_COVARIANCES)))],
        length_m=length,
        width_m=width,
        age_s=float(r.uniform(0.0, 5.0)),
        coasting=bool(r.random() < 0.05),
        acceleration_s_mps2=float(r.uniform(-8.0, 3.0)) if pushes and v > 1.0 else 0.0,
        acceleration_s_sd_mps2=known,
    )


def _after(one: Episode, cycle: int, situation: Situation, plan: Plan) -> Situation:
    """The situation 0.1 s later: the host along its plan, everybody else as before, but for a surprise."""
    kind, r, drive = KINDS[one.family], _generator(one.family, one.number, cycle), plan.trajectory
    columns = (drive.s_m, drive.d_m, drive.heading_rad, drive.speed_mps, drive.acceleration_mps2, drive.steering_rad)
    s, d, psi, v, a, delta = (float(np.interp(CYCLE_S, drive.t_s, column)) for column in columns)
    host = HostState(s_m=s, d_m=d, heading_rad=psi, speed_mps=max(v, 0.0), acceleration_mps2=a, steering_rad=delta)
    tracks = [_moved(track) for track in situation.tracks]
    if r.random() < kind.surprises and tracks:
        which, what = int(r.integers(len(tracks))), int(r.integers(3))
        if what == 0:
            del tracks[which]
        elif what == 1:
            tracks[which] = replace(tracks[which], s_m=tracks[which].s_m + float(r.uniform(-6.0, 6.0)))
        else:
            new = _track(f"new{cycle}", s, (float(r.uniform(-40.0, 40.0)), float(r.choice([0.0, _LANE_M, -_LANE_M])), v), kind, r)
            tracks.append(replace(new, age_s=0.0))
    return replace(situation, time_s=round(one.first.time_s + CYCLE_S * cycle, 1), host=host, tracks=tuple(tracks))


def _moved(track: Track) -> Track:
    v = max(track.speed_s_mps + CYCLE_S * track.acceleration_s_mps2, 0.0)
    return replace(
        track,
        s_m=track.s_m + 0.5 * CYCLE_S * (track.speed_s_mps + v),
        d_m=track.d_m + CYCLE_S * track.speed_d_mps,
        speed_s_mps=v,
        age_s=track.age_s + CYCLE_S,
    )
