"""Whether our judge and CommonRoad's drivability checker say the same of random plans: collisions, and what the vehicle can do.

    pip install 'mcdas-opt[commonroad]' commonroad-drivability-checker==2025.4.0
    python benchmarks/commonroad_agreement.py SCENARIOS/*.xml --plans 500

A plan is a random roll-out of 3 s by the kinematic bicycle. Theirs looks at the time steps (0.1 s), ours between them too. The checker's
geometry package carries a non-commercial licence: it is used here and in tests, never by the package.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.verdict import Verdict, ViolationKind
from mcdas_opt.errors import McdasError
from mcdas_opt.interop.commonroad.library import read_file
from mcdas_opt.interop.commonroad.scenario import CommonRoadScene, read_scenario
from mcdas_opt.interop.commonroad.solution import states
from mcdas_opt.planning.lane_problem.roll_out import roll_out
from mcdas_opt.simulation.neighbours import known_bodies
from mcdas_opt.verification.judge import judge

GRID = TimeGrid(steps_s=np.full(30, 0.1))
DURATION_S = 3.0
DRIVEABLE = ("speed", "acceleration", "steering angle", "steering rate", "friction circle", "dynamics residual", "re-integrated end")
THEIR_LIMIT_MPS2 = 11.5  # of the whole acceleration, in the kinematic single-track model


class Case:
    """A scenario, its obstacles that last as long as a plan, and both checkers on them."""

    def __init__(self, path: Path) -> None:
        from commonroad_dc.collision.collision_detection.pycrcc_collision_dispatch import create_collision_object
        from commonroad_dc.pycrcc import CollisionChecker

        self.name = path.stem
        self.read: CommonRoadScene = read_scenario(path)
        scenario, _ = read_file(path)
        last = self.read.first_step + round(DURATION_S / self.read.step_s)
        obstacles = {o.obstacle_id: o for o in [*scenario.dynamic_obstacles, *scenario.static_obstacles]}
        kept = {name for name, identifier in self.read.obstacles.items() if _lasts(obstacles[identifier], self.read.first_step, last)}
        self.bodies = tuple(body for body in known_bodies(self.read.scene) if body.id in kept)
        self.theirs = CollisionChecker()
        for name in kept:
            self.theirs.add_collision_object(create_collision_object(obstacles[self.read.obstacles[name]]))

    def plan(self, random: np.random.Generator) -> Trajectory:
        """From somewhere near the scenario's ego, with inputs that change every half second; some beyond what the car can do."""
        scene, vehicle = self.read.scene, self.read.scene.vehicle
        start = HostState(
            s_m=float(random.uniform(0.0, 40.0)),
            d_m=scene.host.d_m + float(random.uniform(-4.0, 4.0)),
            heading_rad=float(random.normal(0.0, 0.05)),
            speed_mps=float(random.uniform(2.0, 20.0)),
        )
        wildness = float(random.choice([0.1, 0.5, 1.5]))
        inputs = np.column_stack(
            [
                np.repeat(random.normal(0.0, 6.0 * wildness, 6), 5),
                np.repeat(random.normal(0.0, 0.3 * wildness * vehicle.steering_rate_max_radps, 6), 5),
            ]
        )
        return roll_out(start, np.full(GRID.nodes + 1, start.speed_mps), inputs, GRID, vehicle, scene.true_road)

    def ours(self, plan: Trajectory) -> Verdict:
        """With the limits of their vehicle model, one bound on the whole acceleration; jerk and road are not asked about."""
        vehicle = replace(self.read.scene.vehicle, acceleration_max_mps2=THEIR_LIMIT_MPS2)
        road = replace(self.read.scene.true_road, friction=THEIR_LIMIT_MPS2 / 9.80665)
        return judge(plan, None, vehicle, road, Prediction(name="recorded", bodies=self.bodies))

    def collides_there(self, plan: Trajectory) -> bool:
        from commonroad.prediction.prediction import TrajectoryPrediction
        from commonroad_dc.collision.collision_detection.pycrcc_collision_dispatch import create_collision_object

        vehicle = _their_vehicle()
        return bool(self.theirs.collide(create_collision_object(TrajectoryPrediction(self._driven(plan), vehicle.shape))))

    def driveable_there(self, plan: Trajectory) -> bool:
        from commonroad_dc.feasibility.feasibility_checker import trajectory_feasibility

        return bool(trajectory_feasibility(self._driven(plan), _their_vehicle(), self.read.step_s)[0])

    def _driven(self, plan: Trajectory) -> Any:
        from commonroad.scenario.trajectory import Trajectory as Driven

        return Driven(initial_time_step=self.read.first_step, state_list=states(self.read, plan))


def _their_vehicle() -> Any:
    from commonroad_dc.feasibility.vehicle_dynamics import VehicleDynamics, VehicleType

    return VehicleDynamics.KS(VehicleType.BMW_320i)


def _lasts(obstacle: Any, first: int, last: int) -> bool:
    if obstacle.obstacle_role.name != "DYNAMIC":
        return True
    return bool(obstacle.initial_state.time_step <= first and obstacle.prediction.final_time_step >= last)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenarios", nargs="+", type=Path)
    parser.add_argument("--plans", type=int, default=500)
    parser.add_argument("--driveable", type=int, default=100, help="of these, how many are also checked for what the vehicle can do (slow)")
    parser.add_argument("--seed", type=int, default=1)
    wanted = parser.parse_args(arguments)
    warnings.simplefilter("ignore")
    cases = []
    for path in wanted.scenarios:
        try:
            case = Case(path)
        except McdasError as error:
            print(f"left out: {error}")
            continue
        if case.read.step_s == 0.1:
            cases.append(case)
    random, table, able = np.random.default_rng(wanted.seed), Counter[tuple[bool, bool]](), Counter[tuple[bool, bool]]()
    for k in range(wanted.plans):
        case = cases[k % len(cases)]
        plan = case.plan(random)
        verdict = case.ours(plan)
        hits = [v for v in verdict.violations if v.kind is ViolationKind.COLLISION]
        both = (bool(hits), case.collides_there(plan))
        table[both] += 1
        if both[0] != both[1]:
            what = [{"with": v.name, "t_s": v.t_s, "gap_m": v.value} for v in hits]
            print(json.dumps({"plan": k, "scenario": case.name, "ours": both[0], "theirs": both[1], "found": what}))
        if k < wanted.driveable:
            broken = [v for v in verdict.violations if v.name in DRIVEABLE]
            pair = (not broken, case.driveable_there(plan))
            able[pair] += 1
            if pair[0] != pair[1]:
                why = [{"rule": v.name, "value": v.value, "limit": v.limit} for v in broken]
                print(json.dumps({"plan": k, "scenario": case.name, "driveable": pair[0], "there": pair[1], "found": why}), flush=True)
            if k % 20 == 19:
                print(f"{k + 1} plans: {dict(able)} (ours, theirs)", file=sys.stderr, flush=True)
    for name, counts in (("collides", table), ("driveable", able)):
        cells = {f"ours {a}, theirs {b}": counts[a, b] for a in (True, False) for b in (True, False)}
        agreed = counts[True, True] + counts[False, False]
        print(json.dumps({"question": name, "agreed": agreed, "of": sum(counts.values()), **cells}))


if __name__ == "__main__":
    main()
