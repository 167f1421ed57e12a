"""What is built once serves many planners, and none of them notices the others."""

from __future__ import annotations

import contextlib
import signal

import numpy as np
import pytest

from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.lane_problem import transcribed_problem
from mcdas_opt.planning.lane_problem.lane_mpc_solver import LaneMpcSolver
from mcdas_opt.planning.planner import Planner
from tests.planning.situations import random_sandwich


def test_planners_that_share_a_build_plan_as_if_alone() -> None:
    situations = [random_sandwich(seed) for seed in (3, 4)]
    alone = []
    for situation in situations:
        planner = Planner()
        alone.append([planner.plan(situation), planner.plan(situation)])  # the second begins from the first one's warm starts
    planners = [Planner(), Planner()]
    for turn in range(2):
        for i, planner in enumerate(planners):
            plan, expected = planner.plan(situations[i]), alone[i][turn]
            assert np.array_equal(plan.trajectory.states, expected.trajectory.states)
            assert (plan.chosen, plan.iterations) == (expected.chosen, expected.iterations)


def test_a_twin_has_memory_of_its_own() -> None:
    posed = LaneMpcSolver(Vehicle(), Settings()).problems.holding(2, Vehicle())
    twin = posed.twin()
    assert twin.problem is posed.problem
    assert twin.interior_point is not posed.interior_point
    assert twin.interior_point.kind == posed.interior_point.kind
    assert twin.osqp is not posed.osqp


def test_an_interrupt_while_an_engine_is_built_comes_when_it_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    built: list[object] = []

    def pressed(*arguments: object) -> None:
        with contextlib.suppress(KeyboardInterrupt):  # as CasADi's conversions do
            signal.raise_signal(signal.SIGINT)
        built.append(arguments)

    posed = object.__new__(transcribed_problem.TranscribedProblem)
    posed.problem, posed.nodes, posed.osqp_settings = None, 1, None
    for name, engine in (("interior_point", "InteriorPointEngine"), ("osqp", "OsqpEngine"), ("ipopt", "IpoptEngine")):
        monkeypatch.setattr(transcribed_problem, engine, pressed)
        with pytest.raises(KeyboardInterrupt):
            getattr(posed, name)
    assert len(built) == 3
