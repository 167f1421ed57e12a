"""The same scenes driven by the kinematic and by the dynamic vehicle.

    python benchmarks/two_plants.py sandwich --scenes 40 --seed 7100 --workers 2

Avoidable scenes of a suite (the oracle drives the kinematic vehicle), and all of one whose traffic reacts, are driven by a planner on both
plants with the same seeds. Of each avoidable one that the dynamic vehicle loses it is asked whether it can follow the oracle's own drive:
tracked by the same controller, without any planner.
"""

from __future__ import annotations

import argparse
import multiprocessing
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.evaluation.case import Case
from mcdas_opt.evaluation.labels import Kind, label_scene
from mcdas_opt.evaluation.statistics import Share
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.simulation.driver import Driver
from mcdas_opt.simulation.loop import simulate

PLANTS = ("kinematic", "dynamic")


@dataclass(frozen=True)
class KnowsTheWay(Driver):
    """A driver that goes on along one trajectory, whatever happens."""

    trajectory: Trajectory
    name: str = "the oracle's drive"

    def step(self, measurements: Sequence[Scan], host: HostState, now: float, **asked: Any) -> Plan:
        t = self.trajectory.t_s
        later = t > now + 1e-9
        here = [np.interp(now, t, column) for column in self.trajectory.states.T]
        states = np.vstack([here, self.trajectory.states[later]])
        rest = Trajectory.from_states(np.concatenate([[0.0], t[later] - now]), states, np.zeros((len(states), 2)))
        return Plan(planner=self.name, mode=Mode.HOLD, verdict=Verdict(), prediction="none", trajectory=rest)


def outcomes(case: Case, *, planner: str) -> dict[str, Any] | None:
    """Outcome on each plant, and of the oracle's drive where the dynamic vehicle is not safe; None for unavoidable ones."""
    label = label_scene(case.scene) if case.labelled else None
    if label is not None and label.kind is not Kind.A:
        return None
    drives = {plant: simulate(case.scene, planner, plant) for plant in PLANTS}
    found: dict[str, Any] = {"index": case.index, **{plant: drive.outcome.value for plant, drive in drives.items()}}
    found["unverified"] = sum(drive.unverified_plans for drive in drives.values())
    if found["dynamic"] != "safe" and label is not None and label.witness is not None:
        found["followed"] = simulate(case.scene, KnowsTheWay(label.witness), "dynamic").outcome.value
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suite", nargs="?", default="sandwich")
    parser.add_argument("--planner", default="mpc")
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=7100)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    cases = expand(arguments.suite, arguments.scenes, arguments.seed).cases
    with multiprocessing.get_context("spawn").Pool(arguments.workers) as pool:
        rows = [row for row in pool.imap(partial(outcomes, planner=arguments.planner), cases) if row is not None]
    print(f"{arguments.suite}, seed {arguments.seed}, {arguments.planner}: {len(rows)} asked of {len(cases)} scenes")
    for plant in PLANTS:
        share = Share(k=sum(row[plant] == "safe" for row in rows), n=len(rows))
        low, high = share.interval
        print(f"{plant:>10}  safe {share.k}/{share.n} [{100 * low:.0f}, {100 * high:.0f}] %")
    print(f"unverified plans {sum(row['unverified'] for row in rows)}")
    for row in rows:
        if row["dynamic"] != "safe":
            followed = row.get("followed", "not kept")
            print(f"  scene {row['index']}: {row['kinematic']}, {row['dynamic']}; the oracle's own drive, followed by tyres: {followed}")


if __name__ == "__main__":
    main()
