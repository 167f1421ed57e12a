"""Is the answer there when it is due? Deadlines of 5 to 50 ms, of which share of the cycles, and by how much the worst is late.

    python -m benchmarks.deadlines [--plans 2000] [--deadlines-ms 5,10,20,50] [--families sandwich,dense] [--load 0]

Random traffic of `random_traffic`, a planner with `deadline_s` for each deadline, warmed up first. "own" is the time that the processor
spent on the answer, which a loaded machine hardly changes; "wall" is what a car would wait. `--load N` keeps N processes busy beside it.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from benchmarks.random_traffic import KINDS, ask, episodes
from mcdas_opt import Plan, Planner, Situation, Status

FAMILIES = tuple(name for name in KINDS if name not in ("baselines", "lincoln"))


class Timed:
    """A planner with a deadline, that is asked by the clock."""

    def __init__(self, deadline_s: float) -> None:
        self.planner = Planner(deadline_s=deadline_s)
        self.wall_s: list[float] = []
        self.own_s: list[float] = []
        self.statuses: Counter[str] = Counter()
        self.unverified = 0

    def drive(self, families: Sequence[str], plans: int, first: int = 0) -> None:
        """About so many plans, over all families, from episodes of that number on."""
        _warm_up(self.planner)
        for family in families:
            for one in episodes(family, plans // len(families), first):
                self.planner.reset()
                for _ in ask(one, self):
                    pass

    def plan(self, situation: Situation) -> Plan:
        wall, own = time.perf_counter(), time.thread_time()
        plan = self.planner.plan(situation)
        self.own_s.append(time.thread_time() - own)
        self.wall_s.append(time.perf_counter() - wall)
        self.statuses[plan.status.value] += 1
        self.unverified += plan.status is not Status.UNAVOIDABLE and not plan.verdict.passed
        return plan


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--plans", type=int, default=2000, help="of each deadline, over all families")
    parser.add_argument("--deadlines-ms", default="5,10,20,50")
    parser.add_argument("--families", default=",".join(FAMILIES))
    parser.add_argument("--load", type=int, default=0, help="processes that keep the machine busy")
    asked = parser.parse_args()
    families = asked.families.split(",")
    headings = f"{'deadline':>9s}{'plans':>8s}{'in time own':>13s}{'wall':>8s}{'own p50':>9s}{'p99':>8s}{'max':>8s}{'wall max':>10s}"
    print(f"{headings}  statuses, unverified")
    with busy(asked.load):
        for deadline_s in (1e-3 * float(text) for text in asked.deadlines_ms.split(",")):
            timed = Timed(deadline_s)
            timed.drive(families, asked.plans)
            own, wall = 1e3 * np.array(timed.own_s), 1e3 * np.array(timed.wall_s)
            shares = [f"{(took <= 1e3 * deadline_s).mean():.2%}" for took in (own, wall)]
            p50, p99, most = np.percentile(own, [50.0, 99.0, 100.0])
            print(
                f"{1e3 * deadline_s:6.0f} ms{own.size:8d}{shares[0]:>13s}{shares[1]:>8s}{p50:9.1f}{p99:8.1f}{most:8.1f}{wall.max():10.1f}  "
                f"{dict(timed.statuses)}, {timed.unverified}",
                flush=True,
            )


def _warm_up(planner: Planner) -> None:
    for one in (one for family in ("sandwich", "dense") for one in episodes(family, 6)):
        planner.reset()
        planner.plan(one.first)


@contextmanager
def busy(processes: int) -> Iterator[None]:
    """Beside so many processes that never wait."""
    others = [multiprocessing.Process(target=_spin, daemon=True) for _ in range(processes)]
    for other in others:
        other.start()
    try:
        yield
    finally:
        for other in others:
            other.kill()


def _spin() -> None:
    """As long as who asked for it lives, however that ends."""
    parent = multiprocessing.parent_process()
    while parent is not None and parent.is_alive():
        pass


if __name__ == "__main__":
    main()
