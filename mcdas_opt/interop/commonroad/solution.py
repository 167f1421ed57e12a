"""A drive of ours as a CommonRoad solution: kinematic single-track states of the BMW 320i, one a time step."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.errors import ParameterError, writing
from mcdas_opt.interop.commonroad.library import require
from mcdas_opt.interop.commonroad.scenario import CommonRoadScene

_SOLVED_ON = datetime(2000, 1, 1)  # the format asks for a date; the same drive is the same file


def states(read: CommonRoadScene, driven: Trajectory) -> list[Any]:
    """The drive at the scenario's time steps, linear between its samples: `KSState`s in the scenario's plane."""
    require()
    from commonroad.scenario.state import KSState

    count = int(np.floor(float(driven.t_s[-1]) / read.step_s + 1e-9)) + 1
    t = read.step_s * np.arange(count)
    s, d, psi, v, delta = (
        np.interp(t, driven.t_s, column) for column in (driven.s_m, driven.d_m, driven.heading_rad, driven.speed_mps, driven.steering_rad)
    )
    x, y, yaw = read.placement.to_plane(*read.frame.to_plane(s, d, psi))
    return [
        KSState(
            time_step=read.first_step + k,
            position=np.array([x[k], y[k]]),
            velocity=float(v[k]),
            orientation=float(yaw[k]),
            steering_angle=float(delta[k]),
        )
        for k in range(count)
    ]


def goal_reached_s(read: CommonRoadScene, driven: Trajectory) -> float | None:
    """When the drive is first in the planning problem's goal, as CommonRoad itself judges it; None where it never is."""
    there = (state for state in states(read, driven) if read.problem.goal.is_reached(state))
    return next((round(read.step_s * (state.time_step - read.first_step), 9) for state in there), None)


def solution(read: CommonRoadScene, driven: Trajectory) -> Any:
    """A `commonroad.common.solution.Solution` of the planning problem that was read, by vehicle model KS, cost function SA1.

    Raises `ParameterError` for a drive that ends within the first time step.
    """
    require()
    if float(driven.t_s[-1]) < (1.0 - 1e-9) * read.step_s:
        raise ParameterError("trajectory", float(driven.t_s[-1]), f"must last a time step of {read.step_s:g} s at least", "s")
    from commonroad.common.solution import CostFunction, PlanningProblemSolution, Solution, VehicleModel, VehicleType
    from commonroad.scenario.trajectory import Trajectory as Driven

    answer = PlanningProblemSolution(
        planning_problem_id=read.problem_id,
        vehicle_model=VehicleModel.KS,
        vehicle_type=VehicleType.BMW_320i,
        cost_function=CostFunction.SA1,
        trajectory=Driven(initial_time_step=read.first_step, state_list=states(read, driven)),
    )
    return Solution(scenario_id=read.scenario_id, planning_problem_solutions=[answer], date=_SOLVED_ON)


def write_solution(read: CommonRoadScene, driven: Trajectory, path: str | Path) -> Path:
    """The solution's XML at `path`. Raises `InputError` where it cannot be written."""
    from commonroad.common.solution import CommonRoadSolutionWriter

    path = Path(path)
    text = CommonRoadSolutionWriter(solution(read, driven)).dump()
    with writing(path):
        path.write_text(text if isinstance(text, str) else text.decode(), "utf-8")
    return path
