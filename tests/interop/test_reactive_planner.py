"""CommonRoad's reactive planner behind the method's protocol."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Request, Side
from mcdas_opt.errors import MissingExtraError
from mcdas_opt.planning.method import build_method, known_methods
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge

CAR = Vehicle()
HERE = importlib.util.find_spec("commonroad_rp") is not None
FRONT = Track(id="front", s_m=40.0, d_m=0.0, speed_s_mps=8.0)
SITUATION = Situation(host=HostState(speed_mps=18.0), tracks=(FRONT,), road=Road(lanes_left=1), coverage=Coverage())


def test_it_is_known_and_without_its_package_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "commonroad-reactive" in known_methods()
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "commonroad_rp.reactive_planner", None)
        with pytest.raises(MissingExtraError, match=r"mcdas-opt\[commonroad-planner\]', then pip install --no-deps commonroad-"):
            build_method("commonroad-reactive", CAR, Settings())


@pytest.mark.skipif(not HERE, reason="needs the extra commonroad-planner")
@pytest.mark.filterwarnings("ignore")
class TestWithThePackage:
    def planned(self, situation: Situation, previous: Plan | None = None) -> Plan:
        plan = build_method("commonroad-reactive", CAR, Settings()).plan(situation, previous)
        assert isinstance(plan, Plan)
        return plan

    def test_it_begins_at_the_host_and_is_judged_as_it_is(self) -> None:
        for d, road in ((0.0, Road(lanes_left=1)), (0.6, Road(lanes_left=1, curvature=((0.0, 0.004),)))):
            at = replace(SITUATION, road=road, host=HostState(s_m=55.0, d_m=d, speed_mps=18.0), tracks=(replace(FRONT, s_m=95.0),))
            plan = self.planned(at)
            start = plan.trajectory.states[0]
            assert np.allclose(start[:4], at.host.to_vector()[:4], atol=0.02)
            assert plan.verdict == judge(plan.trajectory, at.host, CAR, at.road, predict_for(at))

    def test_it_leaves_a_slow_car_aside_and_mirrors(self) -> None:
        left = self.planned(SITUATION)
        right = self.planned(replace(SITUATION, road=Road(lanes_right=1)))
        assert left.trajectory.d_m[-1] > 0.9 or left.mode is Mode.BRAKE
        assert np.allclose(left.trajectory.d_m, -right.trajectory.d_m, atol=1e-6)

    def test_it_drives_three_steps_of_a_plan_before_the_next(self) -> None:
        method = build_method("commonroad-reactive", CAR, Settings())
        first = method.plan(SITUATION, None)
        assert isinstance(first, Plan)
        host = HostState.from_vector(first.trajectory.states[1])
        second = method.plan(replace(SITUATION, time_s=0.1, host=host), first)
        assert isinstance(second, Plan)
        assert np.allclose(second.trajectory.states, first.trajectory.states[1:])
        third = method.plan(replace(SITUATION, time_s=0.3, host=HostState.from_vector(first.trajectory.states[3])), second)
        assert isinstance(third, Plan)
        assert len(third.trajectory) > len(second.trajectory)

    def test_a_wall_without_a_way_out_is_braked_for(self) -> None:
        wall = replace(FRONT, s_m=12.0, speed_s_mps=0.0)
        plan = self.planned(replace(SITUATION, tracks=(wall,), road=Road()))
        assert (plan.mode, plan.side) == (Mode.BRAKE, Side.NONE)
        assert not plan.verdict.passed

    def test_braking_too_is_held_for_three_steps(self) -> None:
        wall = replace(SITUATION, tracks=(replace(FRONT, s_m=12.0, speed_s_mps=0.0),), road=Road())
        method = build_method("commonroad-reactive", CAR, Settings())
        first = method.plan(wall, None)
        assert isinstance(first, Plan)
        gone = replace(wall, time_s=0.1, tracks=())
        held = method.plan(gone, first)
        assert isinstance(held, Plan)
        assert held.memory is first.memory
        assert held.mode is Mode.BRAKE
        free = method.plan(replace(gone, time_s=0.3), held)
        assert isinstance(free, Plan)
        assert "samples" in free.reason

    def test_it_does_not_park(self) -> None:
        answer = build_method("commonroad-reactive", CAR, Settings()).plan(
            Situation(host=HostState(), request=Request.PARK, coverage=Coverage()), None
        )
        assert isinstance(answer, Refusal)
