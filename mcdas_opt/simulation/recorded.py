"""Recorded neighbours: a file's samples, played back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array, all_finite, floats
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.frenet import LEAST_STRETCH, FrenetFrame

_AROUND_M = 50.0  # of road beyond the samples
_ACROSS = np.sin(np.radians(20.0))  # who is headed farther off the road's direction goes on as headed
GONE_M = 1e4  # who has left stands so far off the road: nobody meets or sees it


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedMotion:
    """Plays samples (n, 5) of t, s, d, heading, speed over ground along the heading: linear in time in between, in the plane.

    A body that goes across a bend is now nearest to the road before it, now after it: its s may jump, its place does not. After the last
    sample the body goes on at the last speed: along the road, in its direction, heading 0 or pi, or across it as it was headed. Before
    t = 0 (and before a first sample that is later) it has come along the road at the speed of that moment, as everybody has before a scene
    begins. Who `leaves` is gone after the last sample.
    """

    samples: Array
    road: Road
    leaves: bool = False
    _frame: FrenetFrame | None = field(init=False, repr=False, compare=False)
    _plane: Array = field(init=False, repr=False, compare=False)  # (n, 3): x, y, yaw of the samples on a bent road

    def __post_init__(self) -> None:
        require_types(self)
        samples = floats("samples", self.samples, "must be rows of five numbers")
        if samples.ndim != 2 or samples.shape[1] != 5 or not samples.size or not all_finite(samples):
            raise ParameterError("samples", f"shape {samples.shape}", "must be rows of five finite numbers")
        object.__setattr__(self, "samples", samples)
        frame, plane = None, np.zeros((0, 3))
        if not self.road.is_straight:
            s, d, heading = self.samples[:, 1:4].T
            frame = FrenetFrame(road=self.road, s_min_m=min(float(s.min()), 0.0) - _AROUND_M, s_max_m=max(float(s.max()), 0.0) + _AROUND_M)
            x, y, yaw = frame.to_plane(s, d, heading)
            plane = np.column_stack([x, y, np.unwrap(yaw)])
        object.__setattr__(self, "_frame", frame)
        object.__setattr__(self, "_plane", plane)

    def is_gone(self, t_s: float) -> bool:
        """Whether it has left by then."""
        return self.leaves and t_s > max(0.0, float(self.samples[-1, 0]))

    def __call__(self, t_s: Any) -> BodyMotion:
        t = np.asarray(t_s, dtype=np.float64)
        first, last = max(0.0, float(self.samples[0, 0])), float(self.samples[-1, 0])
        inside = np.clip(t, first, max(last, first))
        s, d, heading, speed = self._at(inside)
        beyond, late = t > last, t - inside
        settled = np.abs(np.sin(heading)) < _ACROSS
        heading = np.where(beyond & settled, np.where(np.cos(heading) > 0.0, 0.0, np.pi), heading)
        along = speed * np.cos(heading)
        across = np.where(beyond & settled, 0.0, speed * np.sin(heading))
        if self.leaves:
            d, speed = np.where(beyond, GONE_M, d), np.where(beyond, 0.0, speed)
            along, across = np.where(beyond, 0.0, along), np.where(beyond, 0.0, across)
        if self._frame is not None:
            along = along / np.maximum(1.0 - d * self.road.curvature_at(s), LEAST_STRETCH)
        return BodyMotion(
            s_m=s + late * along,
            d_m=d + np.where(beyond, late * across, 0.0),
            heading_rad=heading,
            speed_s_mps=along,
            speed_d_mps=np.where(t < first, 0.0, across),
        )

    def _at(self, t: Array) -> tuple[Array, Array, Array, Array]:
        """s, d, heading, speed at times within the samples."""
        times = self.samples[:, 0]
        if self._frame is None:
            s, d, heading, speed = (np.interp(t, times, self.samples[:, k]) for k in (1, 2, 3, 4))
            return s, d, heading, speed
        x, y, yaw, speed = (np.interp(t, times, column) for column in (*self._plane.T, self.samples[:, 4]))
        after = np.clip(np.searchsorted(times, t), 1, times.size - 1)
        nearest = np.where(t - times[after - 1] < times[after] - t, after - 1, after)
        s, d, heading = self._frame.to_road(x, y, yaw, guess_s_m=self.samples[nearest, 1])
        return s, d, heading, speed
