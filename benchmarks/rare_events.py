"""Crash rates below 1e-3: subset simulation and importance sampling against crude Monte Carlo, then a planner in the loop.

python benchmarks/rare_events.py --crude 2000000 --seed 1
python benchmarks/rare_events.py --planner idm-mobil --per-level 200 --seed 1
"""

from __future__ import annotations

import argparse
import time
from functools import partial

from benchmarks.braking_lead import DIMENSIONS, BrakingLead
from mcdas_opt.evaluation.rare_events import Estimate, crude, importance_sampling, subset_simulation


def line(one: Estimate, took_s: float, truth: float | None = None) -> str:
    size = "" if one.effective_sample_size is None else f", effective sample size {one.effective_sample_size:.0f}"
    against = "" if truth is None else f", {one.probability / truth:.3f} of crude"
    return f"{one.method:>20}: {one.probability:.3e} +- {100 * one.variation:.0f} %, {one.runs} runs, {took_s:.1f} s{size}{against}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--planner", help="drive this planner in the loop; without it the cheap baseline")
    parser.add_argument("--plant", default="kinematic")
    parser.add_argument("--crude", type=int, default=2_000_000, help="runs of crude Monte Carlo on the baseline")
    parser.add_argument("--per-level", type=int, default=2000)
    parser.add_argument("--samples", type=int, default=2000, help="runs of importance sampling")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    study = BrakingLead()
    gap = study.baseline_gap if arguments.planner is None else partial(study.driven_gap, planner=arguments.planner, plant=arguments.plant)
    truth = None
    if arguments.planner is None:
        started = time.perf_counter()
        counted = crude(gap, DIMENSIONS, arguments.crude, arguments.seed)
        truth = counted.probability
        print(line(counted, time.perf_counter() - started))
    started = time.perf_counter()
    subset = subset_simulation(gap, DIMENSIONS, arguments.seed + 1, arguments.per_level)
    print(line(subset, time.perf_counter() - started, truth))
    print("levels [m]: " + ", ".join(f"{level:.2f}" for level in subset.levels_m))
    if len(subset.crashes) <= 2 * DIMENSIONS:
        print("too few crashes for importance sampling")
        return
    started = time.perf_counter()
    weighted = importance_sampling(gap, subset.crashes, arguments.samples, arguments.seed + 2)
    print(line(weighted, time.perf_counter() - started, truth))


if __name__ == "__main__":
    main()
