"""The shipped scenes with the real planner, driven by the kinematic and by the dynamic vehicle."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.families import load_family
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome, Simulation
from tests.simulation.fake_driver import FakeDriver, braking
from tests.simulation.scene_maker import make_scene


@pytest.mark.parametrize("name", ["curved-road", "low-friction"])
def test_both_cars_come_to_the_same_end(name: str) -> None:
    scene = load_scene(name)
    kinematic, dynamic = (simulate(scene, plant=plant) for plant in ("kinematic", "dynamic"))
    assert (kinematic.plant, dynamic.plant) == ("kinematic", "dynamic")
    assert dynamic.outcome == kinematic.outcome
    assert dynamic.lane_change_completed == kinematic.lane_change_completed
    assert dynamic.unverified_plans == 0
    assert dynamic.max_lateral_acceleration_mps2 <= scene.true_road.friction * 9.80665
    assert dynamic.max_steering_rate_radps <= scene.vehicle.steering_rate_max_radps + 1e-9
    if dynamic.lane_change_completed:
        assert dynamic.max_lateral_acceleration_mps2 != kinematic.max_lateral_acceleration_mps2
        assert np.abs(last(dynamic) - last(kinematic)).max() < 0.3


def last(drive: Simulation) -> np.ndarray:
    return drive.history.states[-1][1:4]


def test_a_drive_with_tyres_repeats() -> None:
    scene = make_scene()
    first, second = (simulate(scene, FakeDriver(), plant="dynamic", seed=3) for _ in range(2))
    assert first.history.states.tobytes() == second.history.states.tobytes()


def believing(scene: Scene, times: float) -> Scene:
    document = scene.model_dump(exclude_none=True)
    document["host"]["assumed_friction"] = times * scene.road.friction
    return Scene.model_validate(document)


@pytest.mark.parametrize("plant", ["kinematic", "dynamic"])
@pytest.mark.parametrize("friction", [0.3, 0.6])
def test_what_brakes_feel_is_told_to_the_planner(plant: str, friction: float) -> None:
    scene = make_scene(speed_mps=25.0, road={"friction": friction}, duration_s=1.5)
    deceived, right = FakeDriver(braking()), FakeDriver(braking())
    simulate(believing(scene, 1.5), deceived, plant=plant)
    simulate(scene, right, plant=plant)
    told = [asked["road"].friction for asked in deceived.asked]
    assert told[0] == pytest.approx(1.5 * friction)
    assert told[-1] == pytest.approx(friction, rel=0.02)
    assert {asked["road"].friction for asked in right.asked} == {friction}


@pytest.mark.parametrize("index", [5, 11, 20])
def test_tyres_on_a_road_believed_better_than_it_is_still_keep_it(index: int) -> None:
    """Sandwiches that were left at the side before the grip monitor."""
    drive = simulate(believing(load_family("sandwich").scene(index, 5), 1.5), plant="dynamic")
    assert drive.outcome is Outcome.SAFE
    assert drive.unverified_plans == 0


def test_an_unknown_plant_is_refused_with_both_names() -> None:
    with pytest.raises(ParameterError) as caught:
        simulate(make_scene(), FakeDriver(), plant="boat")
    assert "kinematic" in str(caught.value)
    assert "dynamic" in str(caught.value)


class Told(FakeDriver):
    """Notes the zero-sideslip points that it is told."""

    def __init__(self) -> None:
        super().__init__()
        self.points: list[float] = []

    takes_zero_sideslip_point = True

    def set_zero_sideslip_point(self, point_m: float) -> None:
        self.points.append(point_m)


def test_a_driver_that_takes_the_zero_sideslip_point_is_told_it_and_gets_the_state_about_it() -> None:
    bend = make_scene(speed_mps=20.0, host={"speed_mps": 20.0}, road={"curvature": [[0.0, 0.003]]}, duration_s=0.5)
    kinematic, dynamic, unaware = Told(), Told(), FakeDriver()
    simulate(bend, kinematic, plant="kinematic")
    simulate(bend, dynamic, plant="dynamic")
    drive = simulate(bend, unaware, plant="dynamic")
    assert set(kinematic.points) == {0.0}
    assert len(dynamic.points) == drive.plans
    assert dynamic.points[0] == pytest.approx(Chassis.of(bend.vehicle).rear_slip_gradient * 20.0**2, rel=1e-6)
    first = dynamic.asked[0]["host"], unaware.asked[0]["host"]
    assert first[0].heading_rad == pytest.approx(first[1].heading_rad + 0.003 * dynamic.points[0], abs=1e-4)


def test_a_planner_that_drove_a_dynamic_vehicle_drives_a_kinematic_one_as_a_fresh_planner() -> None:
    """Nor do its radars' scans before the first plan know of the other car."""
    beside = {"name": "beside", "s_m": 20.0, "d_m": 3.5, "speed_mps": 18.0}
    bend = make_scene(beside, speed_mps=20.0, road={"curvature": [[0.0, 0.004]]}, sensors={"front": "delphi_esr"}, duration_s=0.3)
    used = Planner(method="closed-form-corrected")
    simulate(bend, used, plant="dynamic")
    again, fresh = simulate(bend, used), simulate(bend, Planner(method="closed-form-corrected"))
    assert [cycle.tracks for cycle in again.cycles] == [cycle.tracks for cycle in fresh.cycles]
    assert np.array_equal(again.history.states, fresh.history.states)


