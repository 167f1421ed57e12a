"""The closed loop with planners that do as they are told: outcomes, figures, latency, repeatability."""

from __future__ import annotations

import json
import math
import re
from typing import Any

import numpy as np
import pytest

from mcdas_opt.baselines.corrected import CorrectedMethod
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vocabulary import Mode, Request, Status
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.driver import Driver
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.metrics import lane_changed, settled_lanes
from mcdas_opt.simulation.neighbours import known_bodies
from mcdas_opt.simulation.record import Outcome
from mcdas_opt.verification.judge import judge
from tests.simulation.fake_driver import FAILED, FakeDriver, braking
from tests.simulation.scene_maker import make_scene


def car(name: str, s_m: float, speed_mps: float, **more: Any) -> dict[str, Any]:
    return {"name": name, "s_m": s_m, "speed_mps": speed_mps, **more}


def test_a_quiet_drive_has_the_figures_of_hand_computation() -> None:
    scene = make_scene(car("front", 29.5, 9.1), car("rear", -29.5, 13.1), car("beside", 0.0, 11.1, d_m=3.7), duration_s=2.0)
    drive = simulate(scene, FakeDriver())
    assert drive.outcome is Outcome.SAFE
    assert (drive.collided_with, drive.impact_speed_mps) == (None, 0.0)
    assert drive.duration_s == 2.0
    assert drive.trajectory.s_m[-1] == pytest.approx(22.2)
    assert drive.min_ttc_front_s == pytest.approx((25.0 - 2.0 * 2.0) / 2.0)
    assert drive.min_ttc_rear_s == pytest.approx((25.0 - 2.0 * 2.0) / 2.0)
    assert drive.min_clearance_m == pytest.approx(3.7 - 1.8)
    assert drive.max_jerk_mps3 == drive.max_steering_rate_radps == drive.max_lateral_acceleration_mps2 == 0.0
    assert drive.modes == ((0.0, "hold"),)
    assert (drive.plans, drive.fallbacks, drive.unverified_plans) == (20, 0, 0)
    assert not drive.lane_change_completed


def test_nobody_there_and_nobody_closing_are_null_in_the_document() -> None:
    alone = simulate(make_scene(duration_s=0.5), FakeDriver()).to_dict()
    assert alone["min_clearance_m"] is alone["min_ttc_front_s"] is alone["min_ttc_rear_s"] is None
    opening = simulate(make_scene(car("front", 30.0, 15.0), car("rear", -30.0, 9.0), duration_s=0.5), FakeDriver())
    assert opening.min_ttc_front_s is opening.min_ttc_rear_s is None


def test_the_next_lane_is_no_collision_course() -> None:
    drive = simulate(make_scene(car("slow", 12.0, 5.0, d_m=3.7), duration_s=2.0), FakeDriver())
    assert drive.min_ttc_front_s is None
    assert drive.outcome is Outcome.SAFE


@pytest.mark.parametrize(("d_m", "counts"), [(2.95, True), (5.15, False)])
def test_a_lane_of_its_own_width_counts_as_wide_as_it_is(d_m: float, counts: bool) -> None:
    """Two lanes of 2.2 m beside one of 3.7 m: their middles are 2.2 m apart, both nearest to that of a usual lane 1."""
    lanes = [{"lane": k, "width_m": [[-100.0, 2.2], [400.0, 2.2]]} for k in (1, 2)]
    road = {"lanes_left": 2, "lanes_right": 0, "lane": lanes}
    scene = make_scene(car("slow", 25.0, 10.0, d_m=d_m), road=road, host={"d_m": 2.95, "speed_mps": 15.0}, duration_s=1.0)
    drive = simulate(scene, FakeDriver())
    assert (drive.min_ttc_front_s is not None) == counts


def test_a_collision_ends_the_drive_with_its_relative_speed() -> None:
    scene = make_scene(car("wall", 20.0, 0.0), duration_s=5.0)
    drive = simulate(scene, FakeDriver())
    assert (drive.outcome, drive.collided_with) == (Outcome.COLLISION, "wall")
    assert drive.impact_speed_mps == pytest.approx(11.1)
    assert drive.duration_s == pytest.approx(15.5 / 11.1, abs=0.0101)
    assert drive.trajectory.t_s[-1] == drive.duration_s
    assert drive.min_clearance_m == 0.0
    assert drive.min_ttc_front_s < 0.02


