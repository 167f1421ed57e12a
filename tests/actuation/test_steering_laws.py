"""Stanley's law, the regulator of the single track's errors and the predictive one: stable, on the plan, no further than tyres can use."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from mcdas_opt.actuation.error_lqr import error_model
from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.simulation.controller import CONTROLLERS, make_controller
from mcdas_opt.simulation.dynamic_plant import DynamicPlant
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome
from tests.actuation.test_lateral_lqr import driven, follow, modes
from tests.simulation.fake_driver import FakeDriver
from tests.simulation.scene_maker import make_scene

CARS = [load_vehicle(name) for name in ("sedan", "bmw_320i", "lincoln_mkz")]
LAWS = pytest.mark.parametrize("law", ["stanley", "lqr-errors", "mpc-single-track"])
ROAD = Road(lanes_left=3, lanes_right=3)


@pytest.mark.parametrize("law", ["stanley", "lqr-errors"])  # the third is no function that could be differentiated: see below
@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
def test_the_loop_is_stable_from_walking_pace_to_top_speed(law: str, car: Vehicle) -> None:
    for speed in np.geomspace(1.5, 45.0, 8):
        assert modes(make_controller(law, car), car, float(speed)).max() < 0.985  # type: ignore[arg-type]


@LAWS
@pytest.mark.parametrize("speed", [6.0, 20.0, 33.0])
def test_it_comes_back_from_beside_the_plan(law: str, speed: float) -> None:
    car = CARS[0]
    plan = driven(car, HostState(speed_mps=speed), [(0.0, 0.0)] * 50)
    plant = DynamicPlant(car, ROAD, HostState(speed_mps=speed, d_m=0.5))
    states, inputs = follow(plant, make_controller(law, car, grip=GripMonitor(vehicle=car, believed=0.9)), plan)
    assert abs(states[-1, 1]) < 0.03
    assert states[:, 1].min() > -0.15
    assert np.abs(inputs[:, 1]).max() <= car.steering_rate_max_radps


@LAWS
@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
def test_a_steady_turn_is_driven_without_error(law: str, car: Vehicle) -> None:
    """Slip and understeer are in the feed-forward: nothing is left for feedback."""
    speed, bend = 20.0, 0.006
    road = Road(curvature=((0.0, bend),), lanes_left=3, lanes_right=3)
    start = HostState(speed_mps=speed, steering_rad=math.atan(car.wheelbase_m * bend), heading_rad=-math.asin(car.centre_m * bend))
    plan = driven(car, start, [(0.0, 0.0)] * 40, road)
    states, _ = follow(DynamicPlant(car, road, start), make_controller(law, car), plan)
    assert abs(states[-1, 1] - np.interp(4.0, plan.t_s, plan.d_m)) < 0.1


def test_the_errors_move_as_the_plants() -> None:
    """The regulator's model against the plant, by differences around driving straight ahead."""
    car, speed = CARS[0], 20.0
    a, b = error_model(Chassis.of(car), speed)
    behind = Chassis.of(car).cog_to_rear_axle_m
    speeds = np.zeros((3, 3))  # of (lateral speed, yaw rate, wheels), where the errors' rates are e1' = lateral speed + v e2
    speeds[:2, :2] = a[1::2, 1::2] - [[0.0, speed], [0.0, 0.0]]
    speeds[:2, 2] = b[1::2, 0]
    step = expm(0.01 * speeds)
    for k, small in enumerate(1e-4 * np.eye(3)):
        lateral, yaw_rate, wheels = (float(q) for q in small)
        start = SlidingState(speed_mps=speed, steering_rad=wheels, lateral_speed_mps=lateral - behind * yaw_rate, yaw_rate_radps=yaw_rate)
        plant = DynamicPlant(car, Road(friction=5.0), start)
        plant.step(0.0, 0.0)
        after = (plant.state.lateral_speed_mps + behind * plant.state.yaw_rate_radps, plant.state.yaw_rate_radps)
        assert np.array(after) / 1e-4 == pytest.approx(step[:2, k], rel=1e-3, abs=1e-4)


