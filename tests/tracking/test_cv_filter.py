"""The target filter against a textbook one, late measurements, and a published data set."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.measurement import RadarDetection
from mcdas_opt.domain.motion import TargetMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.dynamics.target import process_noise, transition
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.tracking.association import innovation
from mcdas_opt.tracking.cv_filter import ConstantVelocityFilter
from mcdas_opt.tracking.fix import Viewpoint, radar_fixes

MOTION = TargetMotion(name="test", acceleration_along_mps2=3.0, acceleration_across_mps2=1.5)
DATA = Path(__file__).parents[3] / "shared" / "data" / "ekf_reference" / "obj_pose-laser-radar-synthetic-input.txt"


@settings(deadline=None, max_examples=80)
@given(
    seed=st.integers(0, 10_000),
    steps=st.lists(st.floats(0.0, 0.5), min_size=1, max_size=8),
)
def test_agrees_with_the_textbook_to_1e_9(seed: int, steps: list[float]) -> None:
    random = np.random.default_rng(seed)
    x, root = random.standard_normal(4) * 10.0, random.standard_normal((4, 4))
    P = root @ root.T + np.eye(4)
    kf = ConstantVelocityFilter(x, P, 0.0, MOTION)
    t = 0.0
    for dt in steps:
        t += dt
        size = int(random.integers(1, 5))
        H, z, noise = random.standard_normal((size, 4)), random.standard_normal(size), random.standard_normal((size, size))
        R = noise @ noise.T + 0.1 * np.eye(size)
        kf.correct(t, z, H, R)
        F = transition(dt)
        x, P = F @ x, F @ P @ F.T + process_noise(dt, 3.0, 1.5)
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        x, P = x + K @ (z - H @ x), P - K @ H @ P
        scale = 1.0 + np.abs(x).max()
        np.testing.assert_allclose(kf.state, x, rtol=0.0, atol=1e-9 * scale)
        np.testing.assert_allclose(kf.covariance, P, rtol=0.0, atol=1e-9 * (1.0 + np.abs(P).max()))
        assert kf.state.shape == (4,)
        np.testing.assert_array_equal(kf.covariance, kf.covariance.T)


def test_looking_ahead_commits_to_nothing() -> None:
    kf = ConstantVelocityFilter(np.array([1.0, 2.0, 3.0, 4.0]), np.eye(4), 0.0, MOTION)
    x, P = kf.at(2.0)
    np.testing.assert_allclose(x, [5.0, 2.0, 11.0, 4.0])
    np.testing.assert_allclose(kf.place_at(2.0), x[[0, 2]])
    assert np.linalg.eigvalsh(P - kf.covariance).min() < 0.0 < np.linalg.eigvalsh(P).min()
    np.testing.assert_array_equal(kf.state, [1.0, 2.0, 3.0, 4.0])
    np.testing.assert_array_equal(kf.covariance, np.eye(4))


def test_a_late_measurement_counts_at_its_own_time() -> None:
    """Without process noise a measurement from before is worth the same as in order."""
    still = TargetMotion(name="still", acceleration_along_mps2=1e-9, acceleration_across_mps2=1e-9)
    H, R = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]), 0.1 * np.eye(2)
    first, second = np.array([2.1, 0.2]), np.array([3.9, -0.1])
    in_order = ConstantVelocityFilter(np.array([0.0, 20.0, 0.0, 0.0]), np.eye(4), 0.0, still)
    in_order.correct(0.1, first, H, R)
    in_order.correct(0.2, second, H, R)
    late = ConstantVelocityFilter(np.array([0.0, 20.0, 0.0, 0.0]), np.eye(4), 0.0, still)
    late.correct(0.2, second, H, R)
    late.correct(0.1, first, H, R)
    assert late.time_s == 0.2
    np.testing.assert_allclose(late.state, in_order.state, atol=1e-9)
    np.testing.assert_allclose(late.covariance, in_order.covariance, atol=1e-9)


def test_a_late_measurement_is_worth_less_when_targets_manoeuvre() -> None:
    H, R = np.array([[1.0, 0.0, 0.0, 0.0]]), 0.1 * np.eye(1)
    wild = TargetMotion(name="wild", acceleration_along_mps2=50.0, acceleration_across_mps2=1.0)
    a = ConstantVelocityFilter(np.zeros(4), np.eye(4), 0.2, MOTION)
    b = ConstantVelocityFilter(np.zeros(4), np.eye(4), 0.2, wild)
    for kf in (a, b):
        kf.correct(0.05, np.array([1.0]), H, R)
    assert 0.0 < b.state[0] < a.state[0] < 1.0


def own_rows() -> list[str]:
    """500 rows as the published ones are written, of a target whose acceleration is white with the filter's own variance."""
    random = np.random.default_rng(8)
    x, dt = np.array([0.6, 5.2, 0.6, 0.0]), 0.05
    root = np.linalg.cholesky(process_noise(dt, 3.0, 3.0) + 1e-12 * np.eye(4))
    rows = []
    for k in range(500):
        px, vx, py, vy = x
        truth = [px, py, vx, vy, 0.0, 0.0]
        if k % 2 == 0:
            kind, read = "L", np.array([px, py]) + 0.15 * random.standard_normal(2)
        else:
            polar = [math.hypot(px, py), math.atan2(py, px), (px * vx + py * vy) / math.hypot(px, py)]
            kind, read = "R", np.array(polar) + np.array([0.3, 0.03, 0.3]) * random.standard_normal(3)
        rows.append(" ".join([kind, *(f"{value:.6f}" for value in [*read, 1e6 * k * dt, *truth])]))
        x = transition(dt) @ x + root @ random.standard_normal(4)
    return rows


