"""Dead time and lags of steering, brakes and engine: plants obey them, and what is known of them is compensated."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.actuator_response import ActuatorResponse
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import DrivenAxle, Vehicle
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.car import Car
from mcdas_opt.simulation.dynamic_plant import DynamicPlant
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome
from tests.simulation.fake_driver import FakeDriver
from tests.simulation.scene_maker import make_scene

ROAD = Road(lanes_left=1, lanes_right=1, friction=0.8)
START = HostState(speed_mps=20.0)
PLANTS = pytest.mark.parametrize("plant", ["kinematic", "dynamic"])


def answering(**times: float) -> Vehicle:
    return replace(Vehicle(), actuators=ActuatorResponse(**times))


def inputs(k: int) -> tuple[float, float]:
    return 5.0 * math.sin(0.1 * k), 0.2 * math.cos(0.07 * k)


@PLANTS
@given(steps=st.integers(1, 15))
@settings(max_examples=5, deadline=None)
def test_a_delayed_car_does_later_what_it_is_told(plant: str, steps: int) -> None:
    delayed, prompt = (Car(plant, car, ROAD, START) for car in (answering(steering_delay_s=0.01 * steps), Vehicle()))
    later, now = [], []
    for k in range(60):
        later.append(delayed.step(*inputs(k)))
        now.append(prompt.step(*inputs(k)))
    assert all(row.steering_rate_radps == row.jerk_mps3 == 0.0 for row in later[:steps])
    rates = [[row.steering_rate_radps for row in rows] for rows in (later[steps:], now[:-steps])]
    np.testing.assert_allclose(*rates, atol=1e-9)


@PLANTS
@given(steps=st.integers(0, 12), lag=st.sampled_from([0.0, 0.04]))
@settings(max_examples=8, deadline=None)
def test_the_state_at_which_a_command_takes_effect_is_known(plant: str, steps: int, lag: float) -> None:
    """Exactly, where the plant is the model; the wheels are told as they are commanded."""
    car = Car(plant, answering(steering_delay_s=0.01 * steps, steering_lag_s=lag), ROAD, START)
    for k in range(40):
        car.step(*inputs(k))
    told = car.ahead(car.state, ROAD.friction)
    for k in range(steps):
        car.step(*inputs(40 + k))
    wheels = car.state.steering_rad if lag == 0.0 else told.steering_rad
    np.testing.assert_allclose(told.to_vector(), replace(car.state, steering_rad=wheels).to_vector(), atol=1e-9)


def test_a_lagging_wheel_nears_the_commanded_angle_by_its_time_constant() -> None:
    car = Car("kinematic", answering(steering_lag_s=0.1), ROAD, START)
    for _ in range(5):
        car.step(0.0, 0.4)
    before = 0.02 - car.state.steering_rad
    for _ in range(10):
        car.step(0.0, 0.0)
    assert 0.02 - car.state.steering_rad == pytest.approx(before * math.exp(-1.0), rel=1e-6)


def test_brakes_build_up_and_release_and_the_engine_answers_by_their_time_constants() -> None:
    car = Car("kinematic", answering(brake_build_up_s=0.15, brake_release_s=0.1, engine_lag_s=0.4), Road(friction=1.2), START)
    braking = []
    for _ in range(60):
        car.step(-40.0, 0.0)
        braking.append(car.state.acceleration_mps2)
    late = -8.0 - np.array(braking)[30:]
    np.testing.assert_allclose(late[15:] / late[:-15], math.exp(-1.0), rtol=1e-3)
    assert min(braking) > -8.0
    for _ in range(40):
        car.step(20.0, 0.0)
    before = 3.0 - car.state.acceleration_mps2
    for _ in range(40):
        car.step(20.0, 0.0)
    assert 0.0 < 3.0 - car.state.acceleration_mps2 == pytest.approx(before * math.exp(-1.0), rel=1e-3)


def written(folder: Path, lines: str) -> str:
    """A vehicle file: the sedan's, and these lines."""
    given = (models_folder() / "vehicles" / "sedan.toml").read_text("utf-8").split("[sources]")[0]
    path = folder / "car.toml"
    path.write_text(f"{given}\n{lines}\n", encoding="utf-8")
    return str(path)


@PLANTS
@pytest.mark.parametrize("delay", [0.05, 0.1])
def test_plans_begin_where_commands_take_effect_and_the_drive_keeps_to_them(plant: str, delay: float, tmp_path: Path) -> None:
    """Steered to and fro in open loop, replanned every cycle: without compensation a plan would be driven from elsewhere."""
    told: list[tuple[float, HostState]] = []

    def wanted(host: HostState, now: float) -> tuple[float, float]:
        told.append((now, host))
        return 0.0, 0.03 * math.cos(4.0 * now)

    car = written(tmp_path, f"[actuators]\nsteering_delay_s = {delay}")
    drive = simulate(make_scene(speed_mps=20.0, duration_s=2.0, host={"vehicle": car}), FakeDriver(wanted), plant=plant)
    assert drive.outcome is Outcome.SAFE
    for now, host in told[:-2]:
        then = round(now / 0.01)
        assert now == pytest.approx(0.1 * round((now - delay) / 0.1) + delay)
        assert drive.history.states[then][[0, 1]] == pytest.approx([host.s_m, host.d_m], abs=1e-6 if plant == "kinematic" else 1e-3)
        assert drive.history.states[then][5] == pytest.approx(host.steering_rad, abs=1e-6 if plant == "kinematic" else 0.02)


