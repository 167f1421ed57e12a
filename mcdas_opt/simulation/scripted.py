"""Scripted neighbours: exact motion at any time, pieced together from closed forms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mcdas_opt.catalogue.neighbour_tables import MotionPart
from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.frenet import LEAST_STRETCH, FrenetFrame

LATERAL_MOVE_NEEDS_MPS = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedPiece:
    """From `t_s` on (until the next piece) the speed along the road changes at a constant rate."""

    t_s: float
    s_m: float
    speed_mps: float
    acceleration_mps2: float

    def at(self, t_s: float) -> tuple[float, float]:
        """(s, ds/dt) at t_s."""
        dt = t_s - self.t_s
        return self.s_m + (self.speed_mps + 0.5 * self.acceleration_mps2 * dt) * dt, self.speed_mps + self.acceleration_mps2 * dt


@dataclass(frozen=True, slots=True, kw_only=True)
class LateralPiece:
    """From `t_s` on d follows a quintic in time for `duration_s`, then stays at `to_m`.

    `coefficients` (6,) are those of the powers of (t - t_s) / duration_s.
    """

    t_s: float
    duration_s: float
    to_m: float
    coefficients: Array

    @classmethod
    def from_state(cls, t_s: float, duration_s: float, to_m: float, state: Array) -> LateralPiece:
        """The quintic from `state` = (d, dd/dt, d2d/dt2) to rest at `to_m` (Takahashi et al., IV 1989; eq of the boundary values)."""
        p, v, a = float(state[0]), float(state[1]) * duration_s, float(state[2]) * duration_s**2
        h, dv, da = to_m - p - v - 0.5 * a, -v - a, -a
        coefficients = np.array([p, v, 0.5 * a, 10.0 * h - 4.0 * dv + 0.5 * da, -15.0 * h + 7.0 * dv - da, 6.0 * h - 3.0 * dv + 0.5 * da])
        return cls(t_s=t_s, duration_s=duration_s, to_m=to_m, coefficients=coefficients)

    def at(self, t_s: Any) -> Array:
        """(3, ...): d, its rate and its second derivative."""
        t = np.asarray(t_s, dtype=np.float64) - self.t_s
        x = np.clip(t / self.duration_s, 0.0, 1.0)
        c = self.coefficients
        d = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))))
        rate = c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * (4.0 * c[4] + x * 5.0 * c[5])))
        bend = 2.0 * c[2] + x * (6.0 * c[3] + x * (12.0 * c[4] + x * 20.0 * c[5]))
        over = t >= self.duration_s
        return np.stack(
            [
                np.where(over, self.to_m, d),
                np.where(over, 0.0, rate / self.duration_s),
                np.where(over, 0.0, bend / self.duration_s**2),
            ]
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptedMotion:
    """A neighbour that keeps to its script whatever the host does. Call it with times: body centres, headings, speeds.

    Speed is speed *along the road*, ds/dt, so that s is an exact piecewise parabola on a curved road too. Before t = 0 and after the
    last piece the speed is held. Whether a lateral piece happens is decided at its start: at 1 m/s along the road or less it is as
    if it were not written; once begun it lasts its duration. `along` and `lateral` are in time order and begin at t = 0. Who is `oncoming`
    drives the same way towards smaller s.
    """

    along: tuple[SpeedPiece, ...]
    lateral: tuple[LateralPiece, ...]
    start_d_m: float
    road: Road
    oncoming: bool = False
    _columns: Array = field(init=False, repr=False, compare=False)  # (4, pieces): start, s, speed, acceleration of `along`

    def __post_init__(self) -> None:
        require_types(self)
        rows = [(piece.t_s, piece.s_m, piece.speed_mps, piece.acceleration_mps2) for piece in self.along]
        object.__setattr__(self, "_columns", np.array(rows, dtype=np.float64).T)

    @classmethod
    def from_script(
        cls, *, s_m: float, d_m: float, speed_mps: float, script: Sequence[MotionPart], road: Road, oncoming: bool = False
    ) -> ScriptedMotion:
        along = _speed_pieces(s_m, speed_mps, script, road.speed_limit_mps)
        return cls(along=along, lateral=_lateral_pieces(d_m, script, along), start_d_m=d_m, road=road, oncoming=oncoming)

    def __call__(self, t_s: Any) -> BodyMotion:
        t = np.asarray(t_s, dtype=np.float64)
        s, speed = self._along(t)
        d, speed_d = self._across(t)
        if self.oncoming:
            s, speed = 2.0 * self._columns[1, 0] - s, -speed
        heading = road_heading(s, d, speed, speed_d, self.road, oncoming=self.oncoming)
        return BodyMotion(s_m=s, d_m=d, heading_rad=heading, speed_s_mps=speed, speed_d_mps=speed_d)

    def _along(self, t: Array) -> tuple[Array, Array]:
        starts = self._columns[0]
        i = np.clip(np.searchsorted(starts, t, side="right") - 1, 0, len(starts) - 1)
        s0, v0, a = (column[i] for column in self._columns[1:])
        dt = t - starts[i]
        a = np.where(t < starts[0], 0.0, a)
        return s0 + (v0 + 0.5 * a * dt) * dt, v0 + a * dt

    def _across(self, t: Array) -> tuple[Array, Array]:
        d, rate = np.full_like(t, self.start_d_m), np.zeros_like(t)
        for piece in self.lateral:
            begun = t >= piece.t_s
            value = piece.at(t)
            d, rate = np.where(begun, value[0], d), np.where(begun, value[1], rate)
        return d, rate


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadedMotion:
    """A neighbour that drives straight on in the plane, whatever the road does: across it, or towards the host. Its speed over ground
    follows a script's accelerations."""

    start: tuple[float, float, float]  # s, d, heading relative to the road there
    way: ScriptedMotion
    road: Road
    _frame: FrenetFrame = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require_types(self)
        object.__setattr__(self, "_frame", FrenetFrame(road=self.road))

    @classmethod
    def from_script(
        cls, *, s_m: float, d_m: float, heading_rad: float, speed_mps: float, script: Sequence[MotionPart], road: Road
    ) -> HeadedMotion:
        way = ScriptedMotion.from_script(
            s_m=0.0, d_m=0.0, speed_mps=speed_mps, script=script, road=Road(speed_limit_mps=road.speed_limit_mps)
        )
        return cls(start=(s_m, d_m, heading_rad), way=way, road=road)

    def __call__(self, t_s: Any) -> BodyMotion:
        driven = self.way(t_s)
        x, y, yaw = self._frame.to_plane(*(np.full_like(driven.s_m, q) for q in self.start))
        s, d, heading = self._frame.to_road(x + driven.s_m * np.cos(yaw), y + driven.s_m * np.sin(yaw), yaw)
        stretch = 1.0 if self.road.is_straight else np.maximum(1.0 - d * self.road.curvature_at(s), LEAST_STRETCH)
        speed = driven.speed_s_mps
        return BodyMotion(
            s_m=s, d_m=d, heading_rad=heading, speed_s_mps=speed * np.cos(heading) / stretch, speed_d_mps=speed * np.sin(heading)
        )


