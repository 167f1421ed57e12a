"""TU Munich's vehicle models in our loop: the package's own motion, the road's friction, and standing still."""

from __future__ import annotations

import math
import sys
import tomllib
from dataclasses import replace
from importlib import import_module
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from vehiclemodels.init_mb import init_mb
from vehiclemodels.init_std import init_std
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb
from vehiclemodels.vehicle_dynamics_std import vehicle_dynamics_std

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.errors import MissingExtraError
from mcdas_opt.interop.vehicle_models import FAST_MPS, SLOW_MPS, VehicleModelPlant, multi_body, std
from mcdas_opt.simulation.car import Car
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.plant import PLANTS, PlantFactory
from mcdas_opt.simulation.record import Outcome

BMW = load_vehicle("bmw_320i")
BOTH = pytest.mark.parametrize("plant", [std, multi_body])
ROOT = Path(__file__).parents[2]


def slip_of(state: SlidingState) -> float:
    return math.atan2(state.lateral_speed_mps, state.speed_mps)


def test_both_are_registered_by_the_names_that_the_guide_says() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["entry-points"][PLANTS.group]
    found = {name: getattr(import_module(place.partition(":")[0]), place.partition(":")[2]) for name, place in declared.items()}
    assert (found["std"], found["multi-body"]) == (std, multi_body)
    doors = (ROOT / "docs" / "doors" / "cars.md").read_text("utf-8")
    assert all(f"--plant {name}" in doors for name in ("std", "multi-body"))


@pytest.mark.parametrize(
    ("plant", "rates", "begin"), [(std, vehicle_dynamics_std, init_std), (multi_body, vehicle_dynamics_mb, init_mb)], ids=["std", "mb"]
)
def test_a_bmw_moves_as_the_package_moves_it(plant: PlantFactory, rates: object, begin: object) -> None:
    """By scipy's integrator in the plane, with a tyre whose peak is the road's friction; here along a road that bends."""
    p = parameters_vehicle2()
    tire = replace(p.tire, p_dx1=0.8, p_dy1=0.8)
    tire = replace(tire, p_vx1=tire.p_vx1 * 0.8 / 1.1739, p_vy1=tire.p_vy1 * 0.8 / 1.0489, p_vy3=tire.p_vy3 * 0.8 / 1.0489)
    p = replace(p, tire=tire)
    x = begin([0.0, 0.0, 0.0, 22.0, 0.0, 0.0, 0.0], p)

    def motion(t: float, y: np.ndarray) -> list[float]:
        return rates(list(y), [0.06 if t < 0.7 else -0.06, -2.0], p)

    theirs = solve_ivp(motion, (0.0, 1.5), x, method="LSODA", rtol=1e-8, atol=1e-8, max_step=0.01).y[:, -1]
    car = plant(BMW, Road(friction=0.8, curvature=((0.0, 1e-3),)), SlidingState(speed_mps=22.0, acceleration_mps2=-2.0))
    for k in range(150):
        car.step(0.0, 0.06 if k < 70 else -0.06)
    ours = car.state
    assert isinstance(ours, SlidingState)
    speeds = (theirs[3] * math.cos(theirs[6]), theirs[3] * math.sin(theirs[6])) if plant is std else (theirs[3], theirs[10])
    assert ours.steering_rad == pytest.approx(theirs[2], abs=1e-6)
    assert ours.speed_mps == pytest.approx(speeds[0], abs=2e-3)
    assert ours.yaw_rate_radps == pytest.approx(theirs[5], abs=2e-3)
    assert ours.lateral_speed_mps + 1.4227 * ours.yaw_rate_radps == pytest.approx(speeds[1], abs=5e-3)
    turned = ours.heading_rad + 1e-3 * ours.s_m
    assert turned == pytest.approx(theirs[4], abs=2e-3)


@BOTH
@pytest.mark.parametrize("friction", [0.25, 0.9])
def test_brakes_use_the_roads_friction_and_the_car_still_steers(plant: PlantFactory, friction: float) -> None:
    """A locked front axle would not turn the car."""
    car = plant(BMW, Road(friction=friction), HostState(speed_mps=20.0))
    for k in range(100):
        car.step(-40.0, 0.1 if k >= 60 else 0.0)
    braked = (20.0 - car.state.speed_mps) / (friction * GRAVITY_MPS2 * 1.0)
    assert 0.75 < braked < 1.02
    assert car.state.turning(BMW.wheelbase_m)[1] > 0.01


