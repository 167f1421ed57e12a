"""How much faster two workers are than one: the same drives by both pools in turn, in one run on an otherwise idle machine.

python benchmarks/worker_scaling.py --suite sandwich --planner mpc --scenes 12 --rounds 2
"""

from __future__ import annotations

import argparse
import time

from mcdas_opt.evaluation.row import drive
from mcdas_opt.evaluation.running.executor import ProcessPool
from mcdas_opt.evaluation.running.messages import Ended, Task
from mcdas_opt.evaluation.suites import expand


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", default="sandwich")
    parser.add_argument("--planner", default="mpc")
    parser.add_argument("--scenes", type=int, default=12)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    cases = expand(arguments.suite, arguments.scenes).cases
    tasks = [Task(drive, (case, arguments.planner, "kinematic")) for case in cases]
    pools = {count: ProcessPool(count) for count in (1, arguments.workers)}
    took = dict.fromkeys(pools, 0.0)
    try:
        for pool in pools.values():  # every child has imported and built what it needs
            for _ in pool.run(tasks[:1] * arguments.workers):
                pass
        for _ in range(arguments.rounds):
            for count, pool in pools.items():
                started = time.perf_counter()
                answers = [answer for _, answer in pool.run(tasks)]
                took[count] += time.perf_counter() - started
                assert all(answer.ended is Ended.RETURNED for answer in answers)
    finally:
        for pool in pools.values():
            pool.close()
    drives = arguments.rounds * len(tasks)
    for count, seconds in took.items():
        print(f"{count} workers: {drives} drives in {seconds:.1f} s, {drives / seconds:.2f}/s")
    print(f"ratio {took[1] / took[arguments.workers]:.2f}")


if __name__ == "__main__":
    main()