def road_heading(s: Array, d: Array, speed_s: Array, speed_d: Array, road: Road, *, oncoming: bool = False) -> Array:
    """Heading relative to the road of a body that points along its motion; below 1 m/s as if at 1 m/s."""
    over_ground = speed_s * (1.0 - d * road.curvature_at(s))
    along = np.minimum(over_ground, -1.0) if oncoming else np.maximum(over_ground, 1.0)
    return np.asarray(np.arctan2(speed_d, along), dtype=np.float64)


def _speed_pieces(s_m: float, speed_mps: float, script: Sequence[MotionPart], speed_limit_mps: float) -> tuple[SpeedPiece, ...]:
    pieces = [SpeedPiece(t_s=0.0, s_m=s_m, speed_mps=speed_mps, acceleration_mps2=0.0)]
    for part in script:
        if part.acceleration_mps2 is None:
            continue
        a, start = part.acceleration_mps2, part.start_s
        while len(pieces) > 1 and pieces[-1].t_s > start:
            pieces.pop()
        s, v = pieces[-1].at(start)
        target = part.until_speed_mps
        if target is None:
            target = 0.0 if a < 0.0 else speed_limit_mps
        if (target - v) * a <= 0.0:  # already there, or past it
            pieces.append(SpeedPiece(t_s=start, s_m=s, speed_mps=v, acceleration_mps2=0.0))
            continue
        pieces.append(SpeedPiece(t_s=start, s_m=s, speed_mps=v, acceleration_mps2=a))
        end = start + (target - v) / a
        pieces.append(SpeedPiece(t_s=end, s_m=pieces[-1].at(end)[0], speed_mps=target, acceleration_mps2=0.0))
    return tuple(pieces)


def _lateral_pieces(d_m: float, script: Sequence[MotionPart], along: tuple[SpeedPiece, ...]) -> tuple[LateralPiece, ...]:
    pieces: list[LateralPiece] = []
    for part in script:
        if part.lateral_to_m is None or part.duration_s is None:
            continue
        start = part.start_s
        _, speed = next(p for p in reversed(along) if p.t_s <= start).at(start)
        if speed <= LATERAL_MOVE_NEEDS_MPS:
            continue
        state = pieces[-1].at(start) if pieces else np.array([d_m, 0.0, 0.0])
        pieces.append(LateralPiece.from_state(start, part.duration_s, part.lateral_to_m, state))
    return tuple(pieces)
