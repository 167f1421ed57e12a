"""The tracking regulator: stable at every speed, back on the plan from beside it, and better than feed-forward alone."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.actuation.lateral_lqr import LqrTracking, TrackingWeights, error_model
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.simulation.controller import Controller, FeedForward, default_controller
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.plant import KinematicPlant, Plant, make_plant

CARS = [load_vehicle(name) for name in ("sedan", "bmw_320i", "lincoln_mkz")]
ROAD = Road(lanes_left=3, lanes_right=3)


def driven(car: Vehicle, start: HostState, inputs: list[tuple[float, float]], road: Road = ROAD) -> Trajectory:
    """A plan: the no-slip car through inputs held for 0.1 s each."""
    plant = KinematicPlant(car, road, start)
    states = [plant.state.to_vector()]
    for jerk, rate in inputs:
        for _ in range(10):
            plant.step(jerk, rate)
        states.append(plant.state.to_vector())
    return Trajectory.from_states(0.1 * np.arange(len(states)), np.array(states), np.array(inputs))


def follow(plant: Plant, controller: Controller, plan: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """(states, inputs commanded) every STEP_S to the plan's end."""
    states, inputs = [plant.state.to_vector()], []
    for k in range(round(float(plan.t_s[-1]) / STEP_S)):
        inputs.append(controller.command(plan, k * STEP_S, plant.state))
        plant.step(*inputs[-1])
        states.append(plant.state.to_vector())
    return np.array(states), np.array(inputs)


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
def test_the_loop_is_stable_from_walking_pace_to_top_speed(car: Vehicle) -> None:
    tracking = LqrTracking.design(car)
    for speed in np.geomspace(1.0, 50.0, 40):
        a, b = error_model(tracking.chassis, car.centre_m, float(speed), tracking.step_s)
        assert np.abs(np.linalg.eigvals(a - b @ tracking.gain(float(speed))[None, :])).max() < 0.998
    along = np.array([[1.0, 0.01], [0.0, 1.0]]) - np.array([[0.5e-4], [0.01]]) @ tracking.speed_gains[None, :]
    assert np.abs(np.linalg.eigvals(along)).max() < 0.99


@pytest.mark.parametrize("factor", [0.7, 1.4])
def test_it_stays_stable_with_other_tyres_and_another_load(factor: float) -> None:
    tracking = LqrTracking.design(CARS[0])
    c = tracking.chassis
    others = [
        replace(c, mass_kg=c.mass_kg * factor),
        replace(c, yaw_inertia_kgm2=c.yaw_inertia_kgm2 * factor),
        replace(
            c,
            cornering_stiffness_front_nprad=c.cornering_stiffness_front_nprad * factor,
            cornering_stiffness_rear_nprad=c.cornering_stiffness_rear_nprad * factor,
        ),
    ]
    for other in others:
        for speed in np.geomspace(1.0, 40.0, 15):
            a, b = error_model(other, CARS[0].centre_m, float(speed), tracking.step_s)
            assert np.abs(np.linalg.eigvals(a - b @ tracking.gain(float(speed))[None, :])).max() < 1.0


def test_the_error_model_is_the_textbooks() -> None:
    """Against a numerical derivative of the forces written out by hand."""
    car, speed, h = CARS[0], 17.0, 1e-5
    c = Chassis.of(car)
    a, b = c.cog_to_front_axle_m, c.cog_to_rear_axle_m
    sampled, through = error_model(c, car.centre_m, speed, h)
    x = np.array([0.3, -0.2, 0.02, 0.1, 0.01])
    vy = x[1] + b * x[3]
    front = c.cornering_stiffness_front_nprad * (x[4] - (vy + a * x[3]) / speed)
    rear = -c.cornering_stiffness_rear_nprad * (vy - b * x[3]) / speed
    turning = (a * front - b * rear) / c.yaw_inertia_kgm2
    aside = (front + rear) / c.mass_kg - speed * x[3]
    rates = [x[1] + car.centre_m * x[3] + speed * x[2], aside - b * turning, x[3], turning, 0.0]
    np.testing.assert_allclose((sampled @ x - x) / h, rates, rtol=2e-3, atol=1e-6)
    np.testing.assert_allclose(through[:, 0] / h, [0.0, 0.0, 0.0, 0.0, 1.0], atol=2e-3)


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
@pytest.mark.parametrize("speed", [2.0, 5.0, 11.0, 20.0, 33.0, 45.0])
@pytest.mark.parametrize("plant", ["dynamic", "kinematic"])
def test_half_a_metre_beside_the_plan_is_made_good(car: Vehicle, speed: float, plant: str) -> None:
    plan = driven(car, HostState(speed_mps=speed), [(0.0, 0.0)] * 60)
    car_beside = make_plant(plant, car, ROAD, HostState(speed_mps=speed, d_m=0.5))
    states, inputs = follow(car_beside, LqrTracking.design(car), plan)
    assert np.abs(states[400:, 1]).max() < 0.05
    assert states[:, 1].min() > -0.1
    assert np.abs(inputs[:, 1]).max() <= car.steering_rate_max_radps
    assert states[-1, 3] == pytest.approx(speed, abs=0.02)