def test_braking_reduces_the_impact_as_energy_says() -> None:
    scene = make_scene(car("wall", 12.0, 0.0), duration_s=5.0)
    drive = simulate(scene, FakeDriver(braking()))
    # 0.2 s of rising brakes at 40 m/s^3, then 8 m/s^2 over what is left of the 7.5 m
    ramp_s, ramp_v = 11.1 * 0.2 - 40.0 * 0.2**3 / 6.0, 11.1 - 40.0 * 0.2**2 / 2.0
    assert drive.impact_speed_mps == pytest.approx(math.sqrt(ramp_v**2 - 16.0 * (7.5 - ramp_s)), abs=0.08)


def test_hit_from_behind_by_a_faster_car() -> None:
    drive = simulate(make_scene(car("rear", -20.0, 16.7), duration_s=5.0), FakeDriver())
    assert (drive.collided_with, drive.impact_speed_mps) == ("rear", pytest.approx(5.6))


def test_steering_off_the_road_ends_there() -> None:
    scene = make_scene(duration_s=8.0)
    drive = simulate(scene, FakeDriver(lambda host, now: (0.0, 0.1 if now < 0.3 else 0.0)))
    assert drive.outcome is Outcome.LEFT_ROAD
    x = drive.trajectory
    d, psi = float(x.d_m[-1]), float(x.heading_rad[-1])
    corner = d + 2.25 * math.sin(psi) + 0.9 * math.cos(psi)
    assert 5.55 + 0.02 < corner < 5.55 + 0.2


def test_on_a_curved_road_the_edge_curves_too() -> None:
    road = {"curvature": [[0.0, 0.0], [10.0, 0.01]], "lanes_left": 0, "lanes_right": 0}
    drive = simulate(make_scene(duration_s=8.0, road=road), FakeDriver())  # straight on where the road turns left
    assert drive.outcome is Outcome.LEFT_ROAD
    d, psi = float(drive.trajectory.d_m[-1]), float(drive.trajectory.heading_rad[-1])
    assert psi < 0.0
    assert d - 0.9 * math.cos(psi) + 2.25 * math.sin(psi) == pytest.approx(-1.85 - 0.02, abs=0.05)


def test_the_end_of_the_road_is_an_edge() -> None:
    drive = simulate(make_scene(duration_s=5.0, road={"road_end_s_m": 20.0}), FakeDriver())
    assert drive.outcome is Outcome.LEFT_ROAD
    assert drive.trajectory.s_m[-1] + 2.25 == pytest.approx(20.0, abs=0.14)


def test_the_drive_passes_the_judge_when_nothing_saturates() -> None:
    scene = make_scene(car("front", 40.0, 11.1), duration_s=4.0, road={"curvature": [[0.0, 0.0], [20.0, 0.002]]})

    def weaving(host: Any, now: float) -> tuple[float, float]:
        return 3.0 * math.sin(2.0 * now), 0.03 * math.cos(1.7 * now)

    drive = simulate(scene, FakeDriver(weaving))
    verdict = judge(
        drive.trajectory, scene.host_state, scene.vehicle, scene.true_road, Prediction(name="scene", bodies=known_bodies(scene))
    )
    assert verdict.passed, verdict.reason
    assert len(drive.trajectory) < 90  # inputs that do not change are one sample a cycle


def test_a_lane_change_is_complete_when_settled() -> None:
    def swerve(side: float, until: float) -> Any:
        def inputs(host: Any, now: float) -> tuple[float, float]:
            wanted = 3.7 * side - host.d_m
            steering = 0.02 * np.clip(wanted, -1.5, 1.5) - 0.35 * host.heading_rad if now < until else -0.5 * host.heading_rad
            return 0.0, float(np.clip(steering - host.steering_rad, -0.04, 0.04)) / 0.1

        return inputs

    for side in (1.0, -1.0):
        drive = simulate(make_scene(duration_s=8.0), FakeDriver(swerve(side, 8.0)))
        assert drive.lane_change_completed
        assert drive.trajectory.d_m[-1] * side > 3.4
        assert drive.lane_changes == 1
    begun = simulate(make_scene(duration_s=1.0), FakeDriver(swerve(1.0, 8.0)))
    assert (begun.lane_change_completed, begun.lane_changes) == (False, 0)


def test_out_and_back_are_two_lane_changes_that_end_where_they_began() -> None:
    """Who overtakes has changed lanes twice, and ends in the lane that it began in."""
    d = np.concatenate([np.full(30, 0.0), np.linspace(0.0, 3.7, 200), np.full(30, 3.7), np.linspace(3.7, 0.0, 200), np.full(30, 0.0)])
    states = np.zeros((d.size, 6))
    states[:, 1], states[:, 2] = d, np.gradient(d)
    road = make_scene(duration_s=1.0).true_road
    assert settled_lanes(states, road) == [0, 1, 0]
    assert not lane_changed(states, road)


