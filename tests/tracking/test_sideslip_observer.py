"""Sideslip and friction that nobody measures, against the truth of three plants."""

from __future__ import annotations

import importlib.util
import math

import numpy as np
import pytest

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.simulation.motion_sensors import MeasuredHost, MotionSensors, motion_sensors
from mcdas_opt.simulation.plant import make_plant
from mcdas_opt.tracking.sideslip_observer import UNKNOWN_SD

BMW = load_vehicle("bmw_320i")
theirs = pytest.mark.skipif(importlib.util.find_spec("vehiclemodels") is None, reason="needs the extra vehicle-models")
DYNAMIC, STD, MULTI_BODY = "dynamic", pytest.param("std", marks=theirs), pytest.param("multi-body", marks=theirs)


def woven(
    plant: str, *, friction: float, share: float, speed: float = 25.0, believed: float = 1.0, sensors: str = "ideal", times_s: float = 2.5
) -> np.ndarray:
    """Left and right by one sine of steering a 1.5 s, whose path asks for a share of the grip, with 0.05 rad more for the slip of the tyres
    where that is more than there is. Rows: sideslip, the observer's and its sd
    [rad], the observer's friction over the true one, its sd."""
    car = make_plant(plant, BMW, Road(friction=friction), HostState(speed_mps=speed))
    host = MeasuredHost(BMW, car.state, motion_sensors(sensors), friction=believed * friction, seed=3)
    most, rows = math.atan(share * friction * GRAVITY_MPS2 * BMW.wheelbase_m / speed**2), []
    most += 0.05 if share > 1.0 else 0.0
    for k in range(round(times_s / 0.01)):
        wheels = most * math.sin(2.0 * math.pi * 0.01 * k / 1.5)
        host.look(car.state, car.step(0.0, (wheels - car.state.steering_rad) / 0.02))
        true, told = car.state, host.slip
        assert isinstance(true, SlidingState)
        assert told is not None
        v = true.speed_mps
        rows.append((true.lateral_speed_mps / v, told.lateral_speed_mps / v, told.lateral_speed_sd_mps / v))
        rows[-1] += (told.friction / friction, told.friction_sd)
    return np.array(rows)


@pytest.mark.parametrize("plant", [DYNAMIC, STD, MULTI_BODY])
@pytest.mark.parametrize(("friction", "share"), [(0.9, 0.8), (0.3, 0.8), (0.3, 1.3)])
@pytest.mark.parametrize("sensors", ["ideal", "production"])
def test_sideslip_is_known_to_a_hundredth_and_to_its_own_uncertainty(plant: str, friction: float, share: float, sensors: str) -> None:
    true, told, sd, _, _ = woven(plant, friction=friction, share=share, believed=1.3, sensors=sensors).T
    assert np.abs(true).max() > 0.003
    assert np.abs(told - true).max() < 0.012
    assert (np.abs(told - true) < 3.0 * sd).mean() > 0.9


@pytest.mark.parametrize("plant", [DYNAMIC, MULTI_BODY])
@pytest.mark.parametrize("friction", [0.3, 0.9])
def test_friction_shows_only_where_tyres_work_hard(plant: str, friction: float) -> None:
    gentle, hard = (woven(plant, friction=friction, share=share, believed=1.5, sensors="production").T for share in (0.4, 1.4))
    assert gentle[4].min() > 0.8 * UNKNOWN_SD
    assert hard[4].min() < 0.5 * UNKNOWN_SD
    sure = hard[4] < 0.4 * UNKNOWN_SD
    assert 0.7 < np.median(hard[3, sure]) < 1.15


def test_a_car_that_hardly_moves_does_not_slip() -> None:
    car = make_plant("dynamic", BMW, Road(), HostState(speed_mps=2.0, steering_rad=0.2))
    host = MeasuredHost(BMW, car.state, MotionSensors(), friction=0.9, seed=1)
    for _ in range(20):
        host.look(car.state, car.step(0.0, 0.1))
    assert isinstance(host.state, SlidingState)
    assert host.state.lateral_speed_mps == 0.0
    assert host.state.yaw_rate_radps == pytest.approx(car.state.turning(BMW.wheelbase_m)[1], rel=0.1)


def test_it_goes_through_standstill_and_on() -> None:
    car = make_plant("dynamic", BMW, Road(friction=0.9), HostState(speed_mps=8.0, acceleration_mps2=-6.0))
    host = MeasuredHost(BMW, car.state, motion_sensors("production"), friction=0.9, seed=1)
    for k in range(500):
        host.look(car.state, car.step(-10.0 if k < 150 else 10.0, 0.1 if k % 100 < 50 else -0.1))
        assert host.slip is not None
        assert math.isfinite(host.slip.lateral_speed_mps)
    assert car.state.speed_mps > 1.0
    assert host.state.speed_mps == pytest.approx(car.state.speed_mps, abs=0.2)


def test_a_car_without_slip_and_with_ideal_sensors_knows_its_own_state() -> None:
    state = HostState(speed_mps=12.0, steering_rad=0.02)
    assert MeasuredHost(BMW, state, MotionSensors(), friction=0.9, seed=1).state is state
    told = MeasuredHost(BMW, state, motion_sensors("production"), friction=0.9, seed=1).state
    assert told.speed_mps != state.speed_mps
    assert told.s_m == state.s_m
