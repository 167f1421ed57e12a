"""The paper's 8-state filter: as published, and equal to two independent implementations."""

from __future__ import annotations

import datetime

import numpy as np
import pytest

from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import ParameterError
from mcdas_opt.tracking.paired_filter import (
    PairedFilter,
    paired_observation,
    paired_process_noise,
    paired_transition,
)

STEP_S = 0.5
Q = paired_process_noise(STEP_S, 1.0, 0.2)
R = np.diag([0.25, 0.09, 0.36, 0.04])
P0 = np.diag([4.0, 9.0, 1.0, 1.0, 2.0, 9.0, 1.0, 1.0]) + 0.1
X0 = np.array([-30.0, 15.0, 0.2, 0.0, 30.0, 10.0, -0.1, 0.0])


def the_filter() -> PairedFilter:
    return PairedFilter(state=X0, state_covariance=P0, step_s=STEP_S, process_covariance=Q, measurement_covariance=R)


def measurements(seed: int, count: int = 30) -> Array:
    """Noisy positions of a rear vehicle at 60 km/h and a front one at 40 km/h."""
    random = np.random.default_rng(seed)
    t = STEP_S * np.arange(1, count + 1)
    truth = np.column_stack([-30.0 + 60.0 / 3.6 * t, 0.0 * t, 30.0 + 40.0 / 3.6 * t, 0.0 * t])
    return truth + random.multivariate_normal(np.zeros(4), R, size=count)


def textbook(z: Array) -> tuple[Array, Array]:
    """Eq 14-19 on plain numpy: all posterior states, and the last covariance."""
    A = np.eye(8)
    C = np.zeros((4, 8))
    for k in range(4):
        A[2 * k, 2 * k + 1] = STEP_S
        C[k, 2 * k] = 1.0
    x, P, states = X0.copy(), P0.copy(), []
    for row in z:
        x = A @ x
        P = A @ P @ A.T + Q
        K = P @ C.T @ np.linalg.inv(C @ P @ C.T + R)
        x = x + K @ (row - C @ x)
        P = (np.eye(8) - K @ C) @ P
        states.append(x)
    return np.array(states), P


def test_matrices_are_those_of_eq_12_and_13() -> None:
    A, C = paired_transition(0.5), paired_observation()
    assert A.shape == (8, 8)
    assert C.shape == (4, 8)
    expected = np.eye(8)
    expected[[0, 2, 4, 6], [1, 3, 5, 7]] = 0.5
    np.testing.assert_array_equal(A, expected)
    np.testing.assert_array_equal(np.argwhere(C), [[0, 0], [1, 2], [2, 4], [3, 6]])


@pytest.mark.parametrize("seed", range(5))
def test_agrees_with_the_textbook_to_1e_9(seed: int) -> None:
    z = measurements(seed)
    kf = the_filter()
    states, covariance = textbook(z)
    np.testing.assert_allclose(kf.run(z), states, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(kf.covariance, covariance, rtol=0.0, atol=1e-9)


def test_agrees_with_stone_soup_to_1e_9() -> None:
    pytest.importorskip("stonesoup")
    from stonesoup.models.measurement.linear import LinearGaussian
    from stonesoup.models.transition.linear import LinearGaussianTimeInvariantTransitionModel
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.types.detection import Detection
    from stonesoup.types.hypothesis import SingleHypothesis
    from stonesoup.types.state import GaussianState
    from stonesoup.updater.kalman import KalmanUpdater

    transition = LinearGaussianTimeInvariantTransitionModel(transition_matrix=paired_transition(STEP_S), covariance_matrix=Q)
    model = LinearGaussian(ndim_state=8, mapping=(0, 2, 4, 6), noise_covar=R)
    predictor, updater = KalmanPredictor(transition), KalmanUpdater(model)
    start = datetime.datetime(2020, 1, 1)
    estimate = GaussianState(X0.reshape(8, 1), P0, timestamp=start)
    kf = the_filter()
    for k, row in enumerate(measurements(11)):
        now = start + datetime.timedelta(seconds=STEP_S * (k + 1))
        prediction = predictor.predict(estimate, timestamp=now)
        detection = Detection(row.reshape(4, 1), timestamp=now, measurement_model=model)
        estimate = updater.update(SingleHypothesis(prediction, detection))
        np.testing.assert_allclose(kf.step(row), np.asarray(estimate.state_vector, dtype=float).ravel(), rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(kf.covariance, np.asarray(estimate.covar, dtype=float), rtol=0.0, atol=1e-9)


def test_the_posterior_is_the_next_prior() -> None:
    """Eq 19 as meant."""
    kf = the_filter()
    posterior = kf.step(measurements(1)[0]).copy()
    np.testing.assert_allclose(kf.predict(), paired_transition(STEP_S) @ posterior, rtol=0.0, atol=1e-12)


def test_rear_and_front_do_not_mix() -> None:
    """Nothing in A, C, Q, R couples the vehicles: a front measurement moves the rear estimate not at all."""
    uncoupled = np.diag(np.diag(P0))
    a, b = (
        PairedFilter(state=X0, state_covariance=uncoupled, step_s=STEP_S, process_covariance=Q, measurement_covariance=R) for _ in range(2)
    )
    z = measurements(2)
    moved = z + np.array([0.0, 0.0, 5.0, -3.0])
    np.testing.assert_array_equal(a.run(z)[:, :4], b.run(moved)[:, :4])


@pytest.mark.parametrize("bad", [[np.nan, 0.0, 0.0, 0.0], [np.inf, 0.0, 0.0, 0.0], [0.0, 0.0], [[0.0, 0.0, 0.0, 0.0]]])
def test_bad_measurements_are_refused_and_leave_the_filter_alone(bad: list[float]) -> None:
    kf = the_filter()
    kf.step(measurements(3)[0])
    before = kf.state.copy()
    with pytest.raises(ParameterError):
        kf.update(bad)
    np.testing.assert_array_equal(kf.state, before)
    assert kf.state.shape == (8,)


@pytest.mark.parametrize("step", [0.0, -0.5, np.nan])
def test_time_runs_forward(step: float) -> None:
    with pytest.raises(ParameterError):
        PairedFilter(state=X0, state_covariance=P0, step_s=step, process_covariance=Q, measurement_covariance=R)