def swerve(car: Vehicle, speed: float, lateral: float, jerk: float = 0.0) -> Trajectory:
    """Out and back: steering by sine, to a lateral acceleration of `lateral`."""
    reach = math.atan(car.wheelbase_m * lateral / speed**2)
    angle = reach * np.sin(2.0 * math.pi * np.arange(31) / 30.0)
    rates = [*(np.diff(angle) / 0.1), *[0.0] * 15]
    return driven(car, HostState(speed_mps=speed), [(jerk if k < 10 else 0.0, float(rate)) for k, rate in enumerate(rates)])


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
@pytest.mark.parametrize("speed", [10.0, 17.0, 28.0])
@pytest.mark.parametrize("lateral", [3.0, -5.0])
def test_a_swerve_is_followed_where_feed_forward_alone_drifts(car: Vehicle, speed: float, lateral: float) -> None:
    plan = swerve(car, speed, lateral)
    off = []
    for controller in (LqrTracking.design(car), FeedForward()):
        states, inputs = follow(make_plant("dynamic", car, ROAD, HostState(speed_mps=speed)), controller, plan)
        planned = np.interp(np.arange(len(states)) * STEP_S, plan.t_s, plan.d_m)
        off.append(np.abs(states[:, 1] - planned))
        assert np.abs(inputs[:, 1]).max() <= car.steering_rate_max_radps + 1e-9
    assert off[0].max() < 0.25
    assert off[0][-1] < 0.06
    assert off[0].max() < off[1].max()


def test_speed_and_steering_together() -> None:
    car = CARS[0]
    plan = swerve(car, 20.0, 3.0, jerk=-2.0)
    states, inputs = follow(make_plant("dynamic", car, ROAD, HostState(speed_mps=20.5)), LqrTracking.design(car), plan)
    assert states[-1, 3] == pytest.approx(float(plan.speed_mps[-1]), abs=0.1)
    assert abs(states[-1, 1] - plan.d_m[-1]) < 0.1
    assert inputs[:, 0].min() >= car.jerk_min_mps3
    assert inputs[:, 0].max() <= car.jerk_max_mps3


def test_on_a_curved_road_it_keeps_the_lane() -> None:
    car, road = CARS[0], Road(curvature=((0.0, 0.0), (40.0, 0.005)), lanes_left=1, lanes_right=1)
    plan = [HostState(speed_mps=22.0)]
    s, t = np.arange(0.0, 176.0, 2.2), 0.1 * np.arange(80)
    kappa = road.curvature_at(s)
    steering = np.arctan(car.wheelbase_m * kappa)
    lean = -np.arctan(car.centre_m * kappa)  # the centre's course is along the road
    x = np.column_stack([s, 0.0 * s, lean, 22.0 + 0.0 * s, 0.0 * s, steering])
    plan = Trajectory.from_states(t, x, np.column_stack([0.0 * t, np.gradient(steering, t)]))
    states, _ = follow(make_plant("dynamic", car, road, HostState(speed_mps=22.0)), LqrTracking.design(car), plan)
    assert np.abs(states[:, 1]).max() < 0.15
    assert abs(states[-1, 1]) < 0.03


def test_beyond_the_plans_end_nothing_is_asked() -> None:
    plan = driven(CARS[0], HostState(speed_mps=10.0), [(0.0, 0.1)] * 5)
    assert LqrTracking.design(CARS[0]).command(plan, 0.5, HostState(speed_mps=10.0, d_m=1.0)) == (0.0, 0.0)


def test_each_plant_has_its_controller() -> None:
    assert isinstance(default_controller("kinematic", CARS[0]), FeedForward)
    assert isinstance(default_controller("dynamic", CARS[0]), LqrTracking)


def test_a_weight_must_be_positive() -> None:
    with pytest.raises(ParameterError, match="heading_rad"):
        TrackingWeights(heading_rad=0.0)
