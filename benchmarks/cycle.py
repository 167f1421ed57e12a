"""Where the time of a cycle goes: the whole step, the share of each stage, and a ratio to an IPOPT solve timed in the same run.

    python benchmarks/cycle.py [SCENE ...] [--planner NAME] [--repeats N] [--rounds N] [--memory CYCLES]

Three times are told apart: the whole step (scans in, plan and escape map out), the judged cycle in it (tracks in; candidates solved,
judged, chosen: neither the tracker nor the map), and the escape map. Times are processor time of the thread, the first plan counted in;
read the ratios, and the tail as counted work. With `--rounds` every drive is driven so many times, the same plans each time, and of each
cycle's times the least counts: what others do on the machine is then left out. With `--memory` a planner then runs so many cycles, and its
memory is printed on the way: it should not grow.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import time
import tracemalloc
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.lane_situations import evasion, lane_problem, posed
from mcdas_opt import Planner, load_scene, simulate
from mcdas_opt.domain.plan import Plan
from mcdas_opt.planning import cycle, mpc, search
from mcdas_opt.planning import planner as planning
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.candidates import evaluator
from mcdas_opt.planning.rounds import active_manoeuvre, ranked_first
from mcdas_opt.solvers.ipopt_engine import IpoptEngine

SCENES = ("sandwich-60-40", "front-braking-with-follower", "curved-road", "benign-following")
STAGES: tuple[tuple[str, Any], ...] = (  # a function, and where it is called
    ("assess", cycle),
    ("basic_four", search),
    ("further", ranked_first),
    ("further", active_manoeuvre),
    ("verdicts", evaluator),
    ("nearness", evaluator),
    ("driving_costs", evaluator),
    ("ended", evaluator),
)


def timed(spent: dict[str, list[float]], name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def run(*args: Any, **kwargs: Any) -> Any:
        started = time.thread_time()
        try:
            return function(*args, **kwargs)
        finally:
            spent[name].append(time.thread_time() - started)

    return run


def ipopt_ms(solves: int = 20) -> float:
    """Median of a cold IPOPT solve of the lane problem with three neighbours, from the reference path."""
    problem, rng = lane_problem(3), np.random.default_rng(0)
    engine, spent = IpoptEngine(problem, 40), defaultdict[str, list[float]](list)
    solve = timed(spent, "ipopt", engine.solve)
    for _ in range(solves):
        q = posed(*evasion(rng, 3), problem)
        solve(q.x0, q.p, q.steps, q.guess)
    return 1e3 * statistics.median(spent["ipopt"])


def quantiles(values: list[float]) -> str:
    return "  ".join(f"{name} {1e3 * float(np.quantile(values, q)):7.2f}" for name, q in (("p50", 0.5), ("p99", 0.99), ("p99.9", 0.999)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--planner", default="mpc")
    parser.add_argument("--repeats", type=int, default=3, help="seeds of each scene")
    parser.add_argument("--rounds", type=int, default=1, help="drives of each seed, of which the least times count")
    parser.add_argument("--memory", type=int, default=0, metavar="CYCLES")
    options = parser.parse_args()

    spent: dict[str, list[float]] = defaultdict(list)
    for name, room in STAGES:
        setattr(room, name, timed(spent, name, getattr(room, name)))
    planning.with_time_to_react = timed(spent, "escapes", planning.with_time_to_react)
    cycles: list[Cycle] = []
    for name in options.scenes:
        scene = load_scene(name)
        for repeat in range(options.repeats):
            rounds: list[list[Cycle]] = []
            for _ in range(options.rounds):
                rounds.append([])
                started = time.thread_time()
                planner = Planner(vehicle=scene.vehicle, method=options.planner, road=scene.assumed_road)
                built = time.thread_time() - started
                drive = simulate(scene, watched(planner, spent, rounds[-1]), seed=repeat)
            cycles += [least(same) for same in zip(*rounds, strict=True)]
            print(f"{name}, seed {repeat}: {drive.outcome}, {drive.plans} plans, planner built in {1e3 * built:.1f} ms")
    oracle = ipopt_ms()
    print(f"\none cold IPOPT solve, three neighbours: {oracle:.2f} ms\n")
    print(f"{'[ms]':44} {'cycles':>7}  quantiles, and their ratio to IPOPT")
    rows = {
        "step: scans in, judged plan and map out": [c.step_s for c in cycles],
        "cycle: tracks in, solved, judged, chosen": [c.judged_s for c in cycles],
    }
    for low, high in ((1, 1), (2, 4), (5, 99)):
        rows[f"  of these with {low} to {high} candidates solved"] = [c.judged_s for c in cycles if low <= c.candidates <= high]
    rows["escape map"] = [c.map_s for c in cycles]
    for label, values in rows.items():
        if values:
            median, tail = 1e3 * statistics.median(values) / oracle, 1e3 * float(np.quantile(values, 0.99)) / oracle
            print(f"{label:44} {len(values):7d}  {quantiles(values)}   ratio p50 {median:.3f} p99 {tail:.3f}")
    slowest = sorted(cycles, key=lambda cycle: -cycle.judged_s)[:5]
    told = (f"{1e3 * c.judged_s:.1f} ms, {c.candidates} candidates, {c.iterations} iterations" for c in slowest)
    print("slowest cycles: " + "; ".join(told))
    whole = sum(spent.pop("step"))
    print(f"\n{'stage':12} {'calls':>7} {'median ms':>10} {'p99 ms':>9} {'share of the step':>18}")
    for stage, values in sorted(spent.items(), key=lambda item: -sum(item[1])):
        print(f"{stage:12} {len(values):7d} {1e3 * statistics.median(values):10.3f} {1e3 * float(np.quantile(values, 0.99)):9.3f}", end="")
        print(f" {sum(values) / whole:18.1%}")
    if options.memory:
        memory(options.memory)
    else:
        imports()


@dataclass(frozen=True)
class Cycle:
    """Times of one cycle [s], and its work: the whole step, what is judged in it without the map, the map; candidates and iterations."""

    step_s: float
    judged_s: float
    map_s: float
    candidates: int
    iterations: int


def least(same: Sequence[Cycle]) -> Cycle:
    """Of the same cycle, timed again and again, the least of each time. Raises `ValueError` where the work was not the same."""
    first = same[0]
    if any((one.candidates, one.iterations) != (first.candidates, first.iterations) for one in same):
        raise ValueError("a drive did not repeat")
    times = {name: min(getattr(one, name) for one in same) for name in ("step_s", "judged_s", "map_s")}
    return replace(first, **times)


def watched(planner: Planner, spent: dict[str, list[float]], cycles: list[Cycle]) -> Planner:
    """The planner with its step, plan, tracker and solver timed; what the warm-up of the sensors costs is left out."""
    step, plan, update, candidates = planner.step, planner.plan, planner.tracker.update, 0
    judged_s = map_s = 0.0
    if isinstance(planner.method, mpc.MpcMethod):
        solver = planner.method.solvers.usual
        solve = timed(spent, "solve", solver.solve)

        def solved(of: Any, proposed: Proposed) -> Any:
            nonlocal candidates
            candidates += 1
            return solve(of, proposed)

        solver.solve = solved

    def timed_plan(situation: Any) -> Plan:
        nonlocal candidates, judged_s, map_s
        candidates, maps, started = 0, len(spent["escapes"]), time.thread_time()
        answer = plan(situation)
        whole_s = time.thread_time() - started
        map_s = sum(spent["escapes"][maps:])
        judged_s = whole_s - map_s
        return answer

    def timed_step(*args: Any, **kwargs: Any) -> Plan:
        planner.tracker.update = timed(spent, "track", update)
        started = time.thread_time()
        answer = step(*args, **kwargs)
        spent["step"].append(time.thread_time() - started)
        planner.tracker.update = update
        cycles.append(Cycle(spent["step"][-1], judged_s, map_s, candidates, answer.iterations))
        return answer

    planner.plan, planner.step = timed_plan, timed_step
    return planner


def memory(cycles: int) -> None:
    """Resident and traced memory over many plans of ever changing situations, and how both grow once the first fifth has warmed up."""
    planner, rng = Planner(), np.random.default_rng(0)
    situations = [evasion(rng, 1 + i % 4)[0] for i in range(20)]
    seen: list[tuple[float, float, float]] = []
    tracemalloc.start()
    for k in range(cycles):
        planner.plan(replace(situations[(k // 5) % len(situations)], time_s=round(0.1 * k, 9)))
        if (k + 1) % max(cycles // 20, 1) == 0:
            resident = int(Path("/proc/self/statm").read_text("utf-8").split()[1]) * 4096 / 2**20 if sys.platform == "linux" else 0.0
            seen.append((k + 1.0, tracemalloc.get_traced_memory()[0] / 2**20, resident))
            print(f"after {k + 1} plans: {seen[-1][1]:.3f} MiB traced, {resident:.1f} MiB resident", flush=True)
    at, traced, held = np.array(seen[len(seen) // 5 :]).T / np.array([[1000.0], [1.0], [1.0]])
    slopes = [1024.0 * float(np.polyfit(at, values, 1)[0]) for values in (traced, held)]
    print(f"slope per 1000 plans after the first fifth: {slopes[0]:+.2f} KiB traced, {slopes[1]:+.2f} KiB resident")


def imports() -> None:
    for module in ("mcdas_opt", "mcdas_opt.planning.mpc", "mcdas_opt.simulation.loop"):
        runs, bare = (statistics.median(_started(f"import {m}" if m else "") for _ in range(5)) for m in (module, ""))
        print(f"import {module}: {runs - bare:.2f} s over the bare interpreter's {bare:.2f} s")


def _started(code: str) -> float:
    started = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    return time.perf_counter() - started


if __name__ == "__main__":
    main()