@pytest.mark.parametrize(
    "rows", [own_rows, pytest.param(lambda: DATA.read_text().splitlines(), id="published", marks=pytest.mark.published(DATA))]
)
def test_lidar_and_radar_rows_with_their_truth(rows: Callable[[], list[str]]) -> None:
    """500 rows with truth, acceleration variance 9: a published extended filter reaches RMSE .0965 .0855 .387 .440, NIS 1.97 and 3.20."""
    frame = FrenetFrame(road=Road())
    view = Viewpoint(x=0.0, y=0.0, yaw=0.0, vx=0.0, vy=0.0, host_s_m=0.0)
    H = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    kf: ConstantVelocityFilter | None = None
    errors, nis = [], {"L": [], "R": []}
    for line in rows():
        kind, *fields = line.split()
        values = [float(f) for f in fields]
        count = 2 if kind == "L" else 3
        t, (px, py, vx, vy) = values[count] * 1e-6, values[count + 1 : count + 5]
        if kf is None:
            motion = TargetMotion(name="published", acceleration_along_mps2=3.0, acceleration_across_mps2=3.0)
            kf = ConstantVelocityFilter(np.array([values[0], 0.0, values[1], 0.0]), np.diag([0.0225, 50.0, 0.0225, 50.0]), t, motion)
        elif kind == "L":
            z, R = np.array(values[:2]), 0.15**2 * np.eye(2)
            x, P = kf.at(t)
            y, S = z - H @ x, H @ P @ H.T + R
            nis[kind].append(y @ np.linalg.solve(S, y))
            kf.correct(t, z, H, R)
        else:
            point = RadarDetection(
                range_m=values[0],
                azimuth_rad=values[1],
                range_rate_mps=values[2],
                range_sd_m=0.3,
                azimuth_sd_rad=0.03,
                range_rate_sd_mps=0.3,
            )
            (fix,) = radar_fixes([point], view, frame, None)
            assert fix is not None
            y, S = innovation(kf.at(t), fix)
            nis[kind].append(y @ np.linalg.solve(S, y))
            kf.correct(t, *fix.read(kf.at(t)))
        errors.append(kf.state - np.array([px, vx, py, vy]))
    rmse = np.sqrt(np.mean(np.square(errors), axis=0))[[0, 2, 1, 3]]
    assert np.all(rmse < [0.11, 0.10, 0.48, 0.50]), rmse
    assert 1.7 < np.mean(nis["L"]) < 2.3
    assert 2.7 < np.mean(nis["R"]) < 3.5
