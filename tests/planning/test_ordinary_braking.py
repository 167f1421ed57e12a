"""Following: who closes in on a front car and needs little braking for it brakes as is ordinary, not as hard as a step in speed asks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.proposals.comfortable_speed import comfortable_speed

_INTERVENTION_MPS2 = 3.5


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner()


def following(speed_mps: float, closing_mps: float, seconds: float) -> Situation:
    front = Track(id="front", s_m=4.5 + closing_mps * seconds, d_m=0.0, speed_s_mps=speed_mps - closing_mps)
    return Situation(
        host=HostState(d_m=0.0, speed_mps=speed_mps),
        tracks=(front,),
        road=Road(friction=0.9),
        desired_speed_mps=speed_mps,
        coverage=Coverage(),
    )


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


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("speed_mps", [18.0, 21.0, 24.0])
def test_who_brakes_hard_on_its_way_out_of_the_lane_is_not_followed_to_a_stop(speed_mps: float, side: float) -> None:
    front = Track(
        id="front",
        s_m=2.1 * speed_mps,
        d_m=1.9 * side,
        speed_s_mps=speed_mps - 8.0,
        speed_d_mps=1.0 * side,
        acceleration_s_mps2=-7.5,
        acceleration_s_sd_mps2=0.5,
    )
    road, host = Road(lanes_left=1, lanes_right=1, lane_width_m=3.2), HostState(speed_mps=speed_mps)
    slowest = []
    for sideways_mps in (1.0, 0.3, -1.0):
        tracks = (replace(front, speed_d_mps=sideways_mps * side),)
        cycle = Cycle.of(Situation(host=host, tracks=tracks, road=road, desired_speed_mps=speed_mps, coverage=Coverage()), Vehicle())
        slowest.append(float(comfortable_speed(cycle, speed_mps, 0.0).speeds_mps.min()))
    assert slowest[0] == speed_mps
    assert slowest[1] == slowest[2] < speed_mps - 5.0
