"""CommonRoad scenarios with another recorded driver's place for the ego: as many new ones as there are cars on the same maps.

    python benchmarks/commonroad_egos.py --data FOLDER --out FOLDER [--each 1] [--seed 1] [--least-s 6] [--turned]
    mcdas-opt benchmark commonroad --data OUT --planners mpc --workers 1 --out RESULTS

Of each scenario `--each` cars are drawn that are seen for long enough, and that move. Each leaves the recording, and a planning problem
begins where it begins and asks for the place where it was seen last, as large as a car and a half, until four seconds later. So the drive
that is asked for is possible: somebody drove it. Who follows in the recording does not react, as ever.

`--turned` turns and moves each scenario's plane besides, by a drawn angle and by as much as UTM coordinates have.
"""

from __future__ import annotations

import argparse
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np

LEAST_WAY_M, LEAST_MPS = 15.0, 1.0
LATER_S = 4.0
FAR_M = (691_000.0, 5_335_000.0)


def candidates(scenario: Any, least_s: float) -> list[Any]:
    """The obstacles whose drive can be asked for: cars, on a lanelet at the beginning, from the first step on."""
    found = []
    for obstacle in scenario.dynamic_obstacles:
        driven = getattr(obstacle.prediction, "trajectory", None)  # some are sets, some are none
        states = [obstacle.initial_state, *driven.state_list] if driven is not None else []
        if obstacle.obstacle_type.value != "car" or len(states) * scenario.dt < least_s or obstacle.initial_state.time_step != 0:
            continue
        way = float(np.linalg.norm(np.asarray(states[-1].position) - np.asarray(states[0].position)))
        on_lane = any(scenario.lanelet_network.find_lanelet_by_position([np.asarray(states[0].position)])[0])
        if way >= LEAST_WAY_M and states[0].velocity >= LEAST_MPS and on_lane:
            found.append(obstacle)
    return found


def problem_of(obstacle: Any, step_s: float) -> Any:
    """The planning problem to drive as this obstacle did."""
    from commonroad.common.util import AngleInterval, Interval
    from commonroad.geometry.shape import Rectangle
    from commonroad.planning.goal import GoalRegion
    from commonroad.planning.planning_problem import PlanningProblem
    from commonroad.scenario.state import CustomState, InitialState

    first, last = obstacle.initial_state, obstacle.prediction.trajectory.state_list[-1]
    begins = InitialState(
        position=np.asarray(first.position),
        orientation=first.orientation,
        velocity=first.velocity,
        time_step=0,
        yaw_rate=0.0,
        slip_angle=0.0,
    )
    area = Rectangle(7.0, 3.0, np.asarray(last.position), last.orientation)
    until = int(last.time_step + LATER_S / step_s)
    ends = CustomState(
        position=area,
        time_step=Interval(max(int(0.6 * last.time_step), 1), until),
        orientation=AngleInterval(last.orientation - 0.5, last.orientation + 0.5),
    )
    return PlanningProblem(int(obstacle.obstacle_id) + 900_000, begins, GoalRegion([ends]))


def rewritten(path: Path, out: Path, *, each: int, least_s: float, turned: bool, random: np.random.Generator) -> list[Path]:
    """Writes the scenario with others' places for the ego into a folder; the files."""
    from commonroad.common.file_reader import CommonRoadFileReader
    from commonroad.common.file_writer import CommonRoadFileWriter, OverwriteExistingFile
    from commonroad.planning.planning_problem import PlanningProblemSet

    scenario, _ = CommonRoadFileReader(path).open()
    possible = candidates(scenario, least_s)
    drawn = [possible[k].obstacle_id for k in random.permutation(len(possible))[:each]]
    files = []
    for identifier in drawn:
        scenario, _ = CommonRoadFileReader(path).open()
        obstacle = scenario.obstacle_by_id(identifier)
        problems = PlanningProblemSet([problem_of(obstacle, scenario.dt)])
        scenario.remove_obstacle(obstacle)
        if turned:
            angle = float(random.uniform(-math.pi, math.pi))
            scenario.translate_rotate(np.array(FAR_M), angle)
            problems.translate_rotate(np.array(FAR_M), angle)
        files.append(out / f"{path.stem}-{identifier}.xml")
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", ".*has no lanelet type.*")  # a line for each lanelet
            CommonRoadFileWriter(scenario, problems).write_to_file(str(files[-1]), OverwriteExistingFile.ALWAYS)
    return files


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--each", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--least-s", type=float, default=6.0)
    parser.add_argument("--turned", action="store_true")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    written = 0
    for number, path in enumerate(sorted(asked.data.rglob("*.xml"))):
        random = np.random.default_rng([asked.seed, number])
        written += len(rewritten(path, asked.out, each=asked.each, least_s=asked.least_s, turned=asked.turned, random=random))
    print(f"{written} scenarios in {asked.out}")


if __name__ == "__main__":
    main()
