"""Following: who closes in on a front car and needs little braking for it brakes as is ordinary, not as hard as a step in speed asks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.planning.planner import Planner

_INTERVENTION_MPS2 = 3.5


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner()


def following(speed_mps: float, closing_mps: float, seconds: float) -> Situation:
    front = Track(id="front", s_m=4.5 + closing_mps * seconds, d_m=0.0, speed_s_mps=speed_mps - closing_mps)
    return Situation(host=HostState(d_m=0.0, speed_mps=speed_mps), tracks=(front,), road=Road(friction=0.9), desired_speed_mps=speed_mps)


def planned(planner: Planner, situation: Situation) -> Plan:
    planner.reset()
    return planner.plan(situation)


@pytest.mark.parametrize("speed_mps", [18.0, 24.0, 30.0])
@pytest.mark.parametrize("closing_mps", [4.0, 5.0, 6.0, 7.0, 8.0])
def test_a_front_car_that_is_closed_in_on_is_braked_for_as_is_ordinary(planner: Planner, speed_mps: float, closing_mps: float) -> None:
    plan = planned(planner, following(speed_mps, closing_mps, 4.9))
    first = plan.trajectory.acceleration_mps2[plan.trajectory.t_s <= 4.0]
    assert plan.verdict.passed
    assert plan.safe_end is not None
    assert plan.safe_end.safe
    assert plan.mode is Mode.BRAKE
    assert first.min() > -_INTERVENTION_MPS2 + 1.0
    assert plan.trajectory.speed_mps[40] < speed_mps - 0.5 * closing_mps  # it does brake


@pytest.mark.parametrize("closing_mps", [5.0, 7.0])
def test_a_front_car_that_brakes_hard_itself_is_braked_for_as_hard_as_may_be(planner: Planner, closing_mps: float) -> None:
    situation = following(24.0, closing_mps, 4.9)
    braking = replace(situation, tracks=tuple(replace(track, acceleration_s_mps2=-2.5) for track in situation.tracks))
    gentle, hard = (planned(planner, one).trajectory.acceleration_mps2[:20].min() for one in (situation, braking))
    assert hard < gentle - 1.0


def test_who_is_near_brakes_harder(planner: Planner) -> None:
    far, near = (planned(planner, following(24.0, 6.0, seconds)).trajectory.acceleration_mps2[:20] for seconds in (4.9, 2.2))
    assert np.min(near) < np.min(far) - 1.0