@pytest.mark.parametrize(
    ("suite", "scenes", "seed", "index"), [("mid-vehicle", 62, 12, 31), ("sandwich", 40, 7000, 7), ("sandwich", 50, 7601, 38)]
)
def test_plans_are_ones_that_tyres_can_follow(suite: str, scenes: int, seed: int, index: int) -> None:
    """Was lost when plans were made about the rear axle: left the road, hit who is ahead; the last spun on plans with all the grip."""
    drive = simulate(expand(suite, scenes, seed).cases[index].scene, plant="dynamic")
    assert drive.outcome is Outcome.SAFE
    assert drive.unverified_plans == 0


@pytest.mark.parametrize(("suite", "index"), [("sandwich", 192), ("striking-rear", 88), ("curved", 44), ("curved", 116), ("curved", 165)])
def test_who_swerves_at_the_last_moment_is_caught_short_of_the_edge(suite: str, index: int) -> None:
    """Left the road, spun or was hit when wheels were turned as if tyres gave force in proportion to their slip."""
    drive = simulate(expand(suite, index + 1, 9).cases[index].scene, plant="dynamic")
    assert drive.outcome is Outcome.SAFE
    assert drive.unverified_plans == 0


@pytest.mark.parametrize("friction", [0.4, 0.8])
@pytest.mark.parametrize("bend_pm", [-0.008, 0.0, 0.004])
def test_an_urgent_swerve_in_a_bend_keeps_the_road(bend_pm: float, friction: float) -> None:
    speed = min(25.0, math.sqrt(0.5 * friction * 9.80665 / max(abs(bend_pm), 1e-6)))
    standing = {"name": "standing", "s_m": 1.5 * speed, "speed_mps": 0.0}
    chaser = {"name": "chaser", "s_m": -12.0, "speed_mps": speed}
    road = {"friction": friction, "curvature": [[-100.0, bend_pm]]}
    drive = simulate(make_scene(standing, chaser, speed_mps=speed, road=road, duration_s=5.0), plant="dynamic")
    assert drive.outcome is not Outcome.LEFT_ROAD
    assert drive.unverified_plans == 0
    assert drive.max_lateral_acceleration_mps2 > 0.4 * friction * 9.80665


def test_who_has_swerved_in_a_wet_bend_settles_in_the_middle_of_the_lane() -> None:
    """With seven per cent of the grip kept back, instead of half of that, it ran wide and stayed beside the road's edge."""
    front = {
        "name": "front",
        "s_m": 34.0,
        "speed_mps": 20.0,
        "motion": [{"start_s": 0.8, "acceleration_mps2": -4.0, "until_speed_mps": 8.0}],
    }
    rear = {"name": "rear", "s_m": -26.0, "speed_mps": 25.0}
    road = {"lane_width_m": 3.6, "friction": 0.5, "curvature": [[-60.0, 0.003], [40.0, 0.006], [120.0, 0.006], [260.0, 0.002]]}
    scene = make_scene(front, rear, speed_mps=22.0, road=road, duration_s=8.0)
    drive = simulate(scene, plant="dynamic")
    assert drive.outcome is Outcome.SAFE
    assert abs(drive.trajectory.d_m[-1]) > 1.8
    assert np.ptp(drive.trajectory.d_m[-100:]) < 0.1
    assert abs(abs(drive.trajectory.d_m[-1]) - 3.6) < 0.2
