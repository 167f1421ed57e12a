"""What drives cost: the compiled form is that of the array operations to the bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side, Status
from mcdas_opt.errors import PlannerFaultWarning
from mcdas_opt.native.form import SWITCH
from mcdas_opt.planning.candidates.cost import _rate, driving_costs
from mcdas_opt.planning.candidates.nearness import nearness_of
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.planner import Planner
from tests.planning.situations import sandwich


@given(seed=st.integers(0, 2**32 - 1), others=st.integers(0, 4), drives=st.integers(1, 3), bend=st.sampled_from([0.0, 0.01]))
def test_both_forms_cost_the_same_to_the_bit(seed: int, others: int, drives: int, bend: float) -> None:
    rng = np.random.default_rng(seed)
    places, speeds = np.cumsum(rng.uniform(8.0, 60.0, others)), rng.uniform(0.0, 30.0, others)
    tracks = tuple(Track(id=str(k), s_m=s - 40.0, d_m=0.0, speed_s_mps=v) for k, (s, v) in enumerate(zip(places, speeds, strict=True)))
    situation = Situation(
        host=HostState(speed_mps=float(rng.uniform(0.0, 30.0))), tracks=tracks, coverage=Coverage(), road=Road(curvature=((0.0, bend),))
    )
    cycle = Cycle.of(situation, Vehicle())
    times = cycle.settings.grid.times_s
    tables = rng.normal(0.0, 1.0, (drives, 9, times.size))
    tables[:, 0], tables[:, 1] = times, np.cumsum(0.1 * rng.uniform(0.0, 30.0, (drives, times.size)), axis=1)
    tables[:, 3], tables[:, 6] = 0.02 * tables[:, 3], 0.1 * tables[:, 6]

    def costs() -> list[float]:
        return driving_costs(nearness_of(tables, times, cycle), cycle, CostWeights())

    compiled = costs()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        assert costs() == compiled


def rate_of(drives: Array, *others: Any) -> Array:
    """What is driven to the left has a cost that is not finite."""
    return np.where(drives[:, 2, -1:] > 1.0, np.nan, _rate(drives, *others))


def test_a_candidate_without_a_finite_cost_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    planner = Planner()
    assert planner.plan(sandwich()).side is Side.LEFT
    planner.reset()
    monkeypatch.setattr("mcdas_opt.planning.candidates.cost._rate", rate_of)
    plan = planner.plan(sandwich())
    assert (plan.status, plan.side, plan.verdict.passed) == (Status.PLANNED, Side.RIGHT, True)
    (left,) = (one for one in plan.candidates if one.name == "left")
    assert (left.passed, left.cost, left.refusal) == (False, None, "its cost is not finite")
    assert all(one.cost is None or np.isfinite(one.cost) for one in plan.candidates)


def test_where_no_cost_is_finite_the_ladder_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    planner = Planner()
    monkeypatch.setattr("mcdas_opt.planning.candidates.cost._rate", lambda *a: np.nan * _rate(*a))
    plan = planner.plan(sandwich())
    assert (plan.status, plan.verdict.passed) == (Status.FALLBACK, True)
    assert "left: its cost is not finite" in plan.reason


def test_where_a_cost_raises_the_ladder_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    planner = Planner()
    monkeypatch.setattr("mcdas_opt.planning.candidates.cost._rate", lambda *a: 1 / 0)
    with pytest.warns(PlannerFaultWarning, match="failed: ZeroDivisionError") as told:
        plan = planner.plan(sandwich())
    assert (plan.status, plan.verdict.passed) == (Status.FALLBACK, True)
    assert "mpc failed: ZeroDivisionError" in plan.reason
    assert any("the cost of left failed" in str(one.message) for one in told)