@LAWS
def test_wheels_are_turned_no_further_than_the_front_tyres_can_use(law: str) -> None:
    """On ice, far beside the plan."""
    car = CARS[0]
    plan = driven(car, HostState(speed_mps=20.0), [(0.0, 0.0)] * 30)
    plant = DynamicPlant(car, Road(friction=0.2, lanes_left=3), HostState(speed_mps=20.0, d_m=3.0))
    states, _ = follow(plant, make_controller(law, car, grip=GripMonitor(vehicle=car, believed=0.2)), plan)
    assert np.abs(states[:, 5]).max() < 0.08
    assert abs(plant.state.lateral_speed_mps / plant.state.speed_mps) < 0.15


@pytest.mark.parametrize("law", ["stanley", "lqr-errors"])
@given(
    speed=st.floats(10.0, 40.0), friction=st.sampled_from([0.25, 0.5, 0.9]), faster=st.floats(1.6, 4.0),
    side=st.sampled_from([-1.0, 1.0]), beside=st.floats(-2.0, 2.0),
)  # fmt: skip
def test_who_yaws_faster_than_any_road_can_keep_is_steered_against(
    law: str, speed: float, friction: float, faster: float, side: float, beside: float
) -> None:
    """Wherever the plan is: from wheels along the course of their axle, against the yawing. At what the road keeps, the plan decides."""
    car = CARS[1]
    plan = driven(car, HostState(speed_mps=speed), [(0.0, 0.0)] * 5)
    controller = make_controller(law, car, grip=GripMonitor(vehicle=car, believed=friction))
    yaw_rate = side * faster * friction * GRAVITY_MPS2 / speed
    spins = SlidingState(speed_mps=speed, d_m=beside, yaw_rate_radps=yaw_rate, steering_rad=math.atan2(car.wheelbase_m * yaw_rate, speed))
    assert side * controller.command(plan, 0.0, spins)[1] < 0.0
    turns = SlidingState(speed_mps=speed, d_m=-3.0 * side, yaw_rate_radps=0.2 * side * friction * GRAVITY_MPS2 / speed)
    assert side * controller.command(plan, 0.0, turns)[1] > 0.0


def test_a_reversal_at_speed_ends_in_no_spin() -> None:
    """From 8.5 m/s^2 to the right to as much to the left, at 32 m/s in a bend: it span, and was hit."""
    document = expand("curved", 12, 620481).cases[0].scene.model_dump(exclude_unset=True)
    document["host"]["vehicle"] = "bmw_320i"
    drive = simulate(Scene.model_validate(document | {"duration_s": 3.0}), plant="dynamic")
    assert drive.outcome is Outcome.SAFE
    assert np.abs(drive.history.sideslip_rad).max() < 0.12


@pytest.mark.parametrize("speed", [3.5, 8.0, 20.0, 45.0])
def test_the_predictive_law_settles_at_every_speed(speed: float) -> None:
    car = CARS[1]
    plan = driven(car, HostState(speed_mps=speed), [(0.0, 0.0)] * 60)
    plant = DynamicPlant(car, ROAD, HostState(speed_mps=speed, d_m=0.3))
    states, inputs = follow(plant, make_controller("mpc-single-track", car, grip=GripMonitor(vehicle=car, believed=0.9)), plan)
    assert abs(states[-1, 1]) < 0.02
    assert abs(states[-1, 2]) < 0.005
    assert np.abs(inputs[-100:, 1]).max() < 0.02  # and is at rest there


def test_the_predictive_law_is_the_same_in_the_mirror() -> None:
    car = CARS[1]
    ends = []
    for side in (1.0, -1.0):
        plan = driven(car, HostState(speed_mps=20.0), [(0.0, 0.1 * side)] * 5 + [(0.0, -0.1 * side)] * 10 + [(0.0, 0.0)] * 10)
        plant = DynamicPlant(car, ROAD, HostState(speed_mps=20.0))
        ends.append(follow(plant, make_controller("mpc-single-track", car, grip=GripMonitor(vehicle=car, believed=0.9)), plan)[0][-1])
    np.testing.assert_allclose(ends[0] * [1, -1, -1, 1, 1, -1], ends[1], atol=1e-3)  # OSQP's tolerance


def test_controllers_are_found_by_name() -> None:
    scene = make_scene(speed_mps=20.0, duration_s=0.3)
    for name in CONTROLLERS:
        assert simulate(scene, FakeDriver(lambda host, now: (0.0, 0.1)), plant="dynamic", controller=name).duration_s == 0.3
    with pytest.raises(ParameterError, match="did you mean 'stanley'"):
        simulate(scene, FakeDriver(), controller="stanly")
