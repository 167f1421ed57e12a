"""How much faster two workers are than one: the same drives by both pools in turn, in one run.

Each round drives every scene with both pools, the one that went second before going first now, so that whoever else uses the machine
slows both alike. A few drives of unequal length end unevenly: it takes some dozens. The ratio means something only where as many cores are
free as there are workers: what others take is measured (Linux) and said.

python benchmarks/worker_scaling.py --suite sandwich --planner mpc --scenes 40 --rounds 2
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from statistics import median

from mcdas_opt.evaluation.row import drive
from mcdas_opt.evaluation.running.executor import ProcessPool
from mcdas_opt.evaluation.running.messages import Ended, Task
from mcdas_opt.evaluation.suites import expand

STAT = Path("/proc/stat")
IDLE_WAIT_S = 2.0


def busy_s() -> float:
    """Seconds that all cores together have been busy since the machine started."""
    user, nice, system, *_ = (int(word) for word in STAT.read_text().split("\n", 1)[0].split()[1:])
    return (user + nice + system) / os.sysconf("SC_CLK_TCK")


def cores_taken_by_others() -> float:
    """Cores that are busy while this process only waits."""
    before, started = busy_s(), time.perf_counter()
    time.sleep(IDLE_WAIT_S)
    return (busy_s() - before) / (time.perf_counter() - started)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", default="sandwich")
    parser.add_argument("--planner", default="mpc")
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    cases = expand(arguments.suite, arguments.scenes).cases
    tasks = [Task(drive, (case, arguments.planner, "kinematic")) for case in cases]
    pools = {count: ProcessPool(count) for count in (1, arguments.workers)}
    rounds: list[dict[int, float]] = []
    taken: list[float] = []
    try:
        for pool in pools.values():  # every child has imported and built what it needs
            for _ in pool.run(tasks[:1] * arguments.workers):
                pass
        for number in range(arguments.rounds):
            if STAT.is_file():
                taken.append(cores_taken_by_others())
            took = {}
            for count in sorted(pools, reverse=number % 2 == 1):
                started = time.perf_counter()
                answers = [answer for _, answer in pools[count].run(tasks)]
                took[count] = time.perf_counter() - started
                assert all(answer.ended is Ended.RETURNED for answer in answers)
            rounds.append(took)
    finally:
        for pool in pools.values():
            pool.close()
    drives = arguments.rounds * len(tasks)
    for count in pools:
        seconds = sum(took[count] for took in rounds)
        print(f"{count} workers: {drives} drives in {seconds:.1f} s, {drives / seconds:.2f}/s")
    ratios = [took[1] / took[arguments.workers] for took in rounds]
    print(f"ratio {median(ratios):.2f}, the median of " + ", ".join(f"{ratio:.2f}" for ratio in ratios))
    if taken:
        free = (os.cpu_count() or 1) - max(taken)
        print(f"{os.cpu_count()} cores, of which others took " + ", ".join(f"{cores:.1f}" for cores in taken))
        if free < arguments.workers - 0.2:
            print(f"not a measurement of scaling: only {max(free, 0.0):.1f} cores were free for {arguments.workers} workers")


if __name__ == "__main__":
    main()
