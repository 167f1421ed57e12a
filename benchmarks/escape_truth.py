"""The escape map against brute force: `python benchmarks/escape_truth.py --scenes 1000 --seed 7 --out DIR`.

Truth is the last start on a grid of 0.02 s from which a drive of that kind, followed by the bicycle, passes the judge and ends with
room, under the same prediction: out of a library some ten times finer, and then out of variations of what was sound or almost
sound, in level, time and push, for as long as they win a step. A start is passed over only when no member of the library would be
clear from it even of bodies smaller by what everybody moves in 0.05 s, and by 0.1 m. A candidate that the map calls closed and that is not
counts as early by all of it.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.escape_case import CompiledCase
from benchmarks.escape_finer import (
    DRIVE_NODES,
    STEP_S,
    finer,
    motions_driven,
    motions_from,
    only,
    rolled_from,
    rows_of,
    sigmoids,
    some_of,
    spread,
    varied_around,
)
from mcdas_opt.domain.escapes import Escapes
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import KnownBody, PredictedBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.evaluation.statistics import Share
from mcdas_opt.manoeuvres.driven import driven
from mcdas_opt.manoeuvres.family import Demand, Rolled, roll_out
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.manoeuvres.lane_change_profiles import LaneChangeProfiles
from mcdas_opt.native.library import library
from mcdas_opt.time_to_react.compiled_case import Nodes
from mcdas_opt.time_to_react.constant_input import constant_input
from mcdas_opt.time_to_react.escapes import escapes_under
from mcdas_opt.time_to_react.evasive_profiles import EDGE_M
from mcdas_opt.time_to_react.guess import Case
from mcdas_opt.time_to_react.library import CLEAR_S, KINDS, LATEST_S, EscapeSettings, Members
from mcdas_opt.time_to_react.predicted_traffic import PredictedTraffic, Rows
from mcdas_opt.time_to_react.separation import ARRIVED_M, inevitable_collision, touched
from mcdas_opt.tracking.prediction import predict
from mcdas_opt.verification.judge import judge, judge_all

NODES = np.arange(0, 201, 2)
_COARSE = NODES[::2]
_COARSE_NODES = Nodes(_COARSE)
_SKIP = 5
_WIDEST = (0.1, 0.3, 0.06)
_WIDTHS = ((0.06, 0.22, 0.05), (0.03, 0.1, 0.025), (0.01, 0.04, 0.01))  # by which levels, times and pushes are varied at last
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
    return Situation(host=host, coverage=Coverage(), tracks=tuple(tracks), road=road)


def _car(name: str, s: float, d: float, v: float, sideways: float) -> Track:
    return Track(id=name, s_m=s, d_m=d, speed_s_mps=v, speed_d_mps=sideways)


class Truth:
    """The last starts of one situation."""

    def __init__(self, situation: Situation, vehicle: Vehicle) -> None:
        self.situation, self.vehicle, self.road = situation, vehicle, situation.road
        self.prediction = predict(situation.tracks)
        self.settings = EscapeSettings()
        until = LATEST_S
        self.fine_s = np.round(np.arange(0.0, until + 1e-9, 0.005), 9)
        self.path = constant_input(situation.host, self.fine_s, vehicle, self.road)
        self.traffic = PredictedTraffic.of(self.prediction.bodies, until + CLEAR_S + STEP_S, self.settings.margins)
        self.end = self._end()
        speeds = [body.at(np.zeros(1)).speed_s_mps[0] for body in self.prediction.bodies]
        self.reach_m = 0.05 * (max((abs(s - situation.host.speed_mps) for s in speeds), default=0.0) + 3.0) + 0.1
        self.fine = finer(situation, vehicle, self.traffic, self.prediction, self.settings)
        self.bare, self.smaller = self._case(0.0, 0.0), self._case(-0.06, 0.0)
        self.hopeful = self._case(-self.reach_m, 0.1)

    def _case(self, clear_m: float, slack: float, among: Members | None = None) -> Case:
        """The finer library against bodies grown by `clear_m`; with so much slack of the edges' metres and of the car's limits."""
        share = _LENIENT.friction * (1.0 + slack), _LENIENT.steering * (1.0 + slack)
        settings = replace(self.settings, clear_m=clear_m, demand=Demand(friction=share[0], steering=share[1]))
        kept, road = EDGE_M + slack, self.road  # at the very edge, by the judge's own measure
        end = None if road.road_end_s_m is None else road.road_end_s_m + kept
        wider = replace(road, shoulder_left_m=road.shoulder_left_m + kept, shoulder_right_m=road.shoulder_right_m + kept, road_end_s_m=end)
        situation = replace(self.situation, road=wider)
        asked, compiled = (situation, self.vehicle, self.prediction, settings, among or self.fine), library()
        return Case(*asked) if compiled is None else CompiledCase(compiled, *asked)

    def _end(self) -> int:
        """The last step at which the constant-input prediction has met nobody and is still on the road, by the judge's own measure."""
        count = round(LATEST_S / STEP_S)
        pick = slice(0, None, round(STEP_S / 0.005))
        p = self.path
        states = np.column_stack([q[pick] for q in (p.s_m, p.d_m, p.heading_rad, p.speed_mps, p.acceleration_mps2, p.steering_rad)])
        drive = Trajectory.from_states(self.fine_s[pick], states, np.zeros((count, 2)))
        verdict = judge(drive, None, self.vehicle, self.road, self.prediction)
        ends = [x.t_s for x in verdict.violations if x.kind is ViolationKind.COLLISION or "road" in x.name]
        return min([count, *(int(t / STEP_S + 1e-6) for t in ends)])

    def _host(self, step: int) -> HostState:
        """The host that has kept its inputs until that step."""
        p, at = self.path, step * round(STEP_S / 0.005)
        columns = (p.s_m, p.d_m, p.heading_rad, p.speed_mps, p.acceleration_mps2, p.steering_rad)
        return HostState.from_vector(np.array([float(q[at]) for q in columns]))

    def last(self, kind: str) -> float | None:
        """The last start [s] that is sound; None without."""
        mine = self.fine.of_kind[KINDS.index(kind)]
        for top in range(self.end, -1, -_SKIP):
            begin = max(top - _SKIP + 1, 0)
            if not self._hope(kind, mine, (top + begin) // 2):
                continue
            for step in range(top, begin - 1, -1):
                if self.sound(kind, step) is not None:
                    return round(STEP_S * self._refined(kind, step), 9)
        return None

    def asked_again(self, kind: str, last_s: float | None, claimed_s: float) -> float | None:
        """The truth for a later start that somebody claims is sound: what was sound before, however long before, is varied up to there."""
        claimed = round(claimed_s / STEP_S)
        for before in range(claimed - 1, -1, -1):
            if self._refined(kind, before, (_WIDEST, *_WIDTHS)) >= claimed:
                return claimed_s
        return last_s

    def _refined(self, kind: str, step: int, by: tuple[tuple[float, float, float], ...] = _WIDTHS) -> int:
        """A later start, found by varying what is sound or almost sound from that one, as long as that wins anything."""
        mine = self.fine.of_kind[KINDS.index(kind)]
        known, widths = some_of(self.fine, mine[self.smaller.sound(mine, np.full(mine.size, step))[0]]), list(by)
        while widths and known.kind.size:
            varied = varied_around(known, widths[0], self.smaller.brake_mps2, self.smaller.accelerate_mps2)
            every = np.arange(varied.kind.size)
            bare, smaller = self._case(0.0, 0.0, varied), self._case(-0.06, 0.0, varied)
            for later in (step + 3, step + 1):
                if later <= self.end and self._library_drive(bare, smaller, every, later) is not None:
                    step, known = later, some_of(varied, np.flatnonzero(smaller.sound(every, np.full(every.size, later))[0]))
                    break
            else:
                widths.pop(0)
        return step

    def _hope(self, kind: str, mine: Rows, step: int) -> bool:
        """Whether any member would be clear from about that step, seen coarsely and kindly."""
        if self.hopeful.sound(mine, np.full(mine.size, step), _COARSE_NODES)[0].any():
            return True
        return any(self._able(*rows, step, _COARSE, -self.reach_m).any() for rows in self._sigmoids(kind, step, _COARSE))

    def sound(self, kind: str, step: int) -> Trajectory | None:
        """A drive of that kind from that step on that the judge passes and that ends with room; None when the library holds none."""
        drive = self._library_drive(self.bare, self.smaller, self.fine.of_kind[KINDS.index(kind)], step)
        if drive is not None:
            return drive
        for rolled, steps in self._sigmoids(kind, step, NODES):
            chosen = spread(np.flatnonzero(self._able(rolled, steps, step, NODES, -0.06)))
            if chosen.size:
                for finer_rolled, _ in self._sigmoids(kind, step, DRIVE_NODES):
                    drive = self._judged(only(finer_rolled, chosen), step)
                    if drive is not None:
                        return drive
        return None

    def _library_drive(self, bare: Case, smaller: Case, mine: Rows, step: int) -> Trajectory | None:
        """The same of these members, against everybody and against somewhat smaller bodies."""
        starts = np.full(mine.size, step)
        clear = bare.sound(mine, starts)[0]
        almost = smaller.sound(mine, starts)[0]
        for wanted in (clear, almost & ~clear):
            chosen = spread(np.flatnonzero(wanted))
            if chosen.size:
                motions, _, _ = bare.driven(mine[chosen], starts[chosen], DRIVE_NODES)
                drive = self._judged(rolled_from(motions, self.vehicle), step)
                if drive is not None:
                    return drive
        return None

    def _judged(self, rolled: Rolled, step: int) -> Trajectory | None:
        """The first of these that the judge passes when the bicycle follows it from that step on, and that ends with room."""
        begin = self._host(step)
        prediction = Prediction(name="truth", bodies=tuple(_later(body, step * STEP_S) for body in self.prediction.bodies))
        drives = driven(rolled, begin, self.vehicle, self.road)
        for drive, verdict in zip(drives, judge_all(drives, begin, self.vehicle, self.road, prediction), strict=True):
            if (
                verdict.passed
                and inevitable_collision(motions_driven(drive), step + DRIVE_NODES[None], self.traffic, self.vehicle, self.road)[0] < 0
            ):
                return drive
        return None

    def _sigmoids(self, kind: str, step: int, nodes: Rows) -> Iterator[tuple[Rolled, LaneChangeProfiles]]:
        """The planner's own family from a step on, for the candidates to the side."""
        if kind in ("brake", "accelerate"):
            return
        target = next_lane_m(self.situation, self.vehicle, Side.LEFT if kind == "left" else Side.RIGHT)
        if target is None:
            return
        phases, steps = sigmoids(target, self.road, self.vehicle)
        yield roll_out(phases, steps, STEP_S * nodes, self._host(step), self.vehicle, self.road, _LENIENT), steps

    def _able(self, rolled: Rolled, steps: LaneChangeProfiles, step: int, nodes: Rows, clear_m: float) -> NDArray[np.bool_]:
        """Which sigmoids arrive, stay clear of everybody and end with room."""
        motions = motions_from(rolled)
        clock = np.broadcast_to(step + nodes, motions.s_m.shape)
        arrives = np.abs(rolled.paths.d_m[:, -1] - steps.target_d_m) <= ARRIVED_M
        slack = 0.1 if clear_m < -0.1 else 0.0
        able = arrives & (motions.ability >= -slack) & (motions.edge_m >= -slack - EDGE_M)
        smaller = replace(self.traffic, half_length_m=self.traffic.half_length_m + clear_m)  # smaller bodies end with more room
        able &= inevitable_collision(motions, clock, smaller, self.vehicle, self.road) < 0
        left = np.flatnonzero(able)
        if left.size:
            met, _ = touched(rows_of(motions, left), clock[left], self.traffic, self.vehicle, self.road, clear_m)
            able[left[met >= 0]] = False
        return able


def _later(body: PredictedBody, start_s: float) -> KnownBody:
    return KnownBody(id=body.id, length_m=body.length_m, width_m=body.width_m, motion=lambda t: body.at(t + start_s))


def compare(seed: int, index: int, vehicle: Vehicle) -> list[dict[str, object]]:
    """One row for each kind of one situation."""
    situation = situation_of(seed, index)
    begun = time.perf_counter()
    answer: Escapes = escapes_under(predict(situation.tracks), situation, vehicle)
    spent = 1e3 * (time.perf_counter() - begun)
    truth = Truth(situation, vehicle)
    rows: list[dict[str, object]] = []
    for kind in KINDS:
        candidate, last_s = getattr(answer, kind), truth.last(kind)
        if candidate.last_moment_s is not None and candidate.last_moment_s > (-1.0 if last_s is None else last_s) + 1e-6:
            last_s = truth.asked_again(kind, last_s, candidate.last_moment_s)
        rows.append(
            {
                "scene": index,
                "kind": kind,
                "map_s": candidate.last_moment_s,
                "truth_s": last_s,
                "closed_by": candidate.closed_by or "",
                "ms": spent,
            }
        )
    return rows


def report(rows: list[dict[str, object]]) -> str:
    lines = ["kind       asked  both closed  missed  early p50   p90   p95   max [s]  within 0.1 s           later"]
    for kind in (*KINDS, "all"):
        mine = [(_last(r["map_s"]), _last(r["truth_s"])) for r in rows if kind in ("all", r["kind"])]
        opened = [(m, t) for m, t in mine if t >= 0.0]
        missed = sum(m < 0.0 for m, _ in opened)
        early = np.array([t - m for m, t in opened if m <= t + 1e-6] or [0.0])
        later, near = sum(m > t + 1e-6 for m, t in mine), int(np.sum(early <= 0.1 + 1e-6))
        p50, p90, p95 = np.percentile(early, [50, 90, 95])
        (low, high), (_, worst) = Share(k=near, n=early.size).interval, Share(k=later, n=len(mine)).interval
        counts = f"{kind:11s} {len(mine):4d}  {len(mine) - len(opened):11d}  {missed:6d}"
        shares = f"{near}/{early.size} ({low:.3f}-{high:.3f})  {later}/{len(mine)} (below {worst:.4f})"
        lines.append(f"{counts}  {p50:9.2f} {p90:5.2f} {p95:5.2f} {early.max():5.2f}      {shares}")
    return "\n".join(lines)


def _last(moment_s: object) -> float:
    """A last moment [s]; one step before the first where there is none."""
    return -STEP_S if moment_s is None else float(moment_s)


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
