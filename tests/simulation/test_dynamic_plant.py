"""The car with tyres: textbook steady states, a no-slip car at walking pace, and never more force than friction gives."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.single_track import zero_sideslip_point_m
from mcdas_opt.simulation.actuators import Applied
from mcdas_opt.simulation.dynamic_plant import DynamicPlant
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.kinematic_plant import KinematicPlant
from mcdas_opt.simulation.plant import Plant

CAR, ROAD = Vehicle(), Road(lanes_left=1, lanes_right=1, friction=0.9)
CARS = [CAR, *(load_vehicle(name) for name in ("bmw_320i", "lincoln_mkz", "tpcap"))]
GRIP = 0.9 * GRAVITY_MPS2


def run(plant: Plant, jerk: float, rate: float, steps: int) -> list[Applied]:
    return [plant.step(jerk, rate) for _ in range(steps)]


@given(st.floats(0.0, 45.0), st.floats(-40.0, 20.0), st.floats(-0.3, 0.3))
@settings(max_examples=20, deadline=None)
def test_straight_ahead_it_is_the_kinematic_car(speed: float, jerk: float, heading: float) -> None:
    start = HostState(speed_mps=speed, heading_rad=heading, d_m=1.0)
    plants = DynamicPlant(CAR, ROAD, start), KinematicPlant(CAR, ROAD, start)
    for plant in plants:
        run(plant, jerk, 0.0, 60)
    np.testing.assert_allclose(plants[0].state.to_vector(), plants[1].state.to_vector(), atol=1e-9)
    assert (plants[0].state.lateral_speed_mps, plants[0].state.yaw_rate_radps) == (0.0, 0.0)


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
@pytest.mark.parametrize("speed", [8.0, 15.0, 25.0])
def test_a_gentle_circle_has_the_analytic_understeer(car: Vehicle, speed: float) -> None:
    car = replace(car, speed_max_mps=50.0)
    chassis, wanted = Chassis.of(car), 0.3
    steering = car.wheelbase_m * wanted / speed**2 + chassis.understeer_gradient * wanted
    plant = DynamicPlant(car, ROAD, HostState(speed_mps=speed, steering_rad=steering))
    lateral = run(plant, 0.0, 0.0, 300)[-1].lateral_acceleration_mps2
    x = plant.state
    assert lateral == pytest.approx(x.speed_mps * x.yaw_rate_radps, rel=2e-3)
    expected = math.tan(x.steering_rad) * x.speed_mps / (car.wheelbase_m + chassis.understeer_gradient * x.speed_mps**2)
    assert x.yaw_rate_radps == pytest.approx(expected, rel=0.01)
    rear_slip = chassis.mass_kg * chassis.cog_to_front_axle_m / car.wheelbase_m * lateral / chassis.cornering_stiffness_rear_nprad
    assert math.atan2(x.lateral_speed_mps, x.speed_mps) == pytest.approx(-rear_slip, rel=0.02)


@given(st.floats(5.0, 40.0), st.floats(-0.1, 0.1), st.floats(-1.0, 1.0), st.floats(-0.3, 0.3), st.floats(-0.002, 0.002))
@settings(max_examples=10, deadline=None)
def test_it_is_the_linear_textbook_at_small_slip(speed: float, share: float, aside: float, yaw_rate: float, kappa: float) -> None:
    small, c = 1e-3, Chassis.of(CAR)
    steering, vy, r = small * share, small * aside, small * yaw_rate
    b = c.cog_to_rear_axle_m
    start = SlidingState(speed_mps=speed, steering_rad=steering, lateral_speed_mps=vy - b * r, yaw_rate_radps=r)
    plant = DynamicPlant(CAR, Road(curvature=((0.0, kappa),)), start)
    run(plant, 0.0, 0.0, 50)
    cf, cr, a, m, i = (
        c.cornering_stiffness_front_nprad,
        c.cornering_stiffness_rear_nprad,
        c.cog_to_front_axle_m,
        c.mass_kg,
        c.yaw_inertia_kgm2,
    )

    def right_side(_: float, q: np.ndarray) -> list[float]:
        front, rear = cf * (steering - (q[0] + a * q[1]) / speed), -cr * (q[0] - b * q[1]) / speed
        return [(front + rear) / m - speed * q[1], (a * front - b * rear) / i, q[1] - kappa * speed]

    found = solve_ivp(right_side, (0.0, 0.5), [vy, r, 0.0], rtol=1e-10, atol=1e-14).y[:, -1]
    x = plant.state
    np.testing.assert_allclose([x.lateral_speed_mps + b * x.yaw_rate_radps, x.yaw_rate_radps], found[:2], atol=2e-6)
    assert x.heading_rad == pytest.approx(found[2], abs=5e-5 if kappa else 1e-6)


@given(st.floats(0.05, 0.9), st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-0.4, 0.4)), min_size=2, max_size=4))
@settings(max_examples=20, deadline=None)
def test_at_walking_pace_it_is_the_kinematic_car(speed: float, inputs: list[tuple[float, float]]) -> None:
    start = HostState(speed_mps=speed)
    plants = DynamicPlant(CAR, ROAD, start), KinematicPlant(CAR, ROAD, start)
    for jerk, rate in inputs:
        for plant in plants:
            run(plant, jerk, rate, 25)
        assume(plants[1].state.speed_mps < 1.0)
    np.testing.assert_allclose(plants[0].state.to_vector(), plants[1].state.to_vector(), atol=1e-6)


def test_from_walking_pace_up_the_circles_widen_without_a_jump() -> None:
    radii = []
    for speed in np.arange(0.5, 6.0, 0.25):
        plant = DynamicPlant(CAR, ROAD, HostState(speed_mps=float(speed), steering_rad=0.05))
        run(plant, 0.0, 0.0, 200)
        radii.append(plant.state.speed_mps / plant.state.yaw_rate_radps)
    assert radii[0] == pytest.approx(2.7 / math.tan(0.05), rel=1e-6)
    assert np.all(np.diff(radii) > -1e-6)
    assert np.diff(radii).max() < 0.01 * radii[0]


INPUTS = st.lists(st.tuples(st.floats(-100.0, 100.0), st.floats(-3.0, 3.0)), min_size=1, max_size=8)


@given(INPUTS, st.floats(0.0, 50.0), st.floats(0.05, 1.2), st.sampled_from(CARS))
@settings(max_examples=40, deadline=None)
def test_whatever_is_asked_no_limit_and_no_friction_is_passed(
    inputs: list[tuple[float, float]], speed: float, friction: float, car: Vehicle
) -> None:
    plant = DynamicPlant(car, Road(friction=friction), HostState(speed_mps=min(speed, car.speed_max_mps)))
    grip = friction * GRAVITY_MPS2
    for jerk, rate in inputs:
        for applied in run(plant, jerk, rate, 15):
            assert car.jerk_min_mps3 <= applied.jerk_mps3 <= car.jerk_max_mps3
            assert abs(applied.steering_rate_radps) <= car.steering_rate_max_radps
            assert abs(applied.lateral_acceleration_mps2) <= grip + 1e-9
        x = plant.state
        assert 0.0 <= x.speed_mps <= car.speed_max_mps
        assert abs(x.steering_rad) <= car.steering_max_rad
        assert max(car.acceleration_min_mps2, -grip) - 1e-9 <= x.acceleration_mps2 <= min(car.acceleration_max_mps2, grip) + 1e-9


@given(st.floats(8.0, 40.0), st.floats(0.0, 2.0), st.floats(-40.0, 20.0), st.floats(0.1, 1.0), st.floats(-6.0, 2.0))
@settings(max_examples=20, deadline=None)
def test_mirror_the_inputs_and_the_drive_mirrors(speed: float, rate: float, jerk: float, friction: float, a: float) -> None:
    start = HostState(speed_mps=speed, acceleration_mps2=a)
    left, right = (DynamicPlant(CAR, Road(friction=friction), start) for _ in range(2))
    run(left, jerk, rate, 60)
    run(right, jerk, -rate, 60)
    mirror = np.array([1.0, -1.0, -1.0, 1.0, 1.0, -1.0])
    np.testing.assert_allclose(left.state.to_vector(), mirror * right.state.to_vector(), atol=1e-9)


def kinetic_energy(state: SlidingState, car: Vehicle) -> float:
    """[J] Of the motion in the plane: m (vx^2 + vy^2) / 2 + I r^2 / 2, about the centre of gravity."""
    chassis = Chassis.of(car)
    vx, r = state.speed_mps, state.yaw_rate_radps
    vy = state.lateral_speed_mps + chassis.cog_to_rear_axle_m * r
    return 0.5 * chassis.mass_kg * (vx * vx + vy * vy) + 0.5 * chassis.yaw_inertia_kgm2 * r * r


@given(
    st.floats(8.0, 45.0), st.floats(-5.0, 5.0), st.floats(-1.5, 1.5), st.floats(-0.5, 0.5), st.floats(0.1, 1.0), st.sampled_from(CARS[:3])
)
@settings(max_examples=30, deadline=None)
def test_coasting_never_gains_energy(speed: float, aside: float, yaw_rate: float, steering: float, friction: float, car: Vehicle) -> None:
    sliding = SlidingState(speed_mps=speed, steering_rad=steering, lateral_speed_mps=aside, yaw_rate_radps=yaw_rate)
    plant = DynamicPlant(car, Road(friction=friction), sliding)
    before = first = kinetic_energy(plant.state, car)
    for _ in range(150):
        plant.step(0.0, 0.0)
        if plant.state.speed_mps < 3.0:
            break
        energy = kinetic_energy(plant.state, car)
        assert energy <= before + 1e-6 * first
        before = energy


def test_braking_takes_the_grip_that_turning_needs() -> None:
    still, braking = (DynamicPlant(CAR, ROAD, HostState(speed_mps=25.0, acceleration_mps2=a, steering_rad=0.1)) for a in (0.0, -7.9))
    turned = [abs(run(plant, 0.0, 0.0, 60)[-1].lateral_acceleration_mps2) for plant in (still, braking)]
    assert turned[0] > 0.9 * GRIP
    assert turned[1] < 0.6 * turned[0]


def test_over_the_limit_it_runs_wide_and_its_equivalent_says_so() -> None:
    plant = DynamicPlant(CAR, Road(friction=0.3), HostState(speed_mps=20.0, steering_rad=0.2))
    run(plant, 0.0, 0.0, 1100)
    seen = plant.state.without_slip(CAR.wheelbase_m)
    assert seen.steering_rad < 0.3 * plant.state.steering_rad
    assert seen.speed_mps**2 * math.tan(seen.steering_rad) / 2.7 < 0.3 * GRAVITY_MPS2 * 1.05


@given(st.floats(4.0, 30.0), st.floats(-0.05, 0.05), st.floats(0.0, 0.3))
@settings(max_examples=15, deadline=None)
def test_the_equivalent_moves_as_the_car(speed: float, steering: float, heading: float) -> None:
    plant = DynamicPlant(CAR, ROAD, HostState(speed_mps=speed, steering_rad=steering, heading_rad=heading))
    run(plant, 0.0, 0.0, 100)
    seen = plant.state.without_slip(CAR.wheelbase_m)
    twin = KinematicPlant(CAR, Road(friction=5.0), seen)
    run(plant, 0.0, 0.0, 1)
    run(twin, 0.0, 0.0, 1)
    x, y = plant.state, twin.state
    slip = seen.heading_rad - plant.state.heading_rad  # turns the arm from axle to centre: second order
    tolerance = STEP_S * (0.5 * GRIP * STEP_S + CAR.centre_m * abs(x.yaw_rate_radps * slip) + 0.01 + 0.5 * speed * slip**2 * 2)
    assert math.hypot(x.s_m - y.s_m, x.d_m - y.d_m) < tolerance


@given(st.floats(1.0, 8.0), st.floats(0.5, 30.0), st.floats(-0.1, 0.1))
@settings(max_examples=15, deadline=None)
def test_braking_ends_at_standstill_and_stays_there(deceleration: float, speed: float, steering: float) -> None:
    plant = DynamicPlant(CAR, ROAD, HostState(speed_mps=speed, acceleration_mps2=-deceleration, steering_rad=steering))
    run(plant, 0.0, 0.0, math.ceil(speed / deceleration / STEP_S) + 5)
    x = plant.state
    assert (x.speed_mps, x.acceleration_mps2, x.lateral_speed_mps, x.yaw_rate_radps) == (0.0, 0.0, 0.0, 0.0)
    run(plant, -40.0, 0.0, 20)
    assert plant.state == x
    assert plant.state.without_slip(CAR.wheelbase_m) == HostState.from_vector(x.to_vector())


@given(kappa=st.floats(-0.004, 0.004), speed=st.floats(5.0, 25.0))
@settings(max_examples=25, deadline=None)
def test_a_car_put_into_a_bend_goes_on_in_it(kappa: float, speed: float) -> None:
    """It keeps its lane with its wheels held, as if it had always been there; what it is equivalent to is what it was put as.

    Wheels are placed for tyres that are straight lines. Fiala's give less by ay / (3 mu g), to first order: so much more they understeer.
    """
    turn = HostState(speed_mps=speed, steering_rad=math.atan(CAR.wheelbase_m * kappa), heading_rad=-math.asin(CAR.centre_m * kappa))
    plant = DynamicPlant(CAR, Road(curvature=((0.0, kappa),), friction=1.0), turn)
    assert plant.state.without_slip(CAR.wheelbase_m).steering_rad == pytest.approx(turn.steering_rad, abs=1e-9)
    assert plant.state.without_slip(CAR.wheelbase_m).heading_rad == pytest.approx(turn.heading_rad, abs=1e-4)
    run(plant, 0.0, 0.0, 100)
    assert abs(plant.state.d_m) < 0.05
    speed = plant.state.speed_mps  # turning drags it down
    understeer = Chassis.of(CAR).understeer_gradient * speed**2
    less = understeer / (CAR.wheelbase_m + understeer) * speed**2 * abs(kappa) / (3.0 * GRAVITY_MPS2)
    assert plant.state.yaw_rate_radps == pytest.approx(speed * kappa * (1.0 - less), abs=0.003 * speed * abs(kappa) + 1e-6)


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
@given(lateral=st.floats(-0.5, 0.5), speed=st.floats(5.0, 35.0))
@settings(max_examples=10, deadline=None)
def test_in_a_steady_turn_it_moves_along_its_axis_at_the_zero_sideslip_point(car: Vehicle, lateral: float, speed: float) -> None:
    """Whatever the radius: so the heading that a planner is told is the car's own."""
    car = replace(car, speed_max_mps=50.0)
    steering = (car.wheelbase_m / speed**2 + Chassis.of(car).understeer_gradient) * lateral
    plant = DynamicPlant(car, ROAD, HostState(speed_mps=speed, steering_rad=steering))
    run(plant, 0.0, 0.0, 300)
    told = plant.state.without_slip(car.wheelbase_m, zero_sideslip_point_m(Chassis.of(car), plant.state.speed_mps))
    assert told.heading_rad == pytest.approx(plant.state.heading_rad, abs=0.05 * Chassis.of(car).rear_slip_gradient * abs(lateral) + 1e-6)


