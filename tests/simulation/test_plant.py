"""The plant is the bicycle where nothing saturates, and says honestly what it cannot do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.simulation.actuators import Applied
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.kinematic_plant import KinematicPlant
from mcdas_opt.simulation.plant import make_plant

CAR, ROAD = Vehicle(), Road(lanes_left=1, lanes_right=1, friction=0.9)
GRIP = 0.9 * GRAVITY_MPS2


def run(plant: KinematicPlant, jerk: float, rate: float, steps: int) -> list[Applied]:
    return [plant.step(jerk, rate) for _ in range(steps)]


@given(st.floats(-0.2, 0.2), st.floats(2.0, 10.0))
@settings(max_examples=20, deadline=None)
def test_constant_steering_draws_a_circle_of_radius_l_over_tan(delta: float, speed: float) -> None:
    if abs(delta) < 0.01 or speed**2 * abs(math.tan(delta)) / 2.7 > GRIP:
        return
    plant = KinematicPlant(CAR, ROAD, HostState(speed_mps=speed, steering_rad=delta))
    radius = 2.7 / math.tan(delta)
    rear = []
    for _ in range(200):
        x = plant.state
        rear.append((x.s_m - CAR.centre_m * math.cos(x.heading_rad), x.d_m - CAR.centre_m * math.sin(x.heading_rad)))
        plant.step(0.0, 0.0)
    centre = (rear[0][0], rear[0][1] + radius)
    np.testing.assert_allclose([math.dist(p, centre) for p in rear], abs(radius), rtol=1e-9)


@given(
    st.floats(8.0, 30.0),
    st.lists(st.tuples(st.floats(-4.0, 4.0), st.floats(-0.04, 0.04)), min_size=3, max_size=3),
    st.floats(-0.002, 0.002),
)
@settings(max_examples=15, deadline=None)
def test_within_all_limits_it_is_the_bicycle_of_an_independent_integrator(
    speed: float, inputs: list[tuple[float, float]], kappa: float
) -> None:
    road = Road(curvature=((0.0, kappa),), friction=0.9)
    plant = KinematicPlant(CAR, road, HostState(speed_mps=speed))
    x = np.array(plant.state.to_vector())
    for jerk, rate in inputs:
        applied = run(plant, jerk, rate, 30)
        assert all(a.jerk_mps3 == jerk and a.steering_rate_radps == rate for a in applied)

        def right_side(_: float, q: np.ndarray, jerk: float = jerk, rate: float = rate) -> list[float]:
            turn = math.tan(q[5]) / 2.7
            forward = q[3] * math.cos(q[2]) - 1.35 * q[3] * turn * math.sin(q[2])
            along = forward / (1.0 - q[1] * kappa)
            aside = q[3] * math.sin(q[2]) + 1.35 * q[3] * turn * math.cos(q[2])
            return [along, aside, q[3] * turn - kappa * along, q[4], jerk, rate]

        x = solve_ivp(right_side, (0.0, 0.3), x, rtol=1e-10, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(plant.state.to_vector(), x, atol=1e-7)


INPUTS = st.lists(st.tuples(st.floats(-100.0, 100.0), st.floats(-3.0, 3.0)), min_size=1, max_size=12)


@given(INPUTS, st.floats(0.0, 50.0), st.floats(0.05, 1.2))
@settings(max_examples=60, deadline=None)
def test_whatever_is_asked_no_limit_is_passed_and_nobody_reverses(inputs: list[tuple[float, float]], speed: float, friction: float) -> None:
    plant = KinematicPlant(CAR, Road(friction=friction), HostState(speed_mps=speed))
    grip = friction * GRAVITY_MPS2
    before = plant.state
    for jerk, rate in inputs:
        for applied in run(plant, jerk, rate, 10):
            assert CAR.jerk_min_mps3 <= applied.jerk_mps3 <= CAR.jerk_max_mps3
            assert abs(applied.steering_rate_radps) <= CAR.steering_rate_max_radps
            assert abs(applied.lateral_acceleration_mps2) <= grip + 1e-9
        x = plant.state
        assert 0.0 <= x.speed_mps <= CAR.speed_max_mps
        assert abs(x.steering_rad) <= CAR.steering_max_rad
        assert CAR.acceleration_min_mps2 <= x.acceleration_mps2 <= CAR.acceleration_max_mps2
        assert abs(x.acceleration_mps2) <= grip + 1e-9
        assert x.speed_mps - before.speed_mps <= CAR.acceleration_max_mps2 * 0.1 + 1e-9
        before = x


def test_over_the_circle_steering_gives_way_first() -> None:
    state = HostState(speed_mps=20.0, acceleration_mps2=-6.0, steering_rad=0.2)
    applied = KinematicPlant(CAR, ROAD, state).step(0.0, 0.0)
    assert applied.jerk_mps3 == 0.0  # the acceleration keeps what it had ...
    assert applied.lateral_acceleration_mps2 == pytest.approx(math.sqrt(GRIP**2 - 36.0))  # ... turning gets what is left
    assert 20.0**2 * math.tan(0.2) / 2.7 > GRIP


def test_with_no_grip_left_for_turning_the_acceleration_gives_way_too() -> None:
    ice = Road(friction=0.3)
    plant = KinematicPlant(CAR, ice, HostState(speed_mps=20.0, steering_rad=0.1))
    applied = run(plant, -40.0, 0.0, 40)
    assert plant.state.acceleration_mps2 == pytest.approx(-0.3 * GRAVITY_MPS2)
    assert applied[-1].lateral_acceleration_mps2 == pytest.approx(0.0, abs=1e-6)
    assert plant.state.steering_rad == pytest.approx(0.1)  # the wheels stand as they were turned


def test_under_steering_the_path_has_the_curvature_of_the_grip() -> None:
    plant = KinematicPlant(CAR, Road(friction=0.3), HostState(speed_mps=20.0, steering_rad=0.3))
    run(plant, 0.0, 0.0, 100)
    assert plant.state.heading_rad == pytest.approx(0.3 * GRAVITY_MPS2 / 20.0, rel=1e-9)


@given(st.floats(0.001, 8.0), st.floats(0.1, 30.0))
@settings(max_examples=30, deadline=None)
def test_braking_ends_at_standstill_and_stays_there(deceleration: float, speed: float) -> None:
    plant = KinematicPlant(CAR, ROAD, HostState(speed_mps=speed, acceleration_mps2=-deceleration, steering_rad=0.1))
    steps = math.ceil(speed / deceleration / STEP_S) + 1
    if steps > 4000:
        return
    run(plant, 0.0, 0.0, steps)
    x = plant.state
    assert (x.speed_mps, x.acceleration_mps2) == (0.0, 0.0)
    run(plant, -40.0, 0.5, 20)
    rest = plant.state
    assert (rest.s_m, rest.d_m, rest.heading_rad, rest.speed_mps) == (x.s_m, x.d_m, x.heading_rad, 0.0)
    assert rest.steering_rad == pytest.approx(0.2)


def test_the_stopping_distance_is_the_textbooks() -> None:
    plant = KinematicPlant(CAR, ROAD, HostState(speed_mps=12.34, acceleration_mps2=-7.0))
    run(plant, 0.0, 0.0, 300)
    assert plant.state.s_m == pytest.approx(12.34**2 / 14.0, abs=1e-9)


def test_from_standstill_it_moves_off() -> None:
    plant = KinematicPlant(CAR, ROAD, HostState())
    run(plant, 10.0, 0.0, 10)
    assert plant.state.acceleration_mps2 == pytest.approx(1.0)
    assert plant.state.speed_mps == pytest.approx(0.05)


def test_mirror_the_inputs_and_the_drive_mirrors() -> None:
    left, right = (KinematicPlant(CAR, Road(friction=0.5), HostState(speed_mps=15.0)) for _ in range(2))
    for jerk, rate in ((5.0, 0.4), (-30.0, 0.5), (10.0, -0.5)):
        run(left, jerk, rate, 30)
        run(right, jerk, -rate, 30)
    np.testing.assert_array_equal(left.state.to_vector() * [1, -1, -1, 1, 1, -1], right.state.to_vector())


def test_an_unknown_plant_is_refused_by_name() -> None:
    with pytest.raises(ParameterError, match="kinematic"):
        make_plant("kinetic", CAR, ROAD, HostState())
