"""CommonRoad's reactive planner driven as its authors do, and paired with rows of `mcdas-opt benchmark commonroad`.

    python benchmarks/commonroad_reactive.py OUT.jsonl SCENARIO.xml ... [--horizon 60] [--rows results/rows.csv]

On its own route (commonroad-route-planner's shortest) and in its own lanelet frame, told the recorded future of everybody, replanned every
third step of 0.1 s, the desired speed that of the goal or of the beginning, BMW 320i, `velocity_keeping`, four levels of sampling, one
process: the settings of the package's version 2025.1, whose horizon is 60 steps; its example `ZAM_Over-1_1.yaml` has 20. The route
goes on straight for 100 m at both ends, without which the package raises where a plan reaches beyond it. A drive ends where
it is in the goal as CommonRoad judges, without a plan, or with the goal's last moment. Judged by footprints: touching a recorded one, or
reaching off the lanelets by more than 2 % of the footprint. Stopped at any moment, the same command goes on where it was.
"""

from __future__ import annotations

import argparse
import csv
import json
import logging
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from mcdas_opt.interop.commonroad.library import read_file

EVERY, OFF_SHARE, EXTENDED_M = 3, 0.02, 100.0


def drive(path: Path, horizon: int) -> dict[str, Any]:
    """How one drive ends."""
    from commonroad_rp.reactive_planner import ReactivePlanner
    from commonroad_rp.utility.config import PlanningConfiguration, ReactivePlannerConfiguration
    from commonroad_rp.utility.utils_coordinate_system import create_coordinate_system, create_initial_ref_path

    scenario, problems = read_file(path)
    problem = next(iter(problems.planning_problem_dict.values()))
    config = ReactivePlannerConfiguration(planning=PlanningConfiguration(time_steps_computation=horizon, dt=float(scenario.dt)))
    config.debug.multiproc = False
    config.update(scenario=scenario, planning_problem=problem)
    planner = ReactivePlanner(config)
    line = _extended(create_initial_ref_path(scenario.lanelet_network, problem))
    planner.set_reference_path(coordinate_system=create_coordinate_system(line))
    planner.record_state_and_input(planner.x_0)
    planner.set_desired_velocity(current_speed=planner.x_0.velocity)
    last = max(int(getattr(state.time_step, "end", state.time_step)) for state in problem.goal.state_list)
    took: list[float] = []
    plan: Any = None
    end = "time"
    while True:
        step = planner.x_0.time_step - problem.initial_state.time_step
        if planner.goal_reached():
            end = "goal"
            break
        if planner.x_0.time_step >= last:
            break
        if step % EVERY == 0:
            planner.set_desired_velocity(current_speed=planner.x_0.velocity)
            begun = time.perf_counter()
            plan = planner.plan()
            took.append(1e3 * (time.perf_counter() - begun))
            if plan is None:
                end = "no plan"
                break
        k = 1 + step % EVERY
        state = plan[0].state_list[k]
        planner.record_state_and_input(state)
        planner.reset(
            initial_state_cart=state,
            initial_state_curv=(plan[1][k], plan[2][k]),
            collision_checker=planner.collision_checker,
            coordinate_system=planner.coordinate_system,
        )
    host = planner.convert_state_list_to_commonroad_object(planner.record_state_list)
    found = {
        "scenario": path.stem,
        "ends": end,
        "steps": len(planner.record_state_list) - 1,
        "p50_ms": float(np.median(took)) if took else None,
    }
    return found | _judged(scenario, host, planner.record_state_list)


def _extended(line: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Going on straight at both ends."""
    (a, b), (y, z) = line[:2], line[-2:]
    before, after = (EXTENDED_M * way / np.hypot(*way) for way in (a - b, z - y))
    shares = np.linspace(0.0, 1.0, 100)[1:, None]
    return np.concatenate([(a + shares * before)[::-1], line, z + shares * after])


def _judged(scenario: Any, host: Any, states: list[Any]) -> dict[str, Any]:
    ground = shapely.union_all([shapely.Polygon(lanelet.polygon.vertices).buffer(0.0) for lanelet in scenario.lanelet_network.lanelets])
    for state in states:
        occupied = host.occupancy_at_time(state.time_step)
        if occupied is None:
            continue
        body = shapely.Polygon(occupied.shape.vertices)
        for other in (*scenario.dynamic_obstacles, *scenario.static_obstacles):
            there = other.occupancy_at_time(state.time_step)
            if there is None or state.time_step == states[0].time_step:
                continue
            if body.intersects(there.shape.shapely_object):
                return {"lost": "collision", "with": int(other.obstacle_id), "at": int(state.time_step)}
        if body.difference(ground).area > OFF_SHARE * body.area and state.time_step != states[0].time_step:
            return {"lost": "off the road", "at": int(state.time_step)}
    return {"lost": ""}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("scenarios", type=Path, nargs="+")
    parser.add_argument("--horizon", type=int, default=60, help="steps")
    parser.add_argument("--rows", type=Path, help="rows.csv of ours, to pair with")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    logging.disable(logging.CRITICAL)
    rows = {row["scenario"]: row for row in map(json.loads, asked.out.read_text().splitlines())} if asked.out.exists() else {}
    for path in asked.scenarios:
        if path.stem in rows:
            continue
        try:
            row = drive(path, asked.horizon)
        except Exception as error:  # the package raises what it likes; that is how the drive ends
            row = {"scenario": path.stem, "ends": "raises", "lost": "", "why": f"{type(error).__name__}: {str(error)[:200]}"}
        rows[path.stem] = row
        with asked.out.open("a") as file:
            file.write(json.dumps(row) + "\n")
        print(row, flush=True)
    print(Counter((row["ends"], row["lost"]) for row in rows.values()))
    if asked.rows is not None:
        with asked.rows.open() as file:
            ours = {row["scenario"]: row for row in csv.DictReader(file)}
        both = [(ours[name], row) for name, row in rows.items() if name in ours]
        theirs = [row["ends"] in ("goal", "time") and not row["lost"] for _, row in both]
        safe = [mine["end"] == "safe" for mine, _ in both]
        only = Counter(zip(safe, theirs, strict=True))
        print(f"{len(both)} pairs: safe ours {sum(safe)}, theirs {sum(theirs)}; only ours {only[True, False]}, theirs {only[False, True]}")
        goals = [(mine["goal"] == "reached", row["ends"] == "goal" and not row["lost"]) for mine, row in both]
        print(f"goal reached ours {sum(a for a, _ in goals)}, theirs {sum(b for _, b in goals)}")


if __name__ == "__main__":
    main()
