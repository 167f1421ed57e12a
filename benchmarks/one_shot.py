"""Random single situations: nothing raises, no NaN leaves, every plan is judged, and none is worse than the corrected closed form.

    python benchmarks/one_shot.py --situations 100000 --seed 1 --workers 2 --out one_shot.journal

With `--out` every block of situations is kept as it is done: stopped at any moment, the same command goes on where it was, and more of
them can be asked for later.

A plan is compared with the corrected closed form's by (passed, severity of the first impact, safe end, cost), in this order, and where
nothing passes with five simple policies: full braking, full acceleration, hold, and steering out to either side as hard as the tyres
allow. Each situation is planned by a planner that remembers nothing.

A plan's cost has the cost of leaving the lane where it is driven out of it, whatever it was meant to be; a drive of the closed form into
a lane that nobody watches, which counts as occupied, has not passed.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import multiprocessing
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import mcdas_opt
from mcdas_opt.baselines.corrected import CorrectedMethod
from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vocabulary import Mode, Side, Status
from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.provenance import versions
from mcdas_opt.evaluation.running.journal import Journal
from mcdas_opt.planning.candidates.continuation import to_safe_end
from mcdas_opt.planning.candidates.cost import trajectory_cost
from mcdas_opt.planning.candidates.lane_change_cost import lane_change_cost
from mcdas_opt.planning.candidates.lane_departure import departure
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.fallback.severity import severity
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.proposals.keep_lane import keep_lane
from mcdas_opt.planning.proposals.unwatched import begins_unwatched
from mcdas_opt.planning.rungs.simple_drives import simple_policies

_SEVERITY_MPS, _COST_SHARE, _COST = 0.5, 0.02, 0.05  # differences that count as none; steering out costs 2
_BEST_SIMPLE_MPS = 0.5
_BLOCK = 50


def random_situation(seed: int) -> Situation:
    """Harsh and wide: any speed from rest, friction 0.2 to 1, curves, shoulders, up to six cars, blind sides, a road's end."""
    r = np.random.default_rng(seed)
    v = 0.0 if r.random() < 0.03 else float(r.uniform(0.5, 36.0))
    friction = float(r.choice([1.0, 0.9, 0.7, 0.5, 0.35, 0.25, 0.2]))
    left, right = int(r.integers(0, 3)), int(r.integers(0, 3))
    most = min(0.3 * friction * 9.81 / max(v, 8.0) ** 2, 0.01)
    bends = r.uniform(-most, most, 2) if r.random() < 0.4 else np.zeros(2)
    road = Road(
        lanes_left=left,
        lanes_right=right,
        shoulder_left_m=float(r.choice([0.0, 0.0, 1.5, 2.5])),
        shoulder_right_m=float(r.choice([0.0, 0.0, 2.5])),
        friction=friction,
        curvature=((0.0, float(bends[0])), (120.0, float(bends[1]))),
        road_end_s_m=float(r.uniform(60.0, 300.0)) if r.random() < 0.05 else None,
    )
    host = HostState(
        d_m=float(r.normal(0.0, 0.2)),
        heading_rad=float(r.normal(0.0, 0.01)),
        speed_mps=v,
        acceleration_mps2=float(r.uniform(-0.5, 0.5)) if v > 1.0 else 0.0,
    )
    spread = np.diag([0.15, 0.1, 0.1, 0.05]) ** 2
    tracks = []
    if r.random() < 0.9:
        tracks.append(("front", 4.5 + r.uniform(2.0, 70.0), r.normal(0.0, 0.4), max(v - r.uniform(-2.0, 15.0), 0.0)))
    if r.random() < 0.9:
        tracks.append(("rear", -4.5 - r.uniform(2.0, 50.0), r.normal(0.0, 0.3), v + r.uniform(-2.0, 15.0)))
    for side, lanes in ((1.0, left), (-1.0, right)):
        for lane in range(1, lanes + 1):
            for k in range(int(r.integers(0, 3))):
                tracks.append((f"{side:+.0f}{lane}{k}", r.uniform(-35.0, 35.0) + 40.0 * k, side * lane * 3.7, v * r.uniform(0.6, 1.3)))
    seen = r.random(4) > 0.08
    return Situation(
        host=host,
        tracks=tuple(Track(id=name, s_m=float(s), d_m=float(d), speed_s_mps=float(u), covariance=spread) for name, s, d, u in tracks[:6]),
        coverage=Coverage(front=bool(seen[0]), rear=bool(seen[1]), left=bool(seen[2]), right=bool(seen[3])),
        road=road,
        desired_speed_mps=max(v, 5.0),
    )


