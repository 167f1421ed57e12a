"""The target filter and its fixes in C (`target_filter.c`): what `cv_filter` and `fix` do, to 1e-9, at a tenth of the time."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from math import sqrt
from typing import Any

import numpy as np

from mcdas_opt.domain.measurement import BodyDetection, RadarDetection
from mcdas_opt.domain.motion import TargetMotion
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.native.binding import address
from mcdas_opt.native.library import library, load
from mcdas_opt.tracking.association import FAR_M, FAR_SD
from mcdas_opt.tracking.fix import LEAST_STRETCH, Viewpoint

_FIX = 16  # numbers of a fix, as the C text orders them
_PLACE_S, _PLACE_D, _STRETCH = 1, 2, 7
_BODY = 1.0


class CompiledFix:
    """One fix: its `place` (s, d), and its numbers where the C text reads them."""

    __slots__ = ("_kept", "at", "place")

    def __init__(self, kept: Array, at: int, place: tuple[float, float]) -> None:
        self._kept = kept  # the array that they lie in
        self.at, self.place = at, place


class CompiledFilter:
    """What `ConstantVelocityFilter` is; it takes in fixes of its own form."""

    def __init__(self, library: ctypes.CDLL, state: Array, covariance: Array, time_s: float, motion: TargetMotion) -> None:
        self._library, self.time_s, self._motion = library, time_s, motion
        self._noise = motion.acceleration_along_mps2, motion.acceleration_across_mps2
        self._belief = np.concatenate([np.ravel(state), np.ravel(covariance)]).astype(np.float64)
        self._then = np.empty(20)
        self._at, self._then_at = address(self._belief), address(self._then)
        self._known: list[float] | None = None  # the state as numbers, until the next fix

    def __reduce__(self) -> tuple[Any, ...]:
        """Made anew in another process, and by a copy: addresses do not travel."""
        return _filter_anew, (self.state, self.covariance, self.time_s, self._motion)

    @property
    def state(self) -> Array:
        """(4,)"""
        return self._belief[:4].copy()

    @property
    def covariance(self) -> Array:
        """(4, 4)"""
        return self._belief[4:].reshape(4, 4).copy()

    def at(self, time_s: float) -> tuple[Array, Array]:
        """State and covariance believed at `time_s` without committing to it; also for a time shortly before the filter's own."""
        self._library.mcdas_at(self._at, time_s - self.time_s, *self._noise, self._then_at)
        then = self._then.copy()
        return then[:4], then[4:].reshape(4, 4)

    def speeds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Speed along the road and its variance, and the same across it, at the filter's own time."""
        belief = self._belief
        return (float(belief[1]), float(belief[9])), (float(belief[3]), float(belief[19]))

    def place_at(self, time_s: float) -> tuple[float, float]:
        """(s, d) believed at `time_s`."""
        known = self._known
        if known is None:
            known = self._known = self._belief[:4].tolist()
        s, vs, d, vd = known
        dt = time_s - self.time_s
        return s + vs * dt, d + vd * dt

    def take(self, time_s: float, fix: CompiledFix) -> None:
        """Take in a fix of that time, at the filter's own time where that is later."""
        dt = time_s - self.time_s
        self._known = None
        self._library.mcdas_correct(self._at, dt, *self._noise, fix.at)
        if dt > 0.0:
            self.time_s = time_s

    def costs(self, time_s: float, fixes: Sequence[CompiledFix | None], gate: float) -> list[float]:
        """Of each fix of that time d^2 + ln det S inside the gate, infinite outside or where there is none."""
        cost, dt, noise = self._library.mcdas_cost, time_s - self.time_s, self._noise
        (s, _, d, _), P = (each.tolist() for each in self.at(time_s))
        far_s, far_d = FAR_M + FAR_SD * sqrt(P[0][0]), FAR_M + FAR_SD * sqrt(P[2][2])  # as the C text does, without a call
        return [
            np.inf
            if fix is None or abs(fix.place[0] - s) > far_s or abs(fix.place[1] - d) > far_d
            else cost(self._at, dt, *noise, fix.at, gate, FAR_M, FAR_SD)
            for fix in fixes
        ]


class CompiledFiltering:
    """Makes fixes and filters."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self._library = library

    def __reduce__(self) -> tuple[Any, ...]:
        return _filtering_anew, ()

    def radar_fixes(
        self, detections: Sequence[RadarDetection], view: Viewpoint, frame: FrenetFrame, size: tuple[float, float] | None
    ) -> list[CompiledFix | None]:
        """`fix.radar_fixes`."""
        points = np.array(
            [(p.range_m, p.azimuth_rad, p.range_rate_mps, p.range_sd_m**2, p.azimuth_sd_rad**2, p.range_rate_sd_mps**2) for p in detections]
        )
        seen = np.array([view.x, view.y, view.yaw, view.vx, view.vy, view.host_s_m])
        rows = np.empty((len(detections), _FIX))
        first = address(rows)
        self._library.mcdas_fixes(len(detections), points, seen, *(size or (0.0, 0.0)), *frame.addresses(), first)
        return [
            CompiledFix(rows, first + i * rows.strides[0], (row[_PLACE_S], row[_PLACE_D])) if row[_STRETCH] >= LEAST_STRETCH else None
            for i, row in enumerate(rows.tolist())
        ]

    def body_fix(self, body: BodyDetection, frame: FrenetFrame, position_sd: float, speed_sd: float) -> CompiledFix:
        """`fix.body_fix`."""
        stretch = 1.0 if frame.road.is_straight else 1.0 - body.d_m * float(frame.road.curvature_at(body.s_m))
        p, v = position_sd * position_sd, speed_sd * speed_sd
        state = body.s_m, body.speed_s_mps / stretch, body.d_m, body.speed_d_mps
        row = np.array([_BODY, body.s_m, body.d_m, *state, 0.0, 0.0, 0.0, p, v, p, v, 0.0, 0.0])
        return CompiledFix(row, address(row), (float(row[_PLACE_S]), float(row[_PLACE_D])))

    def begin(self, state: Array, covariance: Array, time_s: float, motion: TargetMotion) -> CompiledFilter:
        return CompiledFilter(self._library, state, covariance, time_s, motion)


def compiled_filtering() -> CompiledFiltering | None:
    """Built on first use; None where there is no compiler, or MCDAS_OPT_COMPILE=0 forbids it."""
    compiled = library()
    return None if compiled is None else CompiledFiltering(compiled)


def _filter_anew(state: Array, covariance: Array, time_s: float, motion: TargetMotion) -> CompiledFilter:
    return CompiledFilter(library() or load(), state, covariance, time_s, motion)


def _filtering_anew() -> CompiledFiltering:
    return CompiledFiltering(library() or load())
