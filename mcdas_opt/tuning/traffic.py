"""What a set of values costs in traffic: drives through scenes, and the objectives that come of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.evaluation.case import Traffic
from mcdas_opt.evaluation.oracle import witness
from mcdas_opt.evaluation.running.executor import Executor
from mcdas_opt.evaluation.running.journal import StoppedError
from mcdas_opt.evaluation.running.messages import Ended, Task
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.planning.adjustable import adjusted
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome, Simulation

SEEDS = {"train": 101, "validation": 202, "test": 303}  # of the suites: scenes of one set are in no other
_BESIDE_M = 0.1  # further than this from the middle of a lane is manoeuvring
_TRIED_PER_FOUND = 8  # scenes looked at for one that is avoidable
OBJECTIVES = ("collisions", "peak_lateral_mps2", "peak_jerk_mps3", "manoeuvre_m")
_LIMIT_S = 600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveFigures:
    """One drive: what the objectives are made of."""

    collided: bool
    peak_lateral_mps2: float
    peak_jerk_mps3: float
    manoeuvre_m: float
    unverified: int


@dataclass(frozen=True, slots=True, kw_only=True)
class TrafficCost:
    """Means over the drives of a set, all to be made small; `collisions` is a share of avoidable scenes."""

    collisions: float
    peak_lateral_mps2: float
    peak_jerk_mps3: float
    manoeuvre_m: float
    unverified: int
    drives: int

    @property
    def objectives(self) -> tuple[float, float, float, float]:
        return (self.collisions, self.peak_lateral_mps2, self.peak_jerk_mps3, self.manoeuvre_m)

    @property
    def score(self) -> float:
        """One number for searches that want one, and for acceptance: a collision in ten outweighs every comfort."""
        comfort = self.peak_lateral_mps2 / 4.0 + self.peak_jerk_mps3 / 20.0 + self.manoeuvre_m / 50.0
        return 100.0 * self.collisions + comfort + 100.0 * self.unverified


def cost_of(drives: Sequence[DriveFigures]) -> TrafficCost:
    return TrafficCost(
        collisions=float(np.mean([drive.collided for drive in drives])),
        peak_lateral_mps2=float(np.mean([drive.peak_lateral_mps2 for drive in drives])),
        peak_jerk_mps3=float(np.mean([drive.peak_jerk_mps3 for drive in drives])),
        manoeuvre_m=float(np.mean([drive.manoeuvre_m for drive in drives])),
        unverified=sum(drive.unverified for drive in drives),
        drives=len(drives),
    )


def avoidable(suite: str, seed: int, count: int) -> tuple[Scene, ...]:
    """`count` scripted scenes of a suite under `seed` for which the oracle's library holds a witness; fewer where there are no more."""
    cases = [
        case
        for case in expand(suite, scenes=_TRIED_PER_FOUND * count, seed=seed).cases
        if case.labelled and not case.nominal and case.traffic is Traffic.SCRIPTED
    ]
    found: list[Scene] = []
    for k in np.random.default_rng(seed).permutation(len(cases)):
        if len(found) == count:
            break
        scene = cases[int(k)].scene
        if witness(scene) is not None:
            found.append(scene)
    return tuple(found)


def drive(scene: Scene, values: Mapping[str, float]) -> dict[str, Any]:
    """One scene driven by the MPC with `values`, as plain numbers: what a worker process sends back. Common random numbers: the noise is
    the scene's own, whatever the values."""
    made = adjusted(values)
    method = made.method(scene.vehicle)
    run = simulate(scene, Planner(vehicle=scene.vehicle, method=method, settings=made.settings, road=scene.assumed_road))
    return {
        "collided": run.outcome is not Outcome.SAFE,
        "peak_lateral_mps2": run.max_lateral_acceleration_mps2,
        "peak_jerk_mps3": run.max_jerk_mps3,
        "manoeuvre_m": manoeuvre_m(run),
        "unverified": run.unverified_plans,
    }


def figures_of(document: Mapping[str, Any]) -> DriveFigures:
    return DriveFigures(**{f.name: document[f.name] for f in fields(DriveFigures)})


def manoeuvre_m(run: Simulation) -> float:
    """Distance driven further than 0.1 m from the middle of a lane [m]."""
    s, d, road = run.trajectory.s_m, run.trajectory.d_m, run.scene.true_road
    centre = np.array([road.lane_centre_m(road.lane_of(here, along), along) for here, along in zip(d.tolist(), s.tolist(), strict=True)])
    beside = np.abs(d - centre) > _BESIDE_M
    return float(np.diff(s)[beside[1:]].sum())


Drives = Callable[[Sequence[Scene], Mapping[str, float]], Iterator[DriveFigures]]


def in_turn(scenes: Sequence[Scene], values: Mapping[str, float]) -> Iterator[DriveFigures]:
    """Drives in this process, one after another."""
    for scene in scenes:
        yield figures_of(drive(scene, values))


def on_executor(executor: Executor) -> Drives:
    """Drives side by side; what comes out is in the order of the scenes, so that it does not depend on who was faster.

    Raises `StoppedError` with the reason where a drive itself fails: that is a fault of ours, not a bad set of values.
    """

    def drives(scenes: Sequence[Scene], values: Mapping[str, float]) -> Iterator[DriveFigures]:
        tasks = [Task(drive, (scene, dict(values)), _LIMIT_S) for scene in scenes]
        for number, answer in sorted(executor.run(tasks), key=lambda one: one[0]):
            if answer.ended is not Ended.RETURNED:
                raise StoppedError(f"scene {scenes[number].name}: {answer.reason or answer.ended.value}")
            yield figures_of(answer.value)

    return drives