@dataclass
class Tally:
    """What was counted, and the seeds of whatever was not as it should be."""

    counts: Counter[str] = field(default_factory=Counter)
    seeds: dict[str, list[int]] = field(default_factory=dict)
    iterations: list[int] = field(default_factory=list)
    beyond_simple_mps: list[float] = field(default_factory=list)
    seconds: float = 0.0

    def fault(self, kind: str, seed: int) -> None:
        self.counts[kind] += 1
        self.seeds.setdefault(kind, []).append(seed)

    def __iadd__(self, other: Tally) -> Tally:
        self.counts += other.counts
        for kind, seeds in other.seeds.items():
            self.seeds.setdefault(kind, []).extend(seeds)
        self.iterations += other.iterations
        self.beyond_simple_mps += other.beyond_simple_mps
        self.seconds += other.seconds
        return self


def examine(seed: int, planner: Planner, corrected: CorrectedMethod, tally: Tally, situation: Situation | None = None) -> None:
    """Plans one situation, by default the random one of that seed, and counts what there is to count."""
    situation = situation or random_situation(seed)
    planner.reset()
    try:
        plan = planner.plan(situation)
    except Exception as error:
        tally.fault(f"exception {type(error).__name__}", seed)
        return
    tally.counts["situations"] += 1
    tally.counts[f"status {plan.status.value}"] += 1
    if plan.safe_end is not None:
        tally.counts[f"end {plan.safe_end.kind.value}"] += 1
    tally.iterations.append(plan.iterations)
    if not all(np.isfinite(column).all() for column in (plan.trajectory.t_s, plan.trajectory.states, plan.trajectory.inputs)):
        tally.fault("NaN in a plan", seed)
    try:
        json.dumps(plan.to_dict(), allow_nan=False)
    except ValueError:
        tally.fault("NaN in a document", seed)
    if plan.verdict.passed == (plan.status is Status.UNAVOIDABLE):
        tally.fault("unverified plan", seed)
    cycle = Cycle.of(situation, planner.vehicle, planner.settings)
    _against_corrected(cycle, plan, corrected, seed, tally)
    if plan.status is Status.UNAVOIDABLE:
        _against_simple(cycle, plan, seed, tally)


def _against_corrected(cycle: Cycle, plan: Plan, corrected: CorrectedMethod, seed: int, tally: Tally) -> None:
    situation = cycle.situation
    other = corrected.plan(situation, None)
    if not isinstance(other, Plan):
        return
    towards = _side(other, cycle)
    passes = other.verdict.passed and (towards is Side.NONE or situation.sees_lane(towards))
    if passes != other.verdict.passed:
        tally.counts["corrected goes where nobody watches"] += 1
    if passes != plan.verdict.passed:
        tally.counts["better than corrected: passed" if plan.verdict.passed else "worse than corrected: passed"] += 1
        if passes:
            tally.fault("worse than corrected: passed", seed)
        return
    if not plan.verdict.passed:
        ours, theirs = (severity(p.trajectory, cycle)[0] for p in (plan, other))
        if other.verdict.only_collides and ours > theirs + _SEVERITY_MPS:
            tally.fault("worse than corrected: severity", seed)
        return
    end = to_safe_end(other.trajectory, other.verdict, cycle).end
    safe, theirs_safe = (one is not None and one.safe for one in (plan.safe_end, end))
    if safe != theirs_safe:
        if theirs_safe:
            tally.fault("worse than corrected: safe end", seed)
        return
    ours, theirs = _cost(plan, cycle), _cost(other, cycle)
    tally.counts["both pass"] += 1
    if ours > theirs * (1.0 + _COST_SHARE) + _COST:
        tally.fault("worse than corrected: cost", seed)


def _cost(plan: Plan, cycle: Cycle) -> float:
    """Of its horizon, and of leaving its lane."""
    weights = CostWeights()
    return trajectory_cost(_horizon(plan, cycle), cycle, weights) + lane_change_cost(_side(plan, cycle), cycle, weights)


def _side(plan: Plan, cycle: Cycle) -> Side:
    """Where it leaves its lane to: what it was meant to, else where it is driven."""
    if plan.side is not Side.NONE:
        return plan.side
    return departure(_horizon(plan, cycle), keep_lane(cycle, Mode.HOLD), cycle)


