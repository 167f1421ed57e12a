"""The constant-velocity Kalman filter of one target, on filterpy."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np

from mcdas_opt.domain.motion import TargetMotion
from mcdas_opt.domain.rules import Array
from mcdas_opt.dynamics.target import process_noise, transition
from mcdas_opt.tracking.association import gated_costs
from mcdas_opt.tracking.fix import Fix


def load_filter() -> None:
    """Imports filterpy (half a second) now, not in the first cycle of a drive."""
    import_module("filterpy.kalman")


class ConstantVelocityFilter:
    """State (s, vs, d, vd) with its covariance, and the time that they belong to.

    The library is given F, H, Q of our own and columns only; what goes in has been screened before (one NaN would stay for ever).
    """

    def __init__(self, state: Array, covariance: Array, time_s: float, motion: TargetMotion) -> None:
        from filterpy.kalman import KalmanFilter

        self._kf: Any = KalmanFilter(dim_x=4, dim_z=3)
        self._kf.x = np.array(state, dtype=np.float64).reshape(4, 1)
        self._kf.P = np.array(covariance, dtype=np.float64).reshape(4, 4)
        self.time_s = time_s
        self._motion = motion

    @property
    def state(self) -> Array:
        """(4,)"""
        return np.asarray(self._kf.x[:, 0])

    @property
    def covariance(self) -> Array:
        """(4, 4)"""
        return np.asarray(self._kf.P)

    def _noise(self, dt: float) -> Array:
        return process_noise(dt, self._motion.acceleration_along_mps2, self._motion.acceleration_across_mps2)

    def at(self, time_s: float) -> tuple[Array, Array]:
        """State and covariance believed at `time_s` without committing to it; also for a time shortly before the filter's own."""
        dt = time_s - self.time_s
        F = transition(dt)
        P = F @ self.covariance @ F.T + self._noise(abs(dt))
        return F @ self.state, 0.5 * (P + P.T)

    def speeds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Speed along the road and its variance, and the same across it, at the filter's own time."""
        x, P = self._kf.x, self._kf.P
        return (float(x[1, 0]), float(P[1, 1])), (float(x[3, 0]), float(P[3, 3]))

    def place_at(self, time_s: float) -> tuple[float, float]:
        """(s, d) believed at `time_s`."""
        s, vs, d, vd = self._kf.x[:, 0].tolist()
        dt = time_s - self.time_s
        return s + vs * dt, d + vd * dt

    def take(self, time_s: float, fix: Fix) -> None:
        """Take in a fix of that time."""
        self.correct(time_s, *fix.read(self.at(time_s)))

    def costs(self, time_s: float, fixes: Sequence[Fix | None], gate: float) -> list[float]:
        """Of each fix of that time: `association.gated_costs`."""
        costs: list[float] = gated_costs([self.at(time_s)], [fixes], gate)[0].tolist()
        return costs

    def correct(self, time_s: float, z: Array, H: Array, R: Array) -> None:
        """Take in z = H x(time_s) + noise of covariance R; z (m,), H (m, 4), R (m, m).

        A measurement a little older than the filter (another sensor was faster) is taken in where the filter stands, as
        z = H F(dt) x with dt < 0, the process noise of the lag added to R.
        """
        dt = time_s - self.time_s
        if dt > 0.0:
            self._kf.predict(F=transition(dt), Q=self._noise(dt))
            self.time_s = time_s
        elif dt < 0.0:
            R = R + H @ self._noise(-dt) @ H.T
            H = H @ transition(dt)
        self._kf.update(z.reshape(-1, 1), R=R, H=H)
        self._kf.P = 0.5 * (self._kf.P + self._kf.P.T)
        assert self._kf.x.shape == (4, 1)