def test_plans_are_counted_by_status_and_verdict() -> None:
    driver = FakeDriver(
        verdicts=lambda now: FAILED if now in (0.2, 0.3, 0.4) else FakeDriver().step((), _host(), 0.0).verdict,
        statuses=lambda now: {0.3: Status.FALLBACK, 0.4: Status.UNAVOIDABLE, 0.5: Status.FALLBACK}.get(now, Status.PLANNED),
        modes=lambda now: Mode.BRAKE if 0.3 <= now < 0.6 else Mode.CRUISE,
    )
    drive = simulate(make_scene(duration_s=1.0), driver)
    assert (drive.plans, drive.fallbacks, drive.unavoidable, drive.unverified_plans) == (10, 2, 1, 2)
    assert drive.modes == ((0.0, "cruise"), (0.3, "brake"), (0.6, "cruise"))


def _host() -> Any:
    return make_scene().host_state


def test_the_planner_is_asked_every_cycle_with_the_cars_state_and_the_assumed_road() -> None:
    scene = make_scene(duration_s=0.35, host={"assumed_friction": 0.5, "desired_speed_mps": 20.0}, road={"friction": 0.8})
    driver = FakeDriver(lambda host, now: (1.0, 0.0))
    simulate(scene, driver)
    assert [now for now, _ in driver.heard] == [0.0, 0.1, 0.2, 0.3]
    assert [asked["host"].acceleration_mps2 for asked in driver.asked] == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert {(a["road"].friction, a["desired_speed_mps"], a["request"]) for a in driver.asked} == {(0.5, 20.0, Request.DRIVE)}
    driver = FakeDriver()
    simulate(make_scene(speed_mps=0.0, duration_s=0.2, host={"request": "park"}), driver)
    assert driver.asked[0]["request"] is Request.PARK


@pytest.mark.parametrize("latency", [0.0, 0.15, 0.3])
def test_scans_reach_the_planner_late_with_their_own_times(latency: float) -> None:
    driver = FakeDriver()
    sensors = {"latency_s": latency, "warmup_s": 0.5}
    simulate(make_scene(car("front", 30.0, 9.0), duration_s=0.5, sensors=sensors), driver)
    stamps = [sorted({scan.t_s for scan in scans}) for _, scans in driver.heard]
    assert stamps[0][0] == pytest.approx(-0.5)
    for (now, scans), times in zip(driver.heard, stamps, strict=True):
        assert times[-1] == pytest.approx(math.floor((now - latency) / 0.05 + 1e-6) * 0.05)
        for body in (body for scan in scans for body in scan.bodies):
            t = next(scan.t_s for scan in scans if body in scan.bodies)
            assert body.s_m == pytest.approx(30.0 + 9.0 * t)
    flat = [t for times in stamps for t in times]
    assert flat == sorted(set(flat))  # each once, in order


class ListeningTracker:
    def __init__(self) -> None:
        self.calls: list[tuple[float, float, float]] = []

    def update(self, scans: Any, host: Any, road: Any, now: float) -> None:
        self.calls.extend((scan.t_s, host.s_m, now) for scan in scans)


def test_a_tracker_gets_old_scans_with_the_pose_of_their_time() -> None:
    driver = FakeDriver()
    driver.tracker = ListeningTracker()
    simulate(make_scene(duration_s=0.5, sensors={"latency_s": 0.12}), driver)
    assert not any(scans for _, scans in driver.heard)
    for t, s, arrival in driver.tracker.calls:
        assert s == pytest.approx(11.1 * t, abs=1e-9)
        assert arrival == pytest.approx(t + 0.12)
    assert max(t for t, *_ in driver.tracker.calls) == pytest.approx(0.25)


def documents(seed: int | None = None, **parts: Any) -> str:
    follower = car("rear", -30.0, 15.0, behaviour="idm")
    sensors = {"front": "delphi_esr", "rear": "delphi_esr"}
    drive = simulate(make_scene(car("front", 30.0, 9.0), follower, duration_s=1.5, sensors=sensors), NoisyDriver(), seed=seed)
    document = drive.to_dict()
    del document["cycle_ms"]
    return json.dumps(document, allow_nan=False)


