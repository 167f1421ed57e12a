"""A plant of a user: found by name or handed over, and answered with one clear error where it fails."""

from __future__ import annotations

import json
import math
import pickle
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from mcdas_opt.cli import main
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.simulation.actuators import Applied
from mcdas_opt.simulation.car import Car, PlantError
from mcdas_opt.simulation.kinematic_plant import KinematicPlant
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.motion_sensors import MotionSensors
from mcdas_opt.simulation.plant import PLANTS, plant_name
from tests.simulation import plants_of_a_user
from tests.simulation.fake_driver import FakeDriver
from tests.simulation.scene_maker import make_scene


class Failing:
    """A kinematic vehicle until its step number `at`; from then on its state is what `wrong` makes of it."""

    def __init__(
        self, vehicle: Vehicle, road: Road, state: HostState, *, wrong: Callable[[HostState], HostState | None], at: int = 25
    ) -> None:
        self._inner, self._wrong, self._at, self._steps = KinematicPlant(vehicle, road, state), wrong, at, 0

    @property
    def state(self) -> HostState:
        state = self._inner.state
        return state if self._steps < self._at else self._wrong(state)

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        self._steps += 1
        return self._inner.step(jerk_mps3, steering_rate_radps)


WRONG: dict[str, tuple[Callable[[HostState], HostState | None], str]] = {
    "nan": (lambda state: replace(state, speed_mps=math.nan), "speed_mps = nan m/s: must be finite"),
    "nothing": (lambda state: None, "state = None: must be a HostState"),
    "elsewhere": (lambda state: replace(state, s_m=state.s_m + 3.0), "moved by 3.1"),
    "beside": (lambda state: replace(state, d_m=state.d_m - 2.0), "moved by 2"),
    "faster": (lambda state: replace(state, speed_mps=state.speed_mps + 2.0), "speed_mps changed by 2 m/s"),
    "turned": (lambda state: replace(state, heading_rad=1.0), "heading_rad changed by 1 rad"),
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("at", [1, 25, 31])
def test_a_plant_that_fails_ends_the_drive_with_one_error_and_the_drive_up_to_there(name: str, at: int) -> None:
    wrong, said = WRONG[name]
    beside = {"name": "beside", "s_m": 20.0, "speed_mps": 10.0}
    scene = make_scene(beside, speed_mps=10.0, sensors={"front": "delphi_esr"})
    with pytest.raises(PlantError, match=said) as caught:
        simulate(scene, FakeDriver(), plant=partial(Failing, wrong=wrong, at=at))
    assert str(caught.value).startswith(f"plant 'Failing' at t = {at / 100:.2f} s: ")
    drive, whole = caught.value.drive, simulate(scene, FakeDriver())
    assert drive is not None
    assert drive.plant == "Failing"
    assert drive.duration_s == pytest.approx((at - 1) / 100)
    assert drive.error == str(caught.value)
    assert (drive.is_safe, whole.is_safe) == (False, True)
    assert (drive.to_dict()["error"], whole.to_dict()["error"]) == (str(caught.value), "")
    assert "plant failed after" in drive.in_brief()[0]
    assert np.array_equal(drive.history.states, whole.history.states[:at])
    assert np.array_equal(drive.history.clearance_m, whole.history.clearance_m[:at])


def test_the_error_of_a_plant_comes_whole_out_of_another_process() -> None:
    fault = PlantError("theirs", 0.35, "raised RuntimeError: out of petrol")
    again = pickle.loads(pickle.dumps(fault))
    assert (str(again), again.plant, again.time_s, again.fault) == (str(fault), "theirs", 0.35, fault.fault)


class LyingPlant(KinematicPlant):
    """It says that it did something that is no number."""

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        return replace(super().step(jerk_mps3, steering_rate_radps), lateral_acceleration_mps2=math.nan)


def test_a_plant_that_says_it_did_no_number_is_one_error() -> None:
    with pytest.raises(PlantError, match="lateral_acceleration_mps2 = nan") as caught:
        simulate(make_scene(duration_s=0.3), FakeDriver(), plant=LyingPlant)
    assert caught.value.drive is not None


@pytest.mark.parametrize("sensors", ["produktion", 3, None])
def test_sensors_that_are_none_are_refused(sensors: object) -> None:
    with pytest.raises(ParameterError, match="motion_sensors"):
        simulate(make_scene(), FakeDriver(), motion_sensors=sensors)


@pytest.mark.parametrize(("field", "value"), [("yaw_rate_sd_radps", -0.1), ("speed_share", 0.5), ("steering_offset_rad", math.nan)])
def test_noise_that_cannot_be_is_refused(field: str, value: float) -> None:
    with pytest.raises(ParameterError, match=field):
        MotionSensors(**{field: value})


def test_a_drive_with_noise_repeats_and_another_seed_is_another_drive() -> None:
    scene, steering = make_scene(speed_mps=20.0, duration_s=0.5), FakeDriver(lambda host, now: (0.0, 0.1 * host.steering_rad))
    first, again, other = (
        simulate(scene, steering, plant="dynamic", motion_sensors="production", seed=seed).history.states.tobytes() for seed in (1, 1, 2)
    )
    assert first == again != other


@given(speed=st.floats(0.0, 50.0), jerk=st.floats(-100.0, 100.0), rate=st.floats(-2.0, 2.0), bend=st.floats(-0.02, 0.02))
@settings(max_examples=20, deadline=None)
@pytest.mark.parametrize("plant", ["kinematic", "dynamic"])
def test_what_our_own_plants_do_is_never_taken_for_a_fault(plant: str, speed: float, jerk: float, rate: float, bend: float) -> None:
    road = Road(curvature=((0.0, bend),), lanes_left=1, lanes_right=1, friction=1.0)
    car = Car(plant, Vehicle(), road, HostState(speed_mps=speed, d_m=5.0, steering_rad=0.3, acceleration_mps2=-5.0))
    for _ in range(60):
        car.step(jerk, rate)


@pytest.mark.parametrize("value", [3, None, KinematicPlant(Vehicle(), Road(), HostState())])
def test_what_builds_no_plant_is_refused(value: object) -> None:
    with pytest.raises(ParameterError, match="plant"):
        simulate(make_scene(), FakeDriver(), plant=value)


def test_an_object_goes_by_the_name_of_its_class_or_function() -> None:
    assert plant_name("dynamic") == "dynamic"
    assert plant_name(KinematicPlant) == "KinematicPlant"
    assert plant_name(partial(KinematicPlant, Vehicle())) == "KinematicPlant"
    assert simulate(make_scene(duration_s=0.2), FakeDriver(), plant=KinematicPlant).plant == "KinematicPlant"


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plants_of_a_user.install(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))


