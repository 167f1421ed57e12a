"""A car that moves along its axis elsewhere than at its rear axle: planned for as any other, by everybody who plans."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.baselines.corrected import CorrectedMethod
from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.errors import ParameterError
from mcdas_opt.native.form import SWITCH
from mcdas_opt.planning.planner import Planner
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge
from tests.planning.situations import random_sandwich


@pytest.mark.parametrize("seed", range(8))
def test_what_is_planned_is_sound_for_that_car(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    situation = random_sandwich(seed)
    planner = Planner()
    planner.set_zero_sideslip_point(0.00476 * situation.host.speed_mps**2)
    plan = planner.plan(situation)
    prediction = predict_for(situation, planner.settings.prediction)
    told = judge(plan.trajectory, situation.host, planner.vehicle, situation.road, prediction)
    if plan.status is not Status.UNAVOIDABLE:
        assert told.passed
        monkeypatch.setenv(SWITCH, "0")
        assert judge(plan.trajectory, situation.host, planner.vehicle, situation.road, prediction).passed
    if np.ptp(plan.trajectory.heading_rad) > 0.05 and planner.vehicle.zero_sideslip_point_m > 1.0:
        rear_axle = judge(plan.trajectory, situation.host, Vehicle(), situation.road, prediction)
        assert not rear_axle.passed  # it is another car's drive


@pytest.mark.parametrize("method", ["mpc", "closed-form-corrected", "idm-mobil"])
def test_everybody_who_plans_is_told_and_can_be_told_back(method: str) -> None:
    situation = random_sandwich(5)
    first, second = Planner(method=method), Planner(method=method)
    second.set_zero_sideslip_point(2.0)
    for part in (second.method, second.tracker):
        assert part.vehicle == second.vehicle == replace(Vehicle(), zero_sideslip_point_m=2.0)
    second.set_zero_sideslip_point(0.0)
    assert second.vehicle == first.vehicle
    assert np.array_equal(first.plan(situation).trajectory.states, second.plan(situation).trajectory.states)


def test_a_method_of_ones_own_is_told_at_once_and_one_that_keeps_no_vehicle_is_left_alone() -> None:
    """Whatever its planner was built with; and it keeps its own car otherwise."""
    own = CorrectedMethod(replace(Vehicle(), width_m=2.0))
    planner = Planner(vehicle=replace(Vehicle(), zero_sideslip_point_m=2.0), method=own)
    planner.set_zero_sideslip_point(2.0)
    assert own.vehicle == replace(Vehicle(), width_m=2.0, zero_sideslip_point_m=2.0)

    class Bare:
        __slots__ = ()
        has_ladder = True

        def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
            return Refusal(reason="no idea")

    Planner(method=Bare()).set_zero_sideslip_point(2.0)


def test_it_lies_ahead_of_the_rear_axle() -> None:
    assert replace(Vehicle(), zero_sideslip_point_m=2.0).centre_m == pytest.approx(Vehicle().centre_m - 2.0)
    with pytest.raises(ParameterError, match="zero_sideslip_point_m"):
        Planner().set_zero_sideslip_point(-0.1)
