"""The paper's Kalman filter (eq 12-19): rear and front vehicle in one state, constant velocity, positions measured.

Literal: x = (x_r, vx_r, y_r, vy_r, x_f, vx_f, y_f, vy_f) with A of eq 12 and C of eq 13. The paper gives no Q, R or P0: the caller
states them. Eq 19 is read as meant: the posterior at t is the prior state of step t + 1. filterpy's covariance update is Joseph's
form, equal to eq 18 for the optimal gain.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array, covariance, positive, vector
from mcdas_opt.dynamics.target import process_noise, transition


def paired_transition(step_s: float) -> Array:
    """(8, 8) A of eq 12."""
    return np.asarray(np.kron(np.eye(2), transition(step_s)), dtype=np.float64)


def paired_observation() -> Array:
    """(4, 8) C of eq 13."""
    return np.asarray(np.kron(np.eye(4), np.array([[1.0, 0.0]])), dtype=np.float64)


def paired_process_noise(step_s: float, along: float, across: float) -> Array:
    """(8, 8) Q_W: white-noise acceleration of the two vehicles, independent of one another; our choice, the paper gives none."""
    return np.asarray(np.kron(np.eye(2), process_noise(step_s, along, across)), dtype=np.float64)


class PairedFilter:
    """Eq 14-19, one `step` a measurement. Raises `ParameterError` for anything that is not finite or of the wrong shape."""

    def __init__(self, *, state: Any, state_covariance: Any, step_s: float, process_covariance: Any, measurement_covariance: Any) -> None:
        from filterpy.kalman import KalmanFilter

        self._kf: Any = KalmanFilter(dim_x=8, dim_z=4)
        self._kf.x = vector("state", state, length=8).reshape(8, 1).copy()
        self._kf.P = covariance("state_covariance", state_covariance, 8).copy()
        self._kf.F = paired_transition(positive("step_s", step_s, "s"))
        self._kf.H = paired_observation()
        self._kf.Q = covariance("process_covariance", process_covariance, 8).copy()
        self._kf.R = covariance("measurement_covariance", measurement_covariance, 4).copy()

    @property
    def state(self) -> Array:
        """(8,)"""
        return np.asarray(self._kf.x[:, 0])

    @property
    def covariance(self) -> Array:
        """(8, 8)"""
        return np.asarray(self._kf.P)

    def predict(self) -> Array:
        """Eq 14-15; the predicted state (8,)."""
        self._kf.predict()
        return self.state

    def update(self, measured: Any) -> Array:
        """Eq 16-18 with the positions (x_r, y_r, x_f, y_f); the posterior state (8,)."""
        z = vector("measured", measured, "m", length=4)
        self._kf.update(z.reshape(4, 1))
        assert self._kf.x.shape == (8, 1)
        return self.state

    def step(self, measured: Any) -> Array:
        """One cycle: predict, then update."""
        self.predict()
        return self.update(measured)

    def run(self, measured: Any) -> Array:
        """(n, 8) posterior states for measurements (n, 4)."""
        return np.array([self.step(z) for z in measured])
