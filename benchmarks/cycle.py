"""Where the time of a cycle goes: p50 and p99 of the whole step, and the share of each stage, on shipped scenes.

    python benchmarks/cycle.py [SCENE ...] [--planner NAME] [--repeats N]

Absolute times are this machine's; read the ratios. The import of the package is timed in fresh processes.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

import numpy as np

from mcdas_opt import Planner, load_scene, simulate
from mcdas_opt.planning import mpc

SCENES = ("sandwich-60-40", "front-braking-with-follower", "curved-road", "benign-following")


def timed(spent: dict[str, list[float]], name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def run(*args: Any, **kwargs: Any) -> Any:
        started = time.perf_counter()
        try:
            return function(*args, **kwargs)
        finally:
            spent[name].append(time.perf_counter() - started)

    return run


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--planner", default="mpc")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()

    stages: dict[str, list[float]] = defaultdict(list)
    mpc.assess = timed(stages, "assess", mpc.assess)  # type: ignore[attr-defined]
    mpc.judge_all = timed(stages, "judge", mpc.judge_all)  # type: ignore[attr-defined]
    mpc.worth = timed(stages, "worth", mpc.worth)  # type: ignore[attr-defined]
    cycles: list[float] = []
    for name in options.scenes:
        scene = load_scene(name)
        for repeat in range(options.repeats):
            planner = Planner(vehicle=scene.vehicle, method=options.planner, road=scene.assumed_road)
            planner.tracker.update = timed(stages, "track", planner.tracker.update)  # type: ignore[method-assign]
            if isinstance(planner.method, mpc.MpcMethod):
                planner.method.stage.solve = timed(stages, "solve", planner.method.stage.solve)  # type: ignore[method-assign]
            step = planner.step
            planner.step = timed(stages, "step", step)  # type: ignore[method-assign]
            drive = simulate(scene, planner, seed=repeat)
            print(f"{name}, seed {repeat}: {drive.outcome}, {drive.plans} plans, {drive.unverified_plans} unverified")
    cycles = stages.pop("step")
    p50, p99 = (1e3 * float(np.quantile(cycles, q)) for q in (0.5, 0.99))
    print(f"\nwhole step, {len(cycles)} cycles: p50 {p50:.2f} ms, p99 {p99:.2f} ms, max {1e3 * max(cycles):.2f} ms")
    print(f"{'stage':10} {'calls':>7} {'median ms':>10} {'p99 ms':>9} {'share':>7}")
    for name, values in sorted(stages.items(), key=lambda item: -sum(item[1])):
        median, tail = 1e3 * statistics.median(values), 1e3 * float(np.quantile(values, 0.99))
        print(f"{name:10} {len(values):7d} {median:10.3f} {tail:9.3f} {sum(values) / sum(cycles):7.1%}")
    for module in ("mcdas_opt", "mcdas_opt.planning.mpc", "mcdas_opt.simulation.loop"):
        runs = []
        for _ in range(5):
            started = time.perf_counter()
            subprocess.run([sys.executable, "-c", f"import {module}"], check=True)
            runs.append(time.perf_counter() - started)
        bare = statistics.median(_bare() for _ in range(5))
        print(f"import {module}: {statistics.median(runs) - bare:.2f} s over the bare interpreter's {bare:.2f} s")


def _bare() -> float:
    started = time.perf_counter()
    subprocess.run([sys.executable, "-c", ""], check=True)
    return time.perf_counter() - started


if __name__ == "__main__":
    main()
