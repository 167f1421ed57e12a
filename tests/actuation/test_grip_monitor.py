"""The grip monitor: it learns what the road gives once tyres or brakes work hard, and not before."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.actuation.grip_monitor import RECOVERY_PER_S, RECOVERY_S, GripMonitor, within_grip
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.simulation.plant import make_plant

CARS = [load_vehicle(name) for name in ("sedan", "bmw_320i", "lincoln_mkz")]


def swerve(monitor: GripMonitor, car: Vehicle, friction: float, speed: float, rate: float, turn_s: float, braking: float = 0.0) -> None:
    """Turns in at `rate` for `turn_s`, back for twice as long, and in again: to the left first where `rate` is positive."""
    plant = make_plant("dynamic", car, Road(friction=friction), HostState(speed_mps=speed, acceleration_mps2=-braking))
    turn = round(turn_s / 0.01)
    for k in range(4 * turn):
        monitor.note(plant.state, -braking)
        plant.step(0.0, -rate if turn <= k < 3 * turn else rate)


def enough(car: Vehicle, friction: float, speed: float, share: float) -> float:
    """The steering angle whose path asks for a share of the grip, by the no-slip bicycle."""
    return math.atan(share * friction * GRAVITY_MPS2 * car.wheelbase_m / speed**2)


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
@given(
    friction=st.floats(0.2, 1.0),
    speed=st.floats(12.0, 35.0),
    too_much=st.floats(1.3, 2.0),
    left=st.booleans(),
    braking=st.floats(0.0, 0.5),
)
@settings(max_examples=15, deadline=None)
def test_who_asks_for_too_much_feels_what_there_is(
    car: Vehicle, friction: float, speed: float, too_much: float, left: bool, braking: float
) -> None:
    monitor = GripMonitor(vehicle=car, believed=1.5 * friction)
    angle = enough(car, friction, speed, too_much) + 0.06
    swerve(monitor, car, friction, speed, math.copysign(0.3, 1.0 if left else -1.0), angle / 0.3, braking * friction * GRAVITY_MPS2)
    assert monitor.friction == pytest.approx(friction, rel=0.05)


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
@given(friction=st.floats(0.2, 1.0), speed=st.floats(6.0, 35.0), share=st.floats(0.1, 0.97), factor=st.floats(0.5, 1.0))
@settings(max_examples=15, deadline=None)
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
        swerve(monitor, CARS[0], 0.5, 20.0, rate, 0.3)
        estimates.append(monitor.estimate)
    assert estimates[0] is not None
    assert estimates[0] == estimates[1]


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


def noted(monitor: GripMonitor, times: int, *, lateral_mps2: float, slip_rad: float, speed: float = 20.0) -> None:
    """As many equal states: so much lateral acceleration, the rear axle slipping by so much, the front one by as much."""
    yaw_rate = lateral_mps2 / speed
    for _ in range(times):
        monitor.note(
            SlidingState(
                speed_mps=speed,
                lateral_speed_mps=-speed * math.tan(slip_rad),
                yaw_rate_radps=yaw_rate,
                steering_rad=math.atan2(-speed * math.tan(slip_rad) + CARS[0].wheelbase_m * yaw_rate, speed) + slip_rad,
            )
        )


SLIPPING_RAD = 0.08  # of tyres that would give 0.9 g and more


def test_a_single_low_sample_is_not_believed() -> None:
    """Force lags behind slip where a body rolls: for a moment tyres that slip seem to give nothing."""
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    for lateral in (3.0, 2.2, 1.5, 0.9, 0.4, 0.2):
        noted(monitor, 2, lateral_mps2=lateral, slip_rad=SLIPPING_RAD)
    assert monitor.friction == 0.9


def test_samples_that_agree_are_believed_but_never_less_than_tyres_gave_within_the_last_second() -> None:
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    noted(monitor, 10, lateral_mps2=5.0, slip_rad=0.02)  # little slip, much force: 5 m/s^2 can be given
    noted(monitor, 30, lateral_mps2=1.0, slip_rad=SLIPPING_RAD)
    assert monitor.friction == pytest.approx(5.0 / GRAVITY_MPS2, rel=0.02)
    noted(monitor, 120, lateral_mps2=1.0, slip_rad=SLIPPING_RAD)
    assert monitor.friction == pytest.approx(1.0 / GRAVITY_MPS2, rel=0.05)


def test_what_nobody_confirms_is_forgotten_slowly() -> None:
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    noted(monitor, 60, lateral_mps2=2.0, slip_rad=SLIPPING_RAD)
    felt = monitor.friction
    assert felt == pytest.approx(2.0 / GRAVITY_MPS2, rel=0.1)
    noted(monitor, round(0.95 * RECOVERY_S / monitor.step_s), lateral_mps2=0.1, slip_rad=0.0)
    assert monitor.friction == pytest.approx(felt)
    after = []
    for _ in range(20):
        noted(monitor, 100, lateral_mps2=0.1, slip_rad=0.0)
        after.append(monitor.friction)
    steps = [b - a for a, b in pairwise(after)]
    assert max(steps[:5]) <= 1.01 * RECOVERY_PER_S
    assert after[-1] == 0.9


def test_what_tyres_give_raises_an_estimate_that_was_too_low() -> None:
    monitor = GripMonitor(vehicle=CARS[0], believed=0.9)
    noted(monitor, 60, lateral_mps2=1.0, slip_rad=SLIPPING_RAD)
    assert monitor.friction < 0.15
    noted(monitor, 10, lateral_mps2=4.0, slip_rad=0.02)
    assert monitor.friction == pytest.approx(4.0 / GRAVITY_MPS2, rel=0.02)
