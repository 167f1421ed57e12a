"""What is built once serves many planners, and none of them notices the others."""

from __future__ import annotations

import numpy as np

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
    posed = Planner().method.stage.posed(2)  # type: ignore[attr-defined]
    twin = posed.twin()
    assert twin.problem is posed.problem
    assert twin.interior_point is not posed.interior_point
    assert twin.interior_point.kind == posed.interior_point.kind
    assert twin.osqp is not posed.osqp