@given(speed=st.floats(12.0, 33.0), lateral=st.floats(1.0, 3.0), period=st.floats(1.5, 3.0))
@settings(max_examples=20, deadline=None)
def test_about_the_zero_sideslip_point_the_no_slip_car_goes_where_this_one_goes(speed: float, lateral: float, period: float) -> None:
    """From the middle of a swerve to its end, turned as this car turns: about the rear axle it is told to be farther in than it gets."""
    plant, steps = DynamicPlant(CAR, ROAD, HostState(speed_mps=speed)), round(period / STEP_S)
    reach = (CAR.wheelbase_m / speed**2 + Chassis.of(CAR).understeer_gradient) * lateral
    wheels = reach * np.sin(2.0 * math.pi * np.arange(steps + 1) / steps)
    no_slip: dict[float, list[float]] = {}
    for k in range(steps + 50):
        if k == steps // 3:
            points = (0.0, zero_sideslip_point_m(Chassis.of(CAR), plant.state.speed_mps))
            no_slip = {point: plant.state.without_slip(CAR.wheelbase_m, point).to_vector().tolist() for point in points}
        for point, x in no_slip.items():
            turn = plant.state.yaw_rate_radps / plant.state.speed_mps
            x[:3] = road_bicycle_step(x, turn, plant.state.speed_mps, CAR.centre_m - point)
        run(plant, 0.0, (wheels[k + 1] - wheels[k]) / STEP_S if k < steps else 0.0, 1)
    about_axle, about_point = (abs(x[1] - plant.state.d_m) for x in no_slip.values())
    assert about_point < 0.4 * about_axle


def road_bicycle_step(x: list[float], turn: float, speed: float, centre: float) -> list[float]:
    """(s, d, psi) of the no-slip car's body centre a step later."""
    s, d, psi = x[:3]
    forward, aside = speed, speed * centre * turn
    return [
        s + STEP_S * (forward * math.cos(psi) - aside * math.sin(psi)),
        d + STEP_S * (forward * math.sin(psi) + aside * math.cos(psi)),
        psi + STEP_S * speed * turn,
    ]
