"""The parking regulators: stable in both gears, mirror images of each other, silent on the path."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.parking import ParkingLimits, ParkingTrajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.rollout import roll_out
from mcdas_opt.errors import ParameterError
from mcdas_opt.parking.closed_loop.plant import ParkingPlant
from mcdas_opt.parking.closed_loop.sensors import PoseFilter
from mcdas_opt.parking.closed_loop.tracker import ParkingActuators, ParkingTracker, design_parking_tracker

CAR, LIMITS = Vehicle(), ParkingLimits()
USUAL = design_parking_tracker(ParkingActuators())


def cruise(speed: float, steering: float, seconds: float = 8.0) -> ParkingTrajectory:
    """From rest up to `speed`, on, and to rest, at one steering angle."""
    ramp = abs(speed) / 1.0
    t, v = np.array([0.0, ramp, seconds - ramp, seconds]), np.array([0.0, speed, speed, 0.0])
    fine = np.arange(0.0, seconds + 0.01, 0.05)
    v_fine, delta = np.interp(fine, t, v), np.full(fine.size, steering)
    _, poses, at = roll_out(np.zeros(3), fine, v_fine, delta, CAR.wheelbase_m, 0.005)
    return ParkingTrajectory.from_controls(fine, poses[at], v_fine, delta)


def followed(path: ParkingTrajectory, start: np.ndarray, actuators: ParkingActuators | None = None) -> list[tuple[float, float, float]]:
    """(across, heading, along) errors, every step, of a perfectly measured car."""
    lags = actuators or ParkingActuators()
    tracker = ParkingTracker(USUAL, ParkingActuators(), CAR, LIMITS.acceleration_mps2)
    tracker.aim_at(path)
    plant = ParkingPlant(CAR, LIMITS, lags, start, float(path.steering_rad[0]))
    rows = []
    for k in range(-10, int(path.duration_s / 0.02)):
        command = tracker.command(0.02 * k, plant.pose, plant.speed_mps, plant.steering_rad)
        for _ in range(2):
            plant.step(*command)
        off = tracker.error(tracker.aim(0.02 * (k + 1)), plant.pose, plant.speed_mps)
        rows.append((off.across_m, off.heading_rad, off.along_m))
    return rows


@pytest.mark.parametrize("lag", [0.05, 0.1, 0.3])
@pytest.mark.parametrize("delay", [0.0, 0.02, 0.2])
def test_every_design_is_stable(lag, delay):
    gains = design_parking_tracker(ParkingActuators(steering_lag_s=lag, drive_lag_s=lag, delay_s=delay))
    assert gains.slowest_pole < 1.0
    assert gains.across.shape == (gains.speed_mps.size, 3 + gains.waiting)
    assert np.all(np.isfinite(gains.across))


def test_reverse_is_forward_with_the_heading_turned():
    flip = np.ones(3 + USUAL.waiting)
    flip[1] = -1.0
    np.testing.assert_allclose(USUAL.across[::-1], USUAL.across * flip, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(USUAL.speed_mps[::-1], -USUAL.speed_mps)
    assert np.all(USUAL.across[:, 0] > 0.0)


def test_a_dead_time_between_samples_is_refused():
    with pytest.raises(ParameterError, match="whole number of steps"):
        design_parking_tracker(ParkingActuators(delay_s=0.03))


@given(
    gear=st.sampled_from([1.0, -1.0]),
    steering=st.floats(-0.4, 0.4),
    across=st.floats(-0.1, 0.1),
    turned=st.floats(-0.05, 0.05),
)
@settings(max_examples=20, deadline=None)
def test_a_car_beside_the_path_comes_back_in_either_gear(gear, steering, across, turned):
    rows = np.array(followed(cruise(1.5 * gear, steering), np.array([0.0, across, turned])))
    assert abs(rows[-1, 0]) <= max(0.05 * abs(across), 0.003)
    assert abs(rows[-1, 1]) <= max(0.1 * abs(turned), 0.003)
    assert np.abs(rows[:, 0]).max() <= abs(across) + 3.0 * abs(turned) + 0.005
    assert np.abs(rows[:, 2]).max() < 0.08


@given(gear=st.sampled_from([1.0, -1.0]), steering=st.floats(-0.5, 0.5))
@settings(max_examples=10, deadline=None)
def test_on_the_path_feedforward_alone_stays_on_it(gear, steering):
    rows = np.abs(followed(cruise(1.5 * gear, steering), np.zeros(3)))
    assert rows[:, 0].max() < 0.002
    assert rows[:, 1].max() < 0.002
    assert rows[:, 2].max() < 0.02


@pytest.mark.parametrize("slower", [0.5, 1.5])
def test_a_wrongly_known_lag_is_borne(slower):
    lags = ParkingActuators(steering_lag_s=0.1 * slower, drive_lag_s=0.1 * slower, delay_s=0.1 * slower)
    for gear in (1.0, -1.0):
        rows = np.abs(followed(cruise(1.8 * gear, 0.3), np.array([0.0, 0.05, 0.02]), lags))
        assert rows[-1, 0] < 0.005
        assert rows[:, 0].max() < 0.15


def test_the_plant_moves_late_and_within_its_limits():
    plant = ParkingPlant(CAR, LIMITS, ParkingActuators(), np.zeros(3), 0.0)
    before, speeds = 0.0, []
    for k in range(600):
        plant.step(9.0, 9.0)
        assert abs(plant.steering_rad - before) <= CAR.steering_rate_max_radps * 0.01 + 1e-12
        before = plant.steering_rad
        speeds.append(plant.speed_mps)
        if k < 10:
            assert plant.speed_mps == 0.0
            assert plant.steering_rad == 0.0
    assert np.diff(speeds).max() <= LIMITS.acceleration_mps2 * 0.01 + 1e-12
    assert speeds[-1] == pytest.approx(LIMITS.forward_mps)
    assert plant.steering_rad == pytest.approx(CAR.steering_max_rad)
    assert plant.steering_rad <= CAR.steering_max_rad + 1e-12


def test_the_pose_filter_averages_noise_and_forgets_a_wrong_start():
    rng = np.random.default_rng(1)
    tracked = PoseFilter(np.array([0.3, -0.2, 0.1]), CAR.wheelbase_m)
    path = cruise(1.5, 0.3, 12.0)
    off = []
    for k in range(1, len(path)):
        noise = np.array([0.02, 0.02, 0.005]) * rng.standard_normal(3)
        v, delta = 0.5 * (path.speed_mps[k - 1] + path.speed_mps[k]), float(path.steering_rad[k])
        off.append(tracked.update(float(v), delta, 0.05, path.poses[k] + noise) - path.poses[k])
    late = np.array(off)[120:]
    assert np.sqrt(np.mean(late[:, :2] ** 2)) < 0.5 * 0.02
    assert np.sqrt(np.mean(late[:, 2] ** 2)) < 0.5 * 0.005