@BOTH
def test_the_rear_axle_alone_drives(plant: PlantFactory) -> None:
    car = plant(BMW, Road(friction=0.25), HostState(speed_mps=10.0))
    for _ in range(200):
        car.step(20.0, 0.0)
    gained = (car.state.speed_mps - 10.0) / 2.0
    assert car.state.acceleration_mps2 == pytest.approx(1.65)
    assert 0.9 < gained < 1.3


@BOTH
@given(speed=st.floats(0.0, 40.0), friction=st.floats(0.2, 1.0), jerk=st.floats(-40.0, 20.0), rate=st.floats(-0.4, 0.4))
@settings(max_examples=6, deadline=None)
def test_whatever_is_asked_it_neither_jumps_nor_gives_more_than_the_road(
    plant: PlantFactory, speed: float, friction: float, jerk: float, rate: float
) -> None:
    car = Car(plant, Vehicle(), Road(friction=friction), HostState(speed_mps=speed))
    applied = [car.step(jerk, rate) for _ in range(60)]
    assert max(abs(step.lateral_acceleration_mps2) for step in applied) < 1.15 * friction * GRAVITY_MPS2


@BOTH
@given(speed=st.floats(2.6, 12.0), braking=st.floats(2.0, 8.0), steering=st.floats(-0.1, 0.1))
@settings(max_examples=3, deadline=None)
def test_braking_ends_at_standstill_and_the_car_drives_off_again(
    plant: PlantFactory, speed: float, braking: float, steering: float
) -> None:
    car = plant(BMW, Road(friction=0.9), HostState(speed_mps=speed, acceleration_mps2=-braking, steering_rad=steering))
    states = [car.state]
    while car.state.speed_mps > 0.0 and len(states) < 1000:
        car.step(0.0, 0.0)
        states.append(car.state)
    assert car.state.speed_mps == 0.0
    assert car.state.turning(BMW.wheelbase_m) == (0.0, 0.0)
    for _ in range(350):
        car.step(20.0, 0.0)
        states.append(car.state)
    assert car.state.speed_mps > FAST_MPS > SLOW_MPS
    steps = np.diff([(x.s_m, x.d_m) for x in states], axis=0)
    fastest = np.array([max(a.speed_mps, b.speed_mps) for a, b in pairwise(states)])
    assert np.all(np.hypot(*steps.T) <= 1.1 * fastest * STEP_S + 1e-6)


def test_a_heavier_car_of_the_same_shape_moves_alike() -> None:
    """Springs, inertias and loads go with the mass; one shift in the package's tyre does not (p_vx1, in the sine's argument)."""
    tyres = {f"cornering_stiffness_{axle}_nprad": 1.5 * value for axle, value in (("front", 129700.0), ("rear", 105400.0))}
    heavy = replace(BMW, mass_kg=1.5 * 1093.3, yaw_inertia_kgm2=1.5 * 1791.6, **tyres)
    cars = [multi_body(vehicle, Road(friction=0.7), HostState(speed_mps=20.0)) for vehicle in (BMW, heavy)]
    for car in cars:
        for k in range(80):
            car.step(-10.0 if k < 20 else 0.0, 0.1 if k < 40 else -0.1)
    np.testing.assert_allclose(cars[0].state.to_vector(), cars[1].state.to_vector(), atol=1e-3)


@BOTH
def test_the_planner_drives_it(plant: PlantFactory) -> None:
    drive = simulate(load_scene("front-braking-with-follower"), plant=plant)
    assert drive.outcome is Outcome.SAFE
    assert drive.unverified_plans == 0
    assert drive.plant == plant.__name__


@BOTH
def test_without_the_package_it_says_which_extra(plant: PlantFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "vehiclemodels.init_std", None)
    monkeypatch.setitem(sys.modules, "vehiclemodels.init_mb", None)
    with pytest.raises(MissingExtraError, match=r"mcdas-opt\[vehicle-models\]"):
        Car(plant, BMW, Road(), HostState())


def test_its_state_slips_from_the_first_state_on() -> None:
    bend = Road(curvature=((0.0, 0.004),))
    turn = HostState(speed_mps=20.0, steering_rad=math.atan(BMW.wheelbase_m * 0.004))
    car = std(BMW, bend, turn)
    assert isinstance(car, VehicleModelPlant)
    assert slip_of(car.state) < -0.005
    for _ in range(100):
        car.step(0.0, 0.0)
    assert abs(car.state.d_m) < 0.3
