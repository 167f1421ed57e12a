"""The grip monitor: it learns what the road gives once tyres or brakes work hard, and not before."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.actuation.grip_monitor import INFORMED_SD, RECOVERY_PER_S, RECOVERY_S, GripMonitor, within_grip
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.host_motion import MotionMeasurement, SlipEstimate
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.simulation.motion_sensors import MeasuredHost, MotionSensors
from mcdas_opt.simulation.plant import make_plant

CARS = [load_vehicle(name) for name in ("sedan", "bmw_320i", "lincoln_mkz")]


def swerve(
    monitor: GripMonitor, car: Vehicle, friction: float, speed: float, rate: float, turn_s: float, braking: float = 0.0, hold_s: float = 0.0
) -> None:
    """Turns in at `rate` for `turn_s` and holds it, back for twice as long, and in again: to the left first where `rate` is positive."""
    plant = make_plant("dynamic", car, Road(friction=friction), HostState(speed_mps=speed, acceleration_mps2=-braking))
    host = MeasuredHost(monitor.vehicle, plant.state, MotionSensors(), friction=monitor.believed, seed=1)
    turn = round(turn_s / 0.01)
    for asked in [rate] * turn + [0.0] * round(hold_s / 0.01) + [-rate] * (2 * turn) + [rate] * turn:
        monitor.note(host.state, -braking, host.slip, host.measured_if_slips)
        applied = plant.step(0.0, asked)
        host.look(plant.state, applied)


def enough(car: Vehicle, friction: float, speed: float, share: float) -> float:
    """The steering angle whose path asks for a share of the grip, by the no-slip bicycle."""
    return math.atan(share * friction * GRAVITY_MPS2 * car.wheelbase_m / speed**2)


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
@pytest.mark.parametrize(("friction", "speed"), [(0.25, 20.0), (0.5, 30.0), (1.0, 22.0)])
@pytest.mark.parametrize(("braking", "left"), [(0.0, True), (0.4, False)])
def test_who_asks_for_too_much_feels_what_there_is(car: Vehicle, friction: float, speed: float, braking: float, left: bool) -> None:
    """Within a second; at most two tenths less of it."""
    monitor = GripMonitor(vehicle=car, believed=1.5 * friction)
    angle, rate = enough(car, friction, speed, 1.5) + 0.06, 0.3 if left else -0.3
    swerve(monitor, car, friction, speed, rate, angle / 0.3, braking * friction * GRAVITY_MPS2, hold_s=0.6)
    assert 0.8 * friction < monitor.friction < 1.02 * friction


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
@given(friction=st.floats(0.2, 1.0), speed=st.floats(6.0, 35.0), share=st.floats(0.1, 0.97), factor=st.floats(0.5, 1.0))
@settings(max_examples=6, deadline=None)
def test_a_belief_that_is_right_or_too_low_stands(car: Vehicle, friction: float, speed: float, share: float, factor: float) -> None:
    monitor = GripMonitor(vehicle=car, believed=factor * friction)
    swerve(monitor, car, friction, speed, 0.2, enough(car, friction, speed, share) / 0.2)
    assert monitor.friction == factor * friction


@pytest.mark.parametrize("factor", [0.85, 1.15])
@pytest.mark.parametrize("friction", [0.3, 0.9])
def test_tyres_that_are_not_the_ones_known_cost_little(factor: float, friction: float) -> None:
    known, c = CARS[0], Chassis.of(CARS[0])
    has = replace(
        known,
        cornering_stiffness_front_nprad=factor * c.cornering_stiffness_front_nprad,
        cornering_stiffness_rear_nprad=factor * c.cornering_stiffness_rear_nprad,
    )
    for speed in (12.0, 20.0, 30.0):
        right, wrong = (GripMonitor(vehicle=known, believed=times * friction) for times in (1.0, 1.5))
        swerve(right, has, friction, speed, 0.2, enough(known, friction, speed, 0.97) / 0.2)
        swerve(wrong, has, friction, speed, 0.3, (enough(known, friction, speed, 2.0) + 0.06) / 0.3)
        assert right.friction > 0.8 * friction
        assert 0.8 * friction < wrong.friction < 1.25 * friction


@pytest.mark.parametrize("plant", ["kinematic", "dynamic"])
@given(friction=st.floats(0.1, 0.7), speed=st.floats(10.0, 35.0))
@settings(max_examples=15, deadline=None)
def test_brakes_that_give_no_more_are_felt_on_both_plants(plant: str, friction: float, speed: float) -> None:
    car = make_plant(plant, CARS[0], Road(friction=friction), HostState(speed_mps=speed))
    deceived, right = (GripMonitor(vehicle=CARS[0], believed=times * friction) for times in (1.5, 1.0))
    for _ in range(60):
        for monitor in (deceived, right):
            monitor.note(car.state, -0.97 * monitor.believed * GRAVITY_MPS2)
        car.step(-30.0, 0.0)
    assert deceived.friction == pytest.approx(friction, rel=0.02)
    assert right.friction == friction


def test_brakes_at_their_own_end_say_nothing_of_the_road() -> None:
    car, monitor = (
        make_plant("kinematic", CARS[0], Road(friction=1.2), HostState(speed_mps=30.0)),
        GripMonitor(vehicle=CARS[0], believed=1.2),
    )
    for _ in range(60):
        monitor.note(car.state, -11.0)
        car.step(-40.0, 0.0)
    assert car.state.acceleration_mps2 == pytest.approx(CARS[0].acceleration_min_mps2)
    assert monitor.estimate is None


def test_crawling_and_standing_teach_nothing() -> None:
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    for speed in (0.0, 2.0, 4.9):
        for _ in range(20):
            monitor.note(SlidingState(speed_mps=speed, acceleration_mps2=-0.5, steering_rad=0.5, yaw_rate_radps=0.01), -5.0)
    assert monitor.estimate is None


def test_left_and_right_are_felt_alike() -> None:
    estimates = []
    for rate in (0.3, -0.3):
        monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
        swerve(monitor, CARS[0], 0.5, 20.0, rate, 0.3, hold_s=0.5)
        estimates.append(monitor.estimate)
    assert estimates[0] is not None
    assert estimates[0] == pytest.approx(estimates[1], rel=1e-9)


@given(speed=st.floats(0.0, 40.0), steering=st.floats(-0.5, 0.5), braking=st.floats(0.0, 6.0), friction=st.floats(0.2, 1.0))
def test_within_grip_bends_no_more_than_there_is(speed: float, steering: float, braking: float, friction: float) -> None:
    host, road = HostState(speed_mps=speed, steering_rad=steering, acceleration_mps2=-braking), Road(friction=friction)
    held = within_grip(host, road, 2.7)
    most = math.sqrt(max((friction * GRAVITY_MPS2) ** 2 - braking**2, 0.0))
    assert speed**2 * abs(math.tan(held.steering_rad)) / 2.7 <= most + 1e-9
    assert held.steering_rad * steering >= 0.0
    assert replace(held, steering_rad=steering) == host
    if speed**2 * abs(math.tan(steering)) / 2.7 < 0.96 * math.sqrt(max((0.97 * friction * GRAVITY_MPS2) ** 2 - braking**2, 0.0)):
        assert held is host


def noted(monitor: GripMonitor, times: int, *, lateral_mps2: float, felt: float = 0.9, sd: float = 0.15, speed: float = 20.0) -> None:
    """As many equal states: so much lateral acceleration, and what the observer has of the friction."""
    yaw_rate = lateral_mps2 / speed
    state = SlidingState(speed_mps=speed, yaw_rate_radps=yaw_rate)
    slip = SlipEstimate(lateral_speed_mps=0.0, lateral_speed_sd_mps=0.1, yaw_rate_radps=yaw_rate, friction=felt, friction_sd=sd)
    measured = MotionMeasurement(
        speed_mps=speed, yaw_rate_radps=yaw_rate, forward_mps2=0.0, lateral_mps2=lateral_mps2, steering_rad=0.0, demand_mps2=0.0
    )
    for _ in range(times):
        monitor.note(state, 0.0, slip, measured)


SD = 0.02  # of an observer that knows


def test_a_single_low_sample_is_not_believed() -> None:
    """Force lags behind slip where a body rolls: for a moment tyres that slip seem to give nothing."""
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    for felt in (0.3, 0.22, 0.15, 0.09, 0.04, 0.02):
        noted(monitor, 2, lateral_mps2=0.5, felt=felt, sd=0.001)
    assert monitor.friction == 0.9


def test_what_the_observer_does_not_know_is_not_believed() -> None:
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    noted(monitor, 100, lateral_mps2=2.0, felt=0.3, sd=1.01 * INFORMED_SD)
    assert monitor.friction == 0.9


@given(believed=st.floats(0.2, 1.2), felt=st.floats(0.2, 1.2), sd=st.floats(0.01, 0.07))
def test_plans_use_a_bound_where_the_belief_is_refuted_and_the_belief_where_it_is_not(believed: float, felt: float, sd: float) -> None:
    monitor = GripMonitor(vehicle=CARS[0], believed=believed)
    noted(monitor, 60, lateral_mps2=0.0, felt=felt, sd=sd)
    if felt + sd >= believed:
        assert monitor.friction == believed
    else:
        assert monitor.friction == pytest.approx(felt - sd)


def test_samples_that_agree_are_believed_but_never_less_than_tyres_gave_within_the_last_second() -> None:
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    noted(monitor, 10, lateral_mps2=5.0)  # 5 m/s^2 can be given
    noted(monitor, 30, lateral_mps2=1.0, felt=0.12, sd=SD)
    assert monitor.friction == pytest.approx(5.0 / GRAVITY_MPS2, rel=0.02)
    noted(monitor, 120, lateral_mps2=1.0, felt=0.12, sd=SD)
    assert monitor.friction == pytest.approx(1.0 / GRAVITY_MPS2, rel=0.05)


def test_what_nobody_confirms_is_forgotten_slowly() -> None:
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    noted(monitor, 60, lateral_mps2=2.0, felt=0.2, sd=SD)
    felt = monitor.friction
    assert felt == pytest.approx(2.0 / GRAVITY_MPS2, rel=0.1)
    noted(monitor, round(0.95 * RECOVERY_S / monitor.step_s), lateral_mps2=0.1)
    assert monitor.friction == pytest.approx(felt)
    after = []
    for _ in range(20):
        noted(monitor, 100, lateral_mps2=0.1)
        after.append(monitor.friction)
    steps = [b - a for a, b in pairwise(after)]
    assert max(steps[:5]) <= 1.01 * RECOVERY_PER_S
    assert after[-1] == 0.9


def test_what_tyres_give_raises_an_estimate_that_was_too_low() -> None:
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    noted(monitor, 60, lateral_mps2=1.0, felt=0.11, sd=SD)
    assert monitor.friction < 0.15
    noted(monitor, 10, lateral_mps2=4.0)
    assert monitor.friction == pytest.approx(4.0 / GRAVITY_MPS2, rel=0.02)