@pytest.mark.usefixtures("installed")
def test_plants_are_found_by_entry_point() -> None:
    assert {"kinematic", "dynamic", *plants_of_a_user.NAMES} <= set(PLANTS.known())
    scene = make_scene(duration_s=0.5)
    steering = FakeDriver(lambda host, now: (0.0, 0.1))
    lazy, eager = simulate(scene, steering, plant="lazy"), simulate(scene, steering)
    assert lazy.plant == "lazy"
    assert 0.0 < lazy.history.inputs[0, 1] == pytest.approx(0.5 * eager.history.inputs[0, 1])
    with pytest.raises(ParameterError, match="did you mean 'lazy'"):
        simulate(scene, FakeDriver(), plant="lazi")


@pytest.mark.usefixtures("installed")
def test_a_plug_in_that_cannot_begin_says_why() -> None:
    with pytest.raises(PlantError, match=r"plant 'unborn' at t = 0.00 s: .*raised KeyError: 'engine'") as caught:
        simulate(make_scene(), FakeDriver(), plant="unborn")
    assert caught.value.drive is None


@pytest.mark.usefixtures("installed")
def test_a_plug_in_that_cannot_be_imported_is_refused_at_the_door() -> None:
    with pytest.raises(ParameterError, match=r"plant = 'broken': is registered as .* cannot be imported: .*has no attribute 'Nobody'"):
        simulate(make_scene(), FakeDriver(), plant="broken")


@pytest.mark.usefixtures("installed")
def test_the_command_draws_what_was_driven_before_it_says_what_went_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "drive.png"
    monkeypatch.setattr("sys.argv", ["mcdas-opt", "simulate", "sandwich-60-40", "--plant", "raises", "--out", str(picture)])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    said = capsys.readouterr()
    assert "plant failed after 0.34 s" in said.out
    assert "plant 'raises' at t = 0.35 s: raised RuntimeError: out of petrol" in said.err
    with Image.open(picture) as drawn:
        assert drawn.getextrema() != ((255, 255),) * len(drawn.getbands())  # not an empty sheet


@pytest.mark.usefixtures("installed")
def test_the_document_of_a_drive_says_that_its_plant_failed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["mcdas-opt", "simulate", "sandwich-60-40", "--plant", "raises", "--json"])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    document = json.loads(capsys.readouterr().out)
    assert document["error"] == "plant 'raises' at t = 0.35 s: raised RuntimeError: out of petrol"
    assert document["duration_s"] == pytest.approx(0.34)


@pytest.mark.parametrize("plant", ["kinematic", "dynamic"])
def test_the_history_keeps_sideslip_yaw_rate_and_the_friction_found(plant: str) -> None:
    scene = make_scene(speed_mps=20.0, duration_s=1.0)
    history = simulate(scene, FakeDriver(lambda host, now: (0.0, 0.05)), plant=plant).history
    assert len(history.sideslip_rad) == len(history.yaw_rate_radps) == len(history.friction) == len(history.states)
    assert bool(np.abs(history.sideslip_rad).max() > 1e-3) is (plant == "dynamic")
    turned = history.states[-1, 2] - history.states[0, 2]
    assert 0.01 * history.yaw_rate_radps[:-1].sum() == pytest.approx(turned, rel=0.02)
    assert set(history.friction) == {scene.road.friction}
    assert np.abs(history.sideslip_estimate_rad - history.sideslip_rad).max() < 0.003
    assert bool((history.sideslip_sd_rad > 0.0).all()) is (plant == "dynamic")
    assert bool(np.isfinite(history.friction_estimate).all()) is (plant == "dynamic")
