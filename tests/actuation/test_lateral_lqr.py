"""The tracking regulator: stable at every speed, back on the plan from beside it, and better than feed-forward alone."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.actuation.lateral_lqr import LqrTracking
from mcdas_opt.actuation.plan_tracking import PlanTracking
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.simulation.controller import STEERING_RATE_SHARE, Controller, FeedForward, default_controller
from mcdas_opt.simulation.dynamic_plant import DynamicPlant
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.kinematic_plant import KinematicPlant
from mcdas_opt.simulation.motion_sensors import MeasuredHost, MotionSensors
from mcdas_opt.simulation.plant import Plant, make_plant

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


def modes(tracking: LqrTracking, car: Vehicle, speed: float, road: Road = ROAD) -> np.ndarray:
    """Moduli of the eigenvalues of the loop, from 0.1 s to 0.1 s, around driving straight ahead: by differences through the plant."""
    plan = driven(car, HostState(speed_mps=speed), [(0.0, 0.0)] * 3)

    def after(x: np.ndarray) -> np.ndarray:
        d, psi, aside, yaw_rate, delta = (float(q) for q in x)
        start = SlidingState(d_m=d, heading_rad=psi, speed_mps=speed, steering_rad=delta, lateral_speed_mps=aside, yaw_rate_radps=yaw_rate)
        plant = DynamicPlant(car, road, start)
        for k in range(10):
            plant.step(*tracking.command(plan, k * STEP_S, plant.state))
        end = plant.state
        return np.array([end.d_m, end.heading_rad, end.lateral_speed_mps, end.yaw_rate_radps, end.steering_rad])

    small = 1e-5 * np.eye(5)
    through = np.array([(after(e) - after(-e)) / 2e-5 for e in small]).T
    return np.abs(np.linalg.eigvals(through))


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
def test_the_loop_is_stable_from_walking_pace_to_top_speed(car: Vehicle) -> None:
    tracking = LqrTracking.design(car)
    for speed in np.geomspace(1.0, 50.0, 12):
        assert modes(tracking, car, float(speed)).max() < 0.98
    along = np.array([[1.0, 0.01], [0.0, 1.0]]) - np.array([[0.5e-4], [0.01]]) @ tracking.speed_gains[None, :]
    assert np.abs(np.linalg.eigvals(along)).max() < 0.99


@pytest.mark.parametrize("factor", [0.7, 1.4])
def test_it_stays_stable_with_other_tyres_and_another_load(factor: float) -> None:
    car = CARS[0]
    tracking, c = LqrTracking.design(car), Chassis.of(car)
    stiffness = {name: getattr(c, name) * factor for name in ("cornering_stiffness_front_nprad", "cornering_stiffness_rear_nprad")}
    others = [
        replace(car, mass_kg=c.mass_kg * factor, yaw_inertia_kgm2=c.yaw_inertia_kgm2),
        replace(car, yaw_inertia_kgm2=c.yaw_inertia_kgm2 * factor),
        replace(car, **stiffness),
    ]
    for other in others:
        for speed in np.geomspace(1.0, 40.0, 8):
            assert modes(tracking, other, float(speed)).max() < 1.0


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


def urgent(car: Vehicle, speed: float, friction: float, side: float, along: float) -> Trajectory:
    """Half a lane out and back, steered as fast as plans for a dynamic vehicle may, to 93 % of the grip that `along` [m/s^2] leaves."""
    lateral = 0.93 * math.sqrt((friction * GRAVITY_MPS2) ** 2 - along**2)
    reach, fast = math.atan(car.wheelbase_m * lateral / speed**2), STEERING_RATE_SHARE * car.steering_rate_max_radps
    count = max(math.ceil(math.sqrt(3.5 / lateral) / 0.1), 3)
    angle, rates = 0.0, []
    for each in [*[1.0] * count, *[-1.0] * count, *[0.0] * 20]:
        rates.append(min(max((side * reach * each - angle) / 0.1, -fast), fast))
        angle += 0.1 * rates[-1]
    start = HostState(speed_mps=speed, acceleration_mps2=along)
    return driven(car, start, [(0.0, float(rate)) for rate in rates], Road(friction=friction))


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
@pytest.mark.parametrize("friction", [0.3, 0.5, 0.8])
@pytest.mark.parametrize(("speed", "along"), [(13.0, 0.0), (20.0, -1.5), (28.0, 0.0), (28.0, -1.5)])
def test_tyres_are_worked_hard_and_the_car_does_not_turn_about(car: Vehicle, friction: float, speed: float, along: float) -> None:
    road, chassis, ends = Road(lanes_left=3, lanes_right=3, friction=friction), Chassis.of(car), []
    slides = 3.0 * friction * chassis.mass_kg * GRAVITY_MPS2 * chassis.cog_to_front_axle_m / car.wheelbase_m
    slides /= chassis.cornering_stiffness_rear_nprad  # the whole contact of the rear axle
    for side in (1.0, -1.0):
        plan = urgent(car, speed, friction, side, along)
        grip = GripMonitor(vehicle=car, believed=friction)
        tracking = LqrTracking.design(car, grip=grip)
        plant = DynamicPlant(car, road, HostState(speed_mps=speed, acceleration_mps2=along))
        host = MeasuredHost(car, plant.state, MotionSensors(), friction=friction, seed=1)
        slip, lateral = [], []
        for k in range(round(float(plan.t_s[-1]) / STEP_S)):
            grip.note(host.state, 0.0, host.slip, host.measured_if_slips)
            slip.append(abs(math.atan2(plant.state.lateral_speed_mps, plant.state.speed_mps)))
            applied = plant.step(*tracking.command(plan, k * STEP_S, host.state))
            lateral.append(abs(applied.lateral_acceleration_mps2))
            host.look(plant.state, applied)
        assert max(slip) < 1.2 * slides
        assert max(lateral) > 0.6 * math.sqrt((friction * GRAVITY_MPS2) ** 2 - along**2)
        assert grip.friction > 0.9 * friction  # nothing was made of slip that there was not
        ends.append(plant.state.to_vector())
    np.testing.assert_allclose(ends[0] * [1, -1, -1, 1, 1, -1], ends[1], atol=1e-9)


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


def test_a_car_that_slips_is_tracked_with_feedback() -> None:
    assert isinstance(default_controller(CARS[0], slips=False), FeedForward)
    assert isinstance(default_controller(CARS[0], slips=True), PlanTracking)


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
def test_wheels_turn_at_a_standstill_and_at_a_crawl_as_planned(car: Vehicle) -> None:
    """Nothing else moves then, and what the plan does next begins with them."""
    tracking = LqrTracking.design(car)
    for speed in (0.0, 0.05, 0.5):
        plan = driven(car, HostState(speed_mps=speed), [(0.0, 0.3)] * 10)
        plant = DynamicPlant(car, ROAD, HostState(speed_mps=speed))
        for k in range(100):
            plant.step(*tracking.command(plan, k * STEP_S, plant.state))
        assert plant.state.steering_rad == pytest.approx(0.3, abs=0.03)
