"""What is planned asks no more of the engine than the axle that it turns can hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, DrivenAxle, Vehicle
from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.dynamics.axle_limits import available_mps2, driving_mps2
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.dynamic_plant import DynamicPlant
from mcdas_opt.verification.judge import judge
from mcdas_opt.verification.limits import LEAVING_S
from tests.planning.situations import car, random_sandwich

ICE = Road(friction=0.25, lanes_left=1, lanes_right=1)
ONE = [DrivenAxle.FRONT, DrivenAxle.REAR]


@given(st.floats(0.1, 1.2))
def test_a_car_that_drives_all_wheels_has_what_the_road_gives(friction: float) -> None:
    both, grip = Vehicle(), friction * GRAVITY_MPS2
    assert driving_mps2(both, friction) == both.acceleration_max_mps2
    assert available_mps2(both, friction) == (min(8.0, grip), min(3.0, grip))


@pytest.mark.parametrize(("driven", "least"), [(DrivenAxle.FRONT, 0.97), (DrivenAxle.REAR, 0.85)])
@pytest.mark.parametrize("friction", [0.15, 0.25])
def test_the_dynamic_vehicle_has_as_much_and_hardly_more(driven: DrivenAxle, least: float, friction: float) -> None:
    """A little more where the rear axle drives: what driving presses on it is not counted on."""
    vehicle = Vehicle(driven_axle=driven)
    plant = DynamicPlant(vehicle, Road(friction=friction), HostState(speed_mps=15.0, acceleration_mps2=3.0))
    for _ in range(100):
        plant.step(20.0, 0.0)
    assert least <= driving_mps2(vehicle, friction) / (plant.state.speed_mps - 15.0) <= 1.05


def test_the_rear_driven_bmw_on_ice() -> None:
    bmw = load_vehicle("bmw_320i")
    assert driving_mps2(bmw, 0.25) == pytest.approx(1.1, abs=0.01)
    assert driving_mps2(bmw, 0.5) == bmw.acceleration_max_mps2


def accelerating(start_mps2: float, then_mps2: float) -> Trajectory:
    """Straight on at 10 m/s, from one acceleration to another at 10 m/s^3."""
    t = np.round(0.02 * np.arange(151), 9)
    a = np.maximum(start_mps2 - 10.0 * t, then_mps2)
    jerk = np.append(np.diff(a) / 0.02, 0.0)
    v = 10.0 + np.append(0.0, np.cumsum(0.5 * (a[1:] + a[:-1]) * 0.02))
    s = np.append(0.0, np.cumsum(v[:-1] * 0.02 + a[:-1] * 0.0002 + jerk[:-1] * 0.02**3 / 6.0))
    zero = np.zeros_like(t)
    return Trajectory.from_states(t, np.column_stack([s, zero, zero, v, a, zero]), np.column_stack([jerk[:-1], zero[:-1]]))


@pytest.mark.parametrize("driven", ONE)
def test_the_judge_convicts_who_asks_for_more_but_lets_a_start_come_back(driven: DrivenAxle) -> None:
    one = Vehicle(driven_axle=driven)
    most, nobody = driving_mps2(one, 0.25), Prediction(name="none", bodies=())
    for start, then, vehicle, found in (
        (most, most, one, set()),
        (most + 0.05, most + 0.05, one, {ViolationKind.ACCELERATION}),
        (most + 5.0 * LEAVING_S, most, one, set()),
        (most + 0.05, most + 0.05, Vehicle(), set()),
    ):
        verdict = judge(accelerating(start, then), None, vehicle, ICE, nobody)
        assert {violation.kind for violation in verdict.violations} == found
        assert all(violation.limit == pytest.approx(most) for violation in verdict.violations)


@pytest.mark.parametrize("driven", ONE)
@pytest.mark.parametrize("seed", range(5))
def test_no_plan_asks_for_more(driven: DrivenAxle, seed: int) -> None:
    """Pressed from behind on ice: neither the optimiser's nor the fallback's."""
    asked = random_sandwich(seed)
    asked, one = replace(asked, road=replace(asked.road, friction=0.25)), Vehicle(driven_axle=driven)
    most = driving_mps2(one, 0.25)
    plan = Planner(one).plan(asked)
    late = plan.trajectory.t_s >= LEAVING_S
    assert float(plan.trajectory.acceleration_mps2[late].max()) <= 1.01 * most
    assert plan.status is Status.UNAVOIDABLE or plan.verdict.passed
    tried = [candidate.name.split(" ")[1] for candidate in plan.candidates if candidate.name.startswith("accelerate ")]
    assert all(float(mps2) <= most + 0.05 for mps2 in tried)


def test_driving_away_closes_sooner_where_one_axle_drives() -> None:
    asked = Situation(
        host=HostState(speed_mps=10.0),
        tracks=(car("rear", -60.0, 0.0, 16.0),),
        road=replace(ICE, lanes_left=0, lanes_right=0),
        coverage=Coverage(),
    )
    both, rear = (Planner(Vehicle(driven_axle=driven)).plan(asked).escapes for driven in (DrivenAxle.BOTH, DrivenAxle.REAR))
    assert both is not None
    assert rear is not None
    moments = [found.accelerate.last_moment_s or 0.0 for found in (both, rear)]
    assert moments[1] < moments[0]
