"""A car whose rear tyres slide follows no plan: none of its plans says `planned`."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.domain.vocabulary import Alert, Status
from mcdas_opt.dynamics.single_track import SLIPS_ABOVE_MPS, fiala
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.controller import Controller
from mcdas_opt.simulation.judging import verify
from mcdas_opt.simulation.loop import simulate
from tests.planning.situations import random_sandwich
from tests.simulation.scene_maker import make_scene

BMW = load_vehicle("bmw_320i")
SURELY = 1.1  # times the sideslip at which the tyres slide: the observer needs a moment


@pytest.mark.parametrize("friction", [0.25, 0.9])
def test_tyres_that_slide_give_no_more(friction: float) -> None:
    c = Chassis.of(BMW)
    limit = friction * c.mass_kg * 9.80665 * c.cog_to_front_axle_m / c.wheelbase_m
    slides = c.sliding_sideslip_rad(friction)
    assert fiala(slides, c.cornering_stiffness_rear_nprad, limit) == pytest.approx(limit)
    assert fiala(0.9 * slides, c.cornering_stiffness_rear_nprad, limit) < limit


@pytest.mark.parametrize("seed", range(6))
def test_the_plan_is_the_one_of_a_car_that_grips_and_says_that_this_one_does_not(seed: int) -> None:
    asked = random_sandwich(seed)
    limit = Chassis.of(Vehicle()).sliding_sideslip_rad(asked.road.friction)
    grips, slides = (replace(asked, host=replace(asked.host, sideslip_rad=share * limit)) for share in (0.99, 1.01))
    usual, same, plan = (Planner().plan(situation) for situation in (asked, grips, slides))
    assert (same.status, same.reason, same.verdict) == (usual.status, usual.reason, usual.verdict)
    assert plan.trajectory.table.tobytes() == usual.trajectory.table.tobytes()
    assert (plan.status, plan.alert, plan.warning, plan.safe_end) == (Status.UNAVOIDABLE, Alert.ACT, True, None)
    assert plan.verdict.violations[0].kind is ViolationKind.SIDESLIP
    assert plan.reason.startswith("the rear tyres slide (sideslip 0.")
    assert verify(plan.trajectory, slides).violations[0] == plan.verdict.violations[0]
    assert verify(plan.trajectory, grips).passed is usual.verdict.passed
    assert Situation.from_json(slides.to_json()) == slides


def test_a_state_that_slips_says_by_how_much_and_one_that_stands_does_not_slide() -> None:
    state = SlidingState(speed_mps=20.0, lateral_speed_mps=-3.0, lateral_speed_sd_mps=0.5, yaw_rate_radps=0.2)
    assert state.sideslip_rad == state.without_slip(2.7, 1.0).sideslip_rad == pytest.approx(math.atan(3.5 / 20.0))
    assert (
        Planner().plan(Situation(host=HostState(speed_mps=0.8, sideslip_rad=1.0), road=Road(), coverage=Coverage())).status
        is Status.PLANNED
    )


@dataclass(frozen=True)
class Swings(Controller):
    """Turns the wheels to and fro, whatever the plan says."""

    rate_radps: float
    period_s: float

    def command(self, trajectory: Trajectory, since_s: float, state: HostState) -> tuple[float, float]:
        place_s = state.s_m / max(state.speed_mps, 1.0)
        return 0.0, self.rate_radps if (place_s + 0.25 * self.period_s) % self.period_s < 0.5 * self.period_s else -self.rate_radps


@settings(max_examples=5)
@given(
    speed=st.floats(10.0, 35.0),
    rate=st.floats(-0.4, 0.4),
    period=st.floats(0.6, 2.0),
    friction=st.sampled_from([0.25, 0.5, 0.9]),
)
@example(speed=30.0, rate=0.4, period=1.5, friction=0.9)
@example(speed=25.0, rate=0.0, period=1.0, friction=0.5)
def test_no_cycle_of_a_drive_that_slides_is_called_planned(speed: float, rate: float, period: float, friction: float) -> None:
    road = {"friction": friction, "lanes_left": 3, "lanes_right": 3, "shoulder_left_m": 30.0, "shoulder_right_m": 30.0}
    scene = make_scene(speed_mps=speed, road=road, host={"vehicle": "bmw_320i"}, duration_s=2.5)
    drive = simulate(scene, plant="dynamic", controller=Swings(rate, period))
    limit, history = Chassis.of(BMW).sliding_sideslip_rad(friction), drive.history
    places = [int(np.searchsorted(history.t_s, cycle.time_s - 1e-9)) for cycle in drive.cycles]
    slides = [abs(history.sideslip_rad[k]) > SURELY * limit and history.states[k, 3] > SLIPS_ABOVE_MPS for k in places]
    called = [(cycle.plan.status, cycle.plan.alert) for cycle in drive.cycles]
    assert {said for said, is_sliding in zip(called, slides, strict=True) if is_sliding} <= {(Status.UNAVOIDABLE, Alert.ACT)}
    if rate == 0.0:
        assert {status for status, _ in called} == {Status.PLANNED}
    elif rate == 0.4:
        assert sum(slides) > 5
