"""How long a step of a SUMO drive takes, and how much of it the plan: in a network of anybody's, where many are around the host.

    pip install 'mcdas-opt[sumo]'
    python benchmarks/sumo_steps.py CONFIG.sumocfg --ego NAME [--seed N] [--seconds 40]

Times are processor time of the thread. To compare two versions call this file by its path with PYTHONPATH set to each, in turn.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path
from typing import Any

import libsumo

from mcdas_opt.interop.sumo.driver import SumoDriver


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("configuration", type=Path)
    parser.add_argument("--ego", required=True, help="the vehicle that is driven, from its departure on")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=40.0)
    options = parser.parse_args()

    step_length = "--step-length", "0.1", "--time-to-teleport", "-1", "--collision.action", "warn"
    libsumo.start(["sumo", "-c", str(options.configuration), "--seed", str(options.seed), *step_length, "--no-step-log", "--no-warnings"])
    while options.ego not in libsumo.vehicle.getIDList():
        if libsumo.simulation.getMinExpectedNumber() == 0:
            raise SystemExit(f"{options.ego} never departs")
        libsumo.simulationStep()
    driver = SumoDriver(libsumo, options.ego, "mpc")
    assert driver.planner is not None
    plan, plans, tracks, steps = driver.planner.plan, list[float](), list[int](), list[float]()

    def timed(situation: Any) -> Any:
        started = time.thread_time()
        answer = plan(situation)
        plans.append(time.thread_time() - started)
        tracks.append(len(situation.tracks))
        return answer

    driver.planner.plan = timed  # type: ignore[method-assign]
    until_s = libsumo.simulation.getTime() + options.seconds
    goes_on = True
    while goes_on and libsumo.simulation.getTime() < until_s:
        started = time.thread_time()
        goes_on = driver.step()
        steps.append(time.thread_time() - started)
    for name, values in (("step", steps), ("plan", plans)):
        p50, p99 = statistics.median(values), statistics.quantiles(values, n=100)[-1]
        print(f"{name}: {len(values)}, p50 {1e3 * p50:.1f} ms, p99 {1e3 * p99:.1f} ms")
    print(f"tracks: {statistics.mean(tracks):.1f} on average")


if __name__ == "__main__":
    main()