def _horizon(plan: Plan, cycle: Cycle) -> Trajectory:
    drive, last = plan.trajectory, float(cycle.settings.grid.times_s[-1])
    n = int(np.searchsorted(drive.t_s, last + 1e-6))
    return type(drive).from_states(drive.t_s[:n], drive.states[:n], drive.inputs[: n - 1])


def _against_simple(cycle: Cycle, plan: Plan, seed: int, tally: Tally) -> None:
    ours = severity(plan.trajectory, cycle)[0]
    watched = (driven for driven in simple_policies(cycle) if not begins_unwatched(cycle, driven.proposed.side))
    best = min(severity(driven.trajectory, cycle)[0] for driven in watched)
    tally.beyond_simple_mps.append(ours - best)
    if ours > best + _BEST_SIMPLE_MPS:
        tally.fault("more severe than a simple policy", seed)


_KEPT: list[tuple[Planner, CorrectedMethod]] = []  # of this process: built once, made to forget before each situation


def run(first: int, last: int) -> Tally:
    """The situations numbered `first` to `last` - 1."""
    if not _KEPT:
        planner = Planner()
        _KEPT.append((planner, CorrectedMethod(planner.vehicle, planner.settings)))
    tally, started = Tally(), time.process_time()
    for seed in range(first, last):
        examine(seed, *_KEPT[0], tally)
    tally.seconds = time.process_time() - started
    return tally


def _task(block: tuple[int, int]) -> tuple[tuple[int, int], Tally]:
    return block, run(*block)


def blocks(first: int, count: int, workers: int, kept: Path | None) -> Iterator[Tally]:
    """Of every block, those that the journal holds first; the others as they are done, appended to it.

    Raises InputError for a journal of other versions or other code: its counts are of another planner.
    """
    wanted = [(a, min(a + _BLOCK, first + count)) for a in range(first, first + count, _BLOCK)]
    with contextlib.ExitStack() as opened:
        journal = opened.enter_context(Journal(kept)) if kept is not None else None
        done: set[tuple[int, int]] = set()
        if journal is not None:
            told = versions() | {"source": source_hash()}
            if not journal.records:
                journal.append(told)
            if journal.records[0] != told:
                raise InputError(kept, "", journal.records[0], f"was written by another version; this is {told}")
            for record in journal.records[1:]:
                block = record["first"], record["last"]
                if block in wanted and block not in done:
                    done.add(block)
                    yield _tally(record["tally"])
        left = [block for block in wanted if block not in done]
        pool = opened.enter_context(multiprocessing.get_context("spawn").Pool(workers))
        for (a, b), tally in pool.imap_unordered(_task, left):
            if journal is not None:
                journal.append({"first": a, "last": b, "tally": vars(tally)})
            yield tally


def source_hash() -> str:
    """Of the package's code."""
    found, folder = hashlib.sha256(), Path(mcdas_opt.__file__).parent
    for path in sorted(folder.rglob("*.py")):
        found.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    return found.hexdigest()[:16]


def _tally(record: dict[str, Any]) -> Tally:
    return Tally(**{**record, "counts": Counter(record["counts"])})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--situations", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1, help="situations are numbered from 10^6 times this")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, metavar="FILE", help="keep what is done here, and go on from it")
    arguments = parser.parse_args()
    total = Tally()
    parts = blocks(1_000_000 * arguments.seed, arguments.situations, arguments.workers, arguments.out)
    for part in parts:
        total += part
        if total.counts["situations"] // 5000 != (total.counts["situations"] - part.counts["situations"]) // 5000:
            print(f"... {total.counts['situations']}", flush=True)
    for kind, count in sorted(total.counts.items()):
        examples = f"   seeds {sorted(total.seeds[kind])[:8]}" if kind in total.seeds else ""
        print(f"{kind:>36} {count:>8}{examples}")
    print(f"{'processor time':>36} {total.seconds:>8.0f} s, {1e3 * total.seconds / max(total.counts['situations'], 1):.1f} ms a situation")
    print(
        f"{'solver iterations':>36} median {np.median(total.iterations):.0f}, p99 {np.percentile(total.iterations, 99):.0f}, "
        f"max {max(total.iterations)}"
    )
    if total.beyond_simple_mps:
        beyond = np.array(total.beyond_simple_mps)
        print(
            f"{'severity beyond the best simple':>36} p99 {np.percentile(beyond, 99):.2f} m/s, within 0.5 m/s "
            f"{int((beyond <= _BEST_SIMPLE_MPS).sum())}/{beyond.size}"
        )


if __name__ == "__main__":
    main()
