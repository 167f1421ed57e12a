"""What the tracker asks of filters and fixes, in either form: on filterpy and numpy, which say what is done, or compiled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from mcdas_opt.domain.measurement import BodyDetection, RadarDetection
from mcdas_opt.domain.motion import TargetMotion
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.tracking.association import load_assignment
from mcdas_opt.tracking.compiled_filter import CompiledFiltering, compiled_filtering
from mcdas_opt.tracking.cv_filter import ConstantVelocityFilter, load_filter
from mcdas_opt.tracking.fix import BodyFix, RadarFix, Viewpoint, body_fix, radar_fixes


class TargetFix(Protocol):
    """A detection as a linear measurement of a target's state; `place` is (s, d)."""

    @property
    def place(self) -> tuple[float, float]: ...


class TargetFilter(Protocol):
    """A belief of (s, vs, d, vd) at `time_s`; it takes in the fixes of its own form."""

    time_s: float

    @property
    def covariance(self) -> Array: ...
    def at(self, time_s: float) -> tuple[Array, Array]: ...
    def speeds(self) -> tuple[tuple[float, float], tuple[float, float]]: ...
    def place_at(self, time_s: float) -> tuple[float, float]: ...
    def take(self, time_s: float, fix: Any) -> None: ...
    def costs(self, time_s: float, fixes: Sequence[Any], gate: float) -> list[float]: ...


class Filtering(Protocol):
    """Where fixes and filters of one form come from."""

    def radar_fixes(
        self, detections: Sequence[RadarDetection], view: Viewpoint, frame: FrenetFrame, size: tuple[float, float] | None
    ) -> Sequence[TargetFix | None]: ...
    def body_fix(self, body: BodyDetection, frame: FrenetFrame, position_sd: float, speed_sd: float) -> TargetFix: ...
    def begin(self, state: Array, covariance: Array, time_s: float, motion: TargetMotion) -> TargetFilter: ...


class InterpretedFiltering:
    """On filterpy and numpy: the reference."""

    def __init__(self) -> None:
        load_filter()

    def radar_fixes(
        self, detections: Sequence[RadarDetection], view: Viewpoint, frame: FrenetFrame, size: tuple[float, float] | None
    ) -> Sequence[RadarFix | None]:
        return radar_fixes(detections, view, frame, size)

    def body_fix(self, body: BodyDetection, frame: FrenetFrame, position_sd: float, speed_sd: float) -> BodyFix:
        return body_fix(body, frame, position_sd, speed_sd)

    def begin(self, state: Array, covariance: Array, time_s: float, motion: TargetMotion) -> ConstantVelocityFilter:
        return ConstantVelocityFilter(state, covariance, time_s, motion)


def build_filtering() -> CompiledFiltering | InterpretedFiltering:
    """The compiled form; where there is no compiler, or MCDAS_OPT_COMPILE=0 forbids it, the interpreted one."""
    load_assignment()
    return compiled_filtering() or InterpretedFiltering()
