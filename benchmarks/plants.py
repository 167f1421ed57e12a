"""The same avoidable scenes on every plant: safe or lost, cycles without a way out, spins, and friction felt too low.

    python benchmarks/plants.py mid-vehicle --scenes 60 --seed 8100 --workers 2
    python benchmarks/plants.py sandwich,curved --scenes 6 --plants kinematic,dynamic        # a quick look: half a minute

Avoidable scenes of one or more suites (the oracle drives the kinematic vehicle), and all of one whose traffic reacts, with the host's
vehicle replaced by the one named, are driven by a planner on all plants with the same seeds. On every plant the road's friction is the peak
of the tyres' force over their load. Of each avoidable scene that a plant loses it is asked whether it can follow the oracle's own drive:
tracked by the same controller, without any planner.
"""

from __future__ import annotations

import argparse
import multiprocessing
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
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
from mcdas_opt.simulation.record import Outcome, Simulation

SPUN_RAD = 0.35  # sideslip of the rear axle at which a drive counts as one that spun, ...
SPUN_MPS = 5.0  # ... if it is not about to stand
FELT_LOW = 0.7  # of the friction there is


@dataclass(frozen=True)
class OraclesDrive(Driver):
    """A driver that goes on along one trajectory, whatever happens."""

    trajectory: Trajectory
    name: str = "the oracle's drive"

    def step(self, measurements: Sequence[Scan], host: HostState, now: float, **asked: object) -> Plan:
        t = self.trajectory.t_s
        later = t > now + 1e-9
        here = [np.interp(now, t, column) for column in self.trajectory.states.T]
        states = np.vstack([here, self.trajectory.states[later]])
        rest = Trajectory.from_states(np.concatenate([[0.0], t[later] - now]), states, np.zeros((len(states), 2)))
        return Plan(planner=self.name, mode=Mode.HOLD, verdict=Verdict(), prediction="none", trajectory=rest)


@dataclass(frozen=True, kw_only=True)
class Row:
    """One drive; `followed`: how the oracle's own drive ended on this plant, where the planner's was lost."""

    suite: str
    index: int
    plant: str
    ended: str
    unavoidable: int
    unverified: int
    spun: bool
    felt: float  # least friction that plans were made with, over the road's
    sideslip_rad: float
    followed: str = ""


def ended(drive: Simulation) -> str:
    return drive.collided_with or "off the road" if drive.outcome is not Outcome.SAFE else "safe"


def row(suite: str, case: Case, drive: Simulation, followed: str) -> Row:
    history = drive.history
    slip = np.abs(np.where(history.states[:, 3] > SPUN_MPS, history.sideslip_rad, 0.0))
    return Row(
        suite=suite,
        index=case.index,
        plant=drive.plant,
        ended=ended(drive),
        unavoidable=drive.unavoidable,
        unverified=drive.unverified_plans,
        spun=bool(slip.max() > SPUN_RAD),
        felt=float(history.friction.min() / case.scene.road.friction),
        sideslip_rad=float(slip.max()),
        followed=followed,
    )


def with_vehicle(scene: Scene, vehicle: str) -> Scene:
    document = scene.model_dump(exclude_unset=True)
    document["host"]["vehicle"] = vehicle
    return Scene.model_validate(document)


def rows_of(asked: tuple[str, Case], *, planner: str, plants: Sequence[str], vehicle: str, controller: str | None) -> list[Row]:
    """A row for each plant; none for a scene that is not avoidable."""
    suite, given = asked
    scene = with_vehicle(given.scene, vehicle)
    label = label_scene(scene) if given.labelled else None
    if label is not None and label.kind is not Kind.A:
        return []
    rows = []
    for plant in plants:
        drive, followed = simulate(scene, planner, plant, controller=controller), ""
        if drive.outcome is not Outcome.SAFE and label is not None and label.witness is not None:
            followed = ended(simulate(scene, OraclesDrive(label.witness), plant, controller=controller))
        rows.append(row(suite, given, drive, followed))
    return rows


def report(rows: Sequence[Row], plants: Sequence[str]) -> None:
    heads = ("safe", "unavoidable cycles", "spun", f"felt < {FELT_LOW:g}", "sideslip p99 [rad]", "unverified")
    print(f"{'plant':>12} {heads[0]:>22}", *(f"{head:>{len(head) + 1}}" for head in heads[1:]), " lost")
    for plant in plants:
        own = [row for row in rows if row.plant == plant]
        share = Share(k=sum(row.ended == "safe" for row in own), n=len(own))
        low, high = (100 * q for q in share.interval)
        lost = ", ".join(f"{n} {how}" for how, n in sorted(Counter(row.ended for row in own).items()) if how != "safe")
        counts = (
            sum(row.unavoidable for row in own),
            sum(row.spun for row in own),
            sum(row.felt < FELT_LOW for row in own),
            f"{np.percentile([row.sideslip_rad for row in own], 99):.3f}",
            sum(row.unverified for row in own),
        )
        table = (f"{count:>{len(head) + 1}}" for head, count in zip(heads[1:], counts, strict=True))
        print(f"{plant:>12} {f'{share.k}/{share.n} [{low:.0f}, {high:.0f}] %':>22}", *table, f" {lost}")
    for row in rows:
        if row.ended != "safe":
            followed = f"; the oracle's own drive, followed: {row.followed}" if row.followed else ""
            facts = f"felt {row.felt:.2f} of the friction, sideslip {row.sideslip_rad:.2f} rad, {row.unavoidable} cycles unavoidable"
            print(f"  {row.suite} {row.index} {row.plant}: {row.ended}; {facts}{followed}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suites", nargs="?", default="mid-vehicle", help="names, with commas between")
    parser.add_argument("--planner", default="mpc")
    parser.add_argument("--plants", default="kinematic,dynamic,std,multi-body")
    parser.add_argument("--vehicle", default="bmw_320i", help="what std and multi-body are; or a vehicle file, with delays for instance")
    parser.add_argument("--controller", help="tracks the plans; default the plant's")
    parser.add_argument("--scenes", type=int, default=40, help="of each suite")
    parser.add_argument("--seed", type=int, default=8100)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    plants = arguments.plants.split(",")
    asked = [(suite, case) for suite in arguments.suites.split(",") for case in expand(suite, arguments.scenes, arguments.seed).cases]
    task = partial(rows_of, planner=arguments.planner, plants=plants, vehicle=arguments.vehicle, controller=arguments.controller)
    with multiprocessing.get_context("spawn").Pool(arguments.workers) as pool:
        found = list(pool.imap(task, asked))
    counted = f"{sum(bool(rows) for rows in found)} asked of {len(asked)} scenes"
    print(f"{arguments.suites}, seed {arguments.seed}, {arguments.planner}, {arguments.vehicle}: {counted}")
    report([row for rows in found for row in rows], plants)


if __name__ == "__main__":
    main()
