"""The escape map against brute force: `python benchmarks/escape_truth.py --scenes 1000 --seed 7 --out DIR`.

Truth is the last start on a grid of 0.02 s from which a drive of that kind out of a library some ten times finer, followed by the
bicycle, passes the judge and ends with room, under the same prediction. A start is passed over only when no member of the library
would be clear from it even of bodies smaller by what everybody moves in 0.05 s, and by 0.1 m.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.escapes import Escapes
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import KnownBody, PredictedBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.manoeuvres.driven import driven
from mcdas_opt.manoeuvres.escape_library import KINDS, EscapeSettings, members
from mcdas_opt.manoeuvres.escapes import escapes
from mcdas_opt.manoeuvres.family import Demand, Rolled, roll_out
from mcdas_opt.manoeuvres.held import held
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.manoeuvres.parting import ARRIVED_M, Company, doomed, touched
from mcdas_opt.manoeuvres.phases import Phases, SpeedHistory
from mcdas_opt.manoeuvres.sidesteps import Sidesteps, Starts, Ways
from mcdas_opt.manoeuvres.swerves import EDGE_M, Motions, Swerves, swerve
from mcdas_opt.tracking.prediction import predict
from mcdas_opt.verification.judge import judge

STEP_S = 0.02
TIMES_S = np.round(np.arange(101) * 0.04, 9)
NODES = np.arange(0, 202, 2)[:101]
_SKIP = 5
_DRIVEN = 32
_LENIENT = Demand(friction=1.02, steering=1.01)


def situation_of(seed: int, index: int) -> Situation:
    """Boxed in, chased, behind somebody or alone; any speed and friction, straight roads and bends, a host that is not quite steady."""
    r = np.random.default_rng(np.random.SeedSequence(entropy=seed, spawn_key=(index,)))
    v = r.uniform(5.0, 33.0)
    tracks = []
    if r.random() < 0.85:
        gap = r.uniform(5.0, 60.0) + 4.5
        tracks.append(_car("front", gap, r.uniform(-0.6, 0.6), max(v - r.uniform(0.0, 15.0), 0.0), r.normal(0.0, 0.1)))
    if r.random() < 0.85:
        gap = r.uniform(3.0, 40.0) + 4.5
        tracks.append(_car("rear", -gap, r.uniform(-0.3, 0.3), v + r.uniform(0.0, 12.0), r.normal(0.0, 0.1)))
    lanes = (int(r.integers(0, 2)), int(r.integers(0, 2)))
    for name, d, there in (("left", 3.7, lanes[0]), ("right", -3.7, lanes[1])):
        if there and r.random() < 0.6:
            tracks.append(_car(name, r.uniform(-30.0, 30.0), d, v * r.uniform(0.7, 1.2), r.normal(0.0, 0.1)))
    kappa = float(r.uniform(-1.0, 1.0)) * min(0.004, 1.5 / v**2) if r.random() < 0.25 else 0.0
    road = Road(lanes_left=lanes[0], lanes_right=lanes[1], friction=float(r.choice([0.9, 0.5, 0.25])), curvature=((0.0, kappa),))
    host = HostState(
        speed_mps=v,
        d_m=r.uniform(-0.3, 0.3),
        heading_rad=r.normal(0.0, 0.1) / v,
        acceleration_mps2=r.uniform(-0.5, 0.5),
        steering_rad=float(np.arctan(2.7 * (kappa + r.normal(0.0, 0.05) / v**2))),
    )
    return Situation(host=host, tracks=tuple(tracks), road=road)


def _car(name: str, s: float, d: float, v: float, sideways: float) -> Track:
    return Track(id=name, s_m=s, d_m=d, speed_s_mps=v, speed_d_mps=sideways)


class Truth:
    """The last starts of one situation."""

    def __init__(self, situation: Situation, vehicle: Vehicle) -> None:
        self.situation, self.vehicle, self.road = situation, vehicle, situation.road
        self.prediction = predict(situation.tracks)
        self.settings = EscapeSettings()
        until = self.settings.latest_s
        self.fine_s = np.round(np.arange(0.0, until + 1e-9, 0.005), 9)
        self.path = held(situation.host, self.fine_s, vehicle, self.road)
        self.company = Company.of(self.prediction.bodies, until + self.settings.clear_s + STEP_S, self.settings.margins)
        self.end = self._end()

    def _end(self) -> int:
        """The last step at which keeping on has met nobody and is still on the road, by the judge's own eyes."""
        count = round(self.settings.latest_s / STEP_S)
        pick = slice(0, None, round(STEP_S / 0.005))
        p = self.path
        states = np.column_stack([q[pick] for q in (p.s_m, p.d_m, p.heading_rad, p.speed_mps, p.acceleration_mps2, p.steering_rad)])
        drive = Trajectory.from_states(self.fine_s[pick], states, np.zeros((count, 2)))
        verdict = judge(drive, None, self.vehicle, self.road, self.prediction)
        ends = [x.t_s for x in verdict.violations if x.name.startswith("collision") or "road" in x.name]
        return min([count, *(int(t / STEP_S + 1e-6) for t in ends)])

    def starts(self, steps: NDArray[np.intp]) -> Starts:
        at = steps * round(STEP_S / 0.005)
        p = self.path
        columns = (p.s_m, p.d_m, p.heading_rad, p.speed_mps, p.acceleration_mps2, p.steering_rad)
        s, d, psi, v, a, delta = (q[at] for q in columns)
        return Starts(s_m=s, d_m=d, heading_rad=psi, speed_mps=v, acceleration_mps2=a, steering_rad=delta)

    def last(self, kind: str) -> float | None:
        """The last start [s] that is sound; None without."""
        speeds = [body.at(np.zeros(1)).speed_s_mps[0] for body in self.prediction.bodies]
        reach = 0.05 * (max((abs(s - self.situation.host.speed_mps) for s in speeds), default=0.0) + 3.0) + 0.1
        for top in range(self.end, -1, -_SKIP):
            begin = max(top - _SKIP + 1, 0)
            if not any(clear.any() for _, clear in self._clear(kind, (top + begin) // 2, -reach, every=2)):
                continue
            for step in range(top, begin - 1, -1):
                if self.sound(kind, step) is not None:
                    return round(step * STEP_S, 9)
        return None

    def sound(self, kind: str, step: int) -> Trajectory | None:
        """A drive of that kind from that step on that the judge passes and that ends with room; None when the library holds none."""
        begin = HostState.from_vector(np.array([float(q[0]) for q in _columns(self.starts(np.array([step])))]))
        bodies = tuple(_later(body, step * STEP_S) for body in self.prediction.bodies)
        clock = step + NODES[None]
        for clear_m in (0.0, -0.06):
            for rolled, clear in self._clear(kind, step, clear_m):
                chosen = np.flatnonzero(clear)[:_DRIVEN]
                if not chosen.size:
                    continue
                for one in driven(_only(rolled, chosen), begin, self.vehicle, self.road):
                    if not judge(one, begin, self.vehicle, self.road, Prediction(name="truth", bodies=bodies)).passed:
                        continue
                    if doomed(_motions_of(one), clock, self.company, self.vehicle, self.road)[0] < 0:
                        return one
        return None

    def _clear(self, kind: str, step: int, clear_m: float, every: int = 1) -> Iterator[tuple[Rolled, NDArray[np.bool_]]]:
        """Each library rolled out from a step, and which of its members stay clear of everybody and end with room."""
        one = self.starts(np.array([step]))
        for rows in self._swerves(kind, float(one.speed_mps[0])):
            count = rows.level_mps2.size
            start = Starts(**{name: np.repeat(getattr(one, name), count) for name in Starts.__dataclass_fields__})
            motions = swerve(rows, TIMES_S[::every], start, self.vehicle, self.road, _LENIENT)
            arrives = ~(np.abs(motions.d_m[:, -1] - rows.target_d_m) > ARRIVED_M)
            yield _rolled(motions, self.vehicle), arrives & self._parted(motions, step + NODES[::every], clear_m)
        for phases, steps in self._sigmoids(kind):
            host = HostState.from_vector(np.array([float(q[0]) for q in _columns(one)]))
            rolled = roll_out(phases, steps, TIMES_S[::every], host, self.vehicle, self.road, _LENIENT)
            arrives = np.abs(rolled.ways.d_m[:, -1] - steps.target_d_m) <= ARRIVED_M
            yield rolled, arrives & self._parted(_motions(rolled), step + NODES[::every], clear_m)

    def _parted(self, motions: Motions, clock: NDArray[np.intp], clear_m: float) -> NDArray[np.bool_]:
        clock = np.broadcast_to(clock, motions.s_m.shape)
        slack = 0.1 if clear_m < -0.1 else 0.0  # of the edges' metres and of the car's limits, where only hope is looked for
        able = (motions.ability >= -slack) & (motions.edge_m >= -slack - EDGE_M)  # at the very edge, by the judge's own eyes
        met, _ = touched(motions, clock, self.company, self.vehicle, self.road, clear_m)
        if clear_m < 0.0:  # smaller bodies end with more room
            smaller = replace(self.company, half_length_m=self.company.half_length_m + clear_m)
            return np.asarray(able & (met < 0) & (doomed(motions, clock, smaller, self.vehicle, self.road) < 0))
        return np.asarray(able & (met < 0) & (doomed(motions, clock, self.company, self.vehicle, self.road) < 0))

    def _swerves(self, kind: str, speed: float) -> Iterator[Swerves]:
        """The map's own members, and a grid around them that is some ten times finer."""
        grip = self.road.friction * GRAVITY_MPS2
        car = self.vehicle
        brake, accelerate = min(-car.acceleration_min_mps2, grip), min(car.acceleration_max_mps2, grip)
        own = members(self.situation, car, self.company, self.settings)
        mine = np.flatnonzero(own.kind == KINDS.index(kind))
        if not mine.size:
            return
        rows, acts = own.rows(mine, np.full(mine.size, speed))
        yield rows[acts]
        target = own.target_d_m[mine[0]]
        if kind in ("brake", "accelerate"):
            most = -brake if kind == "brake" else accelerate
            grid = []
            for share in np.linspace(0.12, 1.0, 23):
                level = share * most
                ends = [99.0, *np.arange(0.5, 4.0, 0.25)]
                for body in self.prediction.bodies:
                    ends.append((float(body.at(np.zeros(1)).speed_s_mps[0]) - speed) / level)
                grid += [(level, end, target, min(1.0, 0.2 * grip)) for end in ends if end >= 0.5]
        else:
            paces = [(0.0, 0.0)] + [(x * accelerate, t) for x in (0.3, 0.6, 0.97) for t in (0.7, 1.2, 2.0, 9.0)]
            paces += [(-x * brake, t) for x in (0.2, 0.4, 0.6, 0.75, 0.9) for t in (0.4, 0.8, 1.2, 1.8, 9.0)]
            shares = (0.12, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.88, 0.94, 0.98, 1.0)
            shares += (1.03, 1.08)  # the sidestep leaves some of it for what braking does across
            grid = [(level, until, target, share * np.sqrt(grip**2 - level**2)) for (level, until), share in product(paces, shares)]
        level, until, target_d, push = np.array(grid).T
        yield Swerves(level_mps2=level, until_s=until, target_d_m=target_d, lateral_mps2=push)

    def _sigmoids(self, kind: str) -> Iterator[tuple[Phases, Sidesteps]]:
        """The planner's own family, for the ways to the side."""
        if kind in ("brake", "accelerate"):
            return
        target = next_lane_m(self.situation, self.vehicle, Side.LEFT if kind == "left" else Side.RIGHT)
        if target is None:
            return
        grip = self.road.friction * GRAVITY_MPS2
        car = self.vehicle
        brake, accelerate = min(-car.acceleration_min_mps2, grip), min(car.acceleration_max_mps2, grip)
        paces = [(0.0, 9.0), (0.4 * accelerate, 9.0), (0.9 * accelerate, 1.0), (0.9 * accelerate, 9.0)]
        paces += [(-x * brake, t) for x in (0.3, 0.6, 0.8) for t in (0.8, 1.5, 9.0)]
        pushes = [share * grip for share in (0.2, 0.35, 0.5, 0.6, 0.7, 0.8, 0.9)]
        rows = [(a, t, push, b) for (a, t), push, b in product(paces, pushes, (50.0, 20.0, 8.0))]
        first, until, push_mps2, b = np.array(rows).T
        nothing = np.zeros(len(rows))
        yield (
            Phases(first_mps2=first, switch_s=until, then_mps2=nothing),
            Sidesteps(target_d_m=nothing + target, lateral_mps2=push_mps2, delay_s=nothing, b=b),
        )


def _columns(start: Starts) -> tuple[Array, ...]:
    return start.s_m, start.d_m, start.heading_rad, start.speed_mps, start.acceleration_mps2, start.steering_rad


def _later(body: PredictedBody, start_s: float) -> KnownBody:
    return KnownBody(id=body.id, length_m=body.length_m, width_m=body.width_m, motion=lambda t: body.at(t + start_s))


def _rolled(motions: Motions, vehicle: Vehicle) -> Rolled:
    heading = np.arcsin(motions.sine)
    return Rolled(
        times_s=TIMES_S,
        speeds=SpeedHistory(acceleration_mps2=motions.acceleration_mps2, speed_mps=motions.speed_mps, way_m=motions.s_m),
        ways=Ways(
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


def _motions(rolled: Rolled) -> Motions:
    ways = rolled.ways
    return Motions(
        s_m=ways.s_m,
        d_m=ways.d_m,
        sine=ways.sine,
        cosine=ways.cosine,
        speed_mps=np.broadcast_to(rolled.speeds.speed_mps, ways.s_m.shape),
        acceleration_mps2=np.broadcast_to(rolled.speeds.acceleration_mps2, ways.s_m.shape),
        curvature_1pm=ways.curvature_1pm,
        demand_mps2=np.zeros(ways.s_m.shape[0]),
        ability=np.where(rolled.possible, 0.0, -1.0),
        edge_m=np.where(rolled.on_road, 0.0, -1.0),
    )


def _motions_of(drive: Trajectory) -> Motions:
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


def _only(rolled: Rolled, chosen: NDArray[np.intp]) -> Rolled:
    speeds = rolled.speeds
    return replace(
        rolled,
        speeds=SpeedHistory(
            acceleration_mps2=speeds.acceleration_mps2[chosen], speed_mps=speeds.speed_mps[chosen], way_m=speeds.way_m[chosen]
        ),
        ways=rolled.ways.only(chosen),
        steering_rad=rolled.steering_rad[chosen],
        lateral_mps2=rolled.lateral_mps2[chosen],
        possible=rolled.possible[chosen],
        on_road=rolled.on_road[chosen],
    )


def compare(seed: int, index: int, vehicle: Vehicle) -> list[dict[str, object]]:
    """One row for each kind of one situation."""
    situation = situation_of(seed, index)
    begun = time.perf_counter()
    answer: Escapes = escapes(situation, vehicle, predict(situation.tracks))
    spent = 1e3 * (time.perf_counter() - begun)
    truth = Truth(situation, vehicle)
    rows: list[dict[str, object]] = []
    for kind in KINDS:
        way = getattr(answer, kind)
        rows.append(
            {
                "scene": index,
                "kind": kind,
                "map_s": way.last_moment_s,
                "truth_s": truth.last(kind),
                "closed_by": way.closed_by or "",
                "ms": spent,
            }
        )
    return rows


def report(rows: list[dict[str, object]]) -> str:
    lines = ["kind        ways  both closed  later  missed  early p50   p90   p95   max [s]  within 0.1 s"]
    for kind in (*KINDS, "all"):
        mine = [r for r in rows if kind in ("all", r["kind"])]
        both = [(float(r["map_s"]), float(r["truth_s"])) for r in mine if r["map_s"] is not None and r["truth_s"] is not None]  # type: ignore[arg-type]
        closed = sum(r["map_s"] is None and r["truth_s"] is None for r in mine)
        missed = sum(r["map_s"] is None and r["truth_s"] is not None for r in mine)
        later = sum(m > t + 1e-6 for m, t in both) + sum(r["map_s"] is not None and r["truth_s"] is None for r in mine)
        early = np.array([t - m for m, t in both]) if both else np.zeros(1)
        p50, p90, p95 = np.percentile(early, [50, 90, 95])
        lines.append(
            f"{kind:11s} {len(mine):4d}  {closed:11d}  {later:5d}  {missed:6d}  {p50:9.2f} {p90:5.2f} {p95:5.2f} {early.max():5.2f}      "
            f"{np.mean(early <= 0.1 + 1e-6):.3f}"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--out", type=Path, default=None)
    chosen = parser.parse_args()
    vehicle = Vehicle()
    rows = [row for index in range(chosen.first, chosen.first + chosen.scenes) for row in compare(chosen.seed, index, vehicle)]
    print(report(rows))
    if chosen.out is not None:
        chosen.out.mkdir(parents=True, exist_ok=True)
        with (chosen.out / f"escape_truth-{chosen.seed}-{chosen.first}.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