class NoisyDriver(FakeDriver):
    """Does what the last radar point says, so that noise reaches the drive."""

    def step(self, measurements: Any, host: Any, now: float, **asked: Any) -> Any:
        points = [p.range_m for scan in measurements for p in scan.radar]
        self.inputs = lambda host, now: (0.01 * points[-1] if points else 0.0, 0.0)
        return super().step(measurements, host, now, **asked)


def test_same_seed_same_bytes_another_seed_another_drive() -> None:
    assert documents() == documents(seed=1)
    assert documents(seed=2) == documents(seed=2)
    assert documents(seed=2) != documents(seed=1)


def test_the_document_has_the_contracts_keys_and_no_nan() -> None:
    document = json.loads(documents())
    contract = {
        "outcome", "collided_with", "impact_speed_mps", "min_clearance_m", "min_ttc_front_s", "min_ttc_rear_s",
        "max_lateral_acceleration_mps2", "max_jerk_mps3", "max_steering_rate_radps", "lane_change_completed", "modes", "plans",
        "fallbacks", "unverified_plans", "seed", "trajectory", "schema_version",
    }  # fmt: skip
    assert contract <= document.keys()
    keys = {"t_s", "s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad", "steering_rate_radps", "jerk_mps3"}
    assert document["trajectory"].keys() == keys
    assert len({len(column) for column in document["trajectory"].values()}) == 1
    assert len(document["neighbours"][0]["s_m"]) == len(document["trajectory"]["t_s"])
    assert np.diff(document["trajectory"]["t_s"]).max() <= 0.1 + 1e-9


def test_low_friction_is_the_plants_not_the_planners() -> None:
    scene = make_scene(duration_s=3.0, speed_mps=15.0, road={"friction": 0.3}, host={"assumed_friction": 0.9})
    drive = simulate(scene, FakeDriver(braking()))
    assert drive.trajectory.acceleration_mps2.min() == pytest.approx(-0.3 * 9.80665)


def test_a_planner_is_asked_as_often_as_its_settings_say() -> None:
    """It was asked ten times a second, whatever they said."""
    scene = make_scene(duration_s=1.0)
    quick = Planner(scene.vehicle, "closed-form-corrected", settings=Settings(cycle_s=0.05))
    assert simulate(scene, quick).plans == 20
    assert simulate(scene, quick, settings=Settings(cycle_s=0.2)).plans == 5
    assert simulate(scene, FakeDriver()).plans == 10


def test_what_is_not_known_is_refused_by_name() -> None:
    with pytest.raises(ParameterError, match="did you mean 'dynamic'"):
        simulate(make_scene(), FakeDriver(), plant="dynamo")
    with pytest.raises(ParameterError, match="cycle_s"):
        simulate(make_scene(), FakeDriver(), settings=Settings(cycle_s=0.033))


def test_who_plans_with_another_car_than_the_scenes_is_refused() -> None:
    scene = make_scene(host={"vehicle": "bmw_320i"}, duration_s=0.2)
    for planner in (Planner(method="closed-form"), CorrectedMethod(load_vehicle("sedan"))):
        with pytest.raises(ParameterError, match=re.escape("planner.vehicle = 'sedan': is not the car of this scene, 'bmw_320i'")):
            simulate(scene, planner)
    assert simulate(scene, Planner(vehicle="bmw_320i", method="closed-form")).plans == 2


class NoStep(Driver):
    """Forgot the one thing that a driver has to have."""


class ShortStep(Driver):
    def step(self, scans: Any) -> Any:  # type: ignore[override]
        return None


@pytest.mark.parametrize(
    ("driver", "said"),
    [
        (NoStep(), r"NoStep.step\(\) = None: must be a Plan"),
        (ShortStep(), r"ShortStep.step = .*: must take \(measurements, host, now, \*, road, desired_speed_mps, request\)"),
    ],
)
def test_a_driver_that_cannot_be_asked_or_gives_no_plan_is_named(driver: Driver, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        simulate(make_scene(duration_s=0.2), driver)


@pytest.mark.parametrize("plant", ["kinematic", "dynamic"])
def test_a_method_drives_with_the_settings_that_it_was_built_with(plant: str) -> None:
    scene = make_scene(duration_s=0.4)
    own = Settings(cycle_s=0.05, speed_limit_excess=0.2)
    drive = simulate(scene, MpcMethod(scene.vehicle, own), plant=plant)
    assert (drive.plans, drive.fallbacks, drive.unavoidable) == (8, 0, 0)
    with pytest.raises(ParameterError, match="those of the method"):
        simulate(scene, MpcMethod(scene.vehicle, own), plant=plant, settings=Settings())