@pytest.mark.parametrize(
    ("line", "key", "rule"),
    [
        ("[actuators]\nsteering_delay_s = -0.05", "steering_delay_s", "0"),
        ("[actuators]\nsteering_dealy_s = 0.05", "steering_dealy_s", "did you mean"),
        ("axle_load_front_kg = 800.0\naxle_load_rear_kg = 500.0\nmass_kg = 1500.0", "axle_load_front_kg", "add up to mass_kg = 1500"),
        ("axle_load_front_kg = 800.0", "axle_load_front_kg", "other axle"),
        ("axle_load_front_kg = 800.0\naxle_load_rear_kg = 800.0\ncog_to_front_axle_m = 1.0", "cog_to_front_axle_m", "must be 1.350"),
        ('driven_axle = "middle"', "driven_axle", "front, rear, both"),
        ("brake_share_front = 1.2", "brake_share_front", "[0, 1]"),
        ('anti_lock = "sometimes"', "anti_lock", "bool"),
    ],
)
def test_a_file_that_contradicts_itself_is_one_error(tmp_path: Path, line: str, key: str, rule: str) -> None:
    with pytest.raises(InputError, match=key) as caught:
        load_vehicle(written(tmp_path, line))
    assert rule in str(caught.value)
    assert "\n" not in str(caught.value)


def test_axle_loads_say_mass_and_centre_of_gravity() -> None:
    chassis = Chassis.of(replace(Vehicle(), axle_load_front_kg=900.0, axle_load_rear_kg=600.0))
    assert chassis.mass_kg == 1500.0
    assert chassis.cog_to_front_axle_m == pytest.approx(0.4 * 2.7)
    with pytest.raises(ParameterError, match="add up"):
        replace(Vehicle(), axle_load_front_kg=900.0, axle_load_rear_kg=600.0, mass_kg=1400.0)


@pytest.mark.parametrize("driven", [DrivenAxle.FRONT, DrivenAxle.REAR])
def test_one_driven_axle_gives_no_more_than_its_load_on_ice(driven: DrivenAxle) -> None:
    both, one = (DynamicPlant(replace(Vehicle(), driven_axle=axle), Road(friction=0.25), START) for axle in (DrivenAxle.BOTH, driven))
    for car in (both, one):
        for _ in range(200):
            car.step(20.0, 0.0)
    gained = [(car.state.speed_mps - 20.0) / 2.0 for car in (both, one)]
    assert 0.4 * gained[0] < gained[1] < 0.65 * gained[0]
    for car in (both, one):
        for _ in range(100):
            car.step(-40.0, 0.0)
    assert both.state.acceleration_mps2 == one.state.acceleration_mps2 < -2.0


@pytest.mark.parametrize(("share", "anti_lock", "least", "most"), [(0.9, True, 0.5, 1.2), (0.9, False, -0.1, 0.1)])
def test_locked_front_wheels_do_not_steer(share: float, anti_lock: bool, least: float, most: float) -> None:
    """Braked at 0.8 of what the road gives, which is all that the front axle has, and steered: yaw rate over that of the same car whose
    brakes share by load."""
    yaw_rates = []
    for brakes in (Vehicle(), replace(Vehicle(), brake_share_front=share, anti_lock=anti_lock)):
        car = DynamicPlant(brakes, ROAD, START)
        for k in range(60):
            car.step(-40.0 if car.state.acceleration_mps2 > -6.2 else 0.0, 0.1 if k >= 30 else 0.0)
        yaw_rates.append(car.state.yaw_rate_radps)
    assert least <= yaw_rates[1] / yaw_rates[0] <= most


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.1, 0.15])
@pytest.mark.parametrize("latency_s", [0.0, 0.05])
def test_a_delayed_car_keeps_its_tracks(delay: float, latency_s: float, tmp_path: Path) -> None:
    """Plans begin where commands take effect; scans that arrive between two of them are not taken for a clock set back."""
    car = written(tmp_path, f"[actuators]\nsteering_delay_s = {delay}")
    both = {"s_m": 40.0, "speed_mps": 11.1}, {"s_m": -30.0, "speed_mps": 11.1}
    sensors = {"front": "delphi_esr", "rear": "delphi_esr", "latency_s": latency_s}
    scene = make_scene(*both, host={"vehicle": car}, sensors=sensors, duration_s=2.0)
    planner = Planner(vehicle=scene.vehicle, road=scene.assumed_road, method="closed-form")
    drive = simulate(scene, planner=planner)
    assert planner.tracker.counters["clock_back"] == 0
    assert [len(cycle.tracks) for cycle in drive.cycles] == [2] * len(drive.cycles)


def test_who_accelerates_brakes_as_soon_as_the_brakes_answer_however_slow_the_engine() -> None:
    """The engine's lag let the acceleration fall towards 0 for ever, and never below."""
    car = Car("kinematic", answering(brake_build_up_s=0.2, engine_lag_s=0.5), Road(friction=1.2), replace(START, acceleration_mps2=2.0))
    for _ in range(100):
        car.step(-40.0, 0.0)
    assert car.state.acceleration_mps2 < -7.0
