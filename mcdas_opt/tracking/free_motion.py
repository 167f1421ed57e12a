"""Where a body goes that does not follow the road: in the plane, straight on or turning, at constant speed or not."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Track
from mcdas_opt.geometry.frenet import LEAST_STRETCH_MEASURED, FrenetFrame
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.tracking.plane import to_plane, to_road

LASTS_S = 20.0  # a table is that long; who is followed longer stays where it ends
_STEP_S = 0.1
TIMES_S = _STEP_S * np.arange(round(LASTS_S / _STEP_S) + 1, dtype=np.float64)
_FARTHEST_M = 2500.0  # along the road that is known where it is
_JUMP_MPS = 120.0  # s that changes faster has gone over to another part of the road; nobody is believed to drive over 100 m/s
_AS_NEAR_M = 1e-6  # what rounding may make of two equal distances
_MOST_JUMPS = 8  # that are looked at, of one line


@dataclass(frozen=True, slots=True, kw_only=True)
class StraightLine:
    """On a straight road."""

    s_m: float
    d_m: float
    heading_rad: float
    speed_s_mps: float
    speed_d_mps: float

    def __call__(self, t_s: Array) -> BodyMotion:
        zero = np.zeros_like(t_s)
        return BodyMotion(
            s_m=self.s_m + self.speed_s_mps * t_s,
            d_m=self.d_m + self.speed_d_mps * t_s,
            heading_rad=zero + self.heading_rad,
            speed_s_mps=zero + self.speed_s_mps,
            speed_d_mps=zero + self.speed_d_mps,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class TabulatedLine:
    """On a bent road: (6, n) t, s, d, heading, speeds along and across of a line in the plane, linear in between. Where s jumps, because
    another part of the road is the nearest from then on, the nearer sample counts."""

    table: Array
    rises: Array  # (5, n - 1) of s, d, heading, speeds from each sample to the next
    jumps: NDArray[np.bool_] | None  # (n - 1,); None where s jumps nowhere

    @classmethod
    def of(cls, table: Array) -> TabulatedLine:
        rises = table[1:, 1:] - table[1:, :-1]
        jumps = np.abs(rises[0]) > _JUMP_MPS * _STEP_S
        return cls(table=table, rises=rises, jumps=jumps if jumps.any() else None)

    def __call__(self, t_s: Array) -> BodyMotion:
        times = self.table[0]
        t = np.minimum(np.maximum(t_s, times[0]), times[-1])
        before = np.minimum((t / _STEP_S).astype(np.intp), times.size - 2)
        share = (t - times[before]) / _STEP_S
        share = share if self.jumps is None else np.where(self.jumps[before], np.round(share), share)
        s, d, heading, along, across = self.table[1:, before] + share * self.rises[:, before]
        return BodyMotion(s_m=s, d_m=d, heading_rad=heading, speed_s_mps=along, speed_d_mps=across)


def straight_on(track: Track, road: Road, rate_mps2: float = 0.0, lasts_s: float = 0.0) -> Callable[[Array], BodyMotion]:
    """The track's motion from its time on, if it keeps its course and its heading in the plane, accelerating by that rate for so long."""
    heading = 0.0 if track.heading_rad is None else track.heading_rad
    if road.is_straight and rate_mps2 == 0.0:
        return StraightLine(s_m=track.s_m, d_m=track.d_m, heading_rad=heading, speed_s_mps=track.speed_s_mps, speed_d_mps=track.speed_d_mps)
    return _in_the_plane(track, road, np.zeros_like(TIMES_S), pace_of(track, rate_mps2, lasts_s))


def turning_in(track: Track, road: Road, rate_mps2: float = 0.0, lasts_s: float = 0.0) -> Callable[[Array], BodyMotion]:
    """The same, if it turns on at its rate until it points along the road or against it."""
    to_go = to_turn_rad(track.heading_rad or 0.0, track.turn_rate_radps)
    return _in_the_plane(track, road, np.clip(track.turn_rate_radps * TIMES_S, -to_go, to_go), pace_of(track, rate_mps2, lasts_s))


def to_turn_rad(heading_rad: float, rate_radps: float) -> float:
    """How far who turns that way is from pointing along the road or against it."""
    return math.copysign(heading_rad, -rate_radps * heading_rad) % math.pi


def pace_of(track: Track, rate_mps2: float, lasts_s: float) -> Array:
    """How many times as fast as now at `TIMES_S`, of who moves."""
    if rate_mps2 == 0.0:
        return np.ones_like(TIMES_S)
    speed = math.hypot(track.speed_s_mps, track.speed_d_mps)
    return 1.0 + rate_mps2 / speed * np.minimum(TIMES_S, lasts_s)


def _in_the_plane(track: Track, road: Road, turned_rad: Array, pace: Array) -> TabulatedLine:
    """The track's motion where it is turned by `turned_rad`, and `pace` times as fast, at `TIMES_S`."""
    frame = frame_for(track, road, float(pace.max()))
    x, y, yaw = (float(q[0]) for q in to_plane(frame, np.array([track.s_m]), np.array([track.d_m]), np.array([heading_of(track)])))
    forward = track.speed_s_mps * max(1.0 - track.d_m * float(road.curvature_at(track.s_m)), LEAST_STRETCH_MEASURED)
    road_there = yaw - heading_of(track) + turned_rad  # as if it were the road that turned
    c, s = np.cos(road_there), np.sin(road_there)
    vx, vy = pace * (c * forward - s * track.speed_d_mps), pace * (s * forward + c * track.speed_d_mps)
    return tabulated(road, frame, track.s_m, (x + way_m(vx), y + way_m(vy), yaw + turned_rad), (vx, vy))


def heading_of(track: Track) -> float:
    return 0.0 if track.heading_rad is None else track.heading_rad


def frame_for(track: Track, road: Road, pace: float = 1.0) -> FrenetFrame:
    """A frame of the road for who becomes so many times as fast."""
    fastest = abs(track.speed_s_mps) * max(1.0 - track.d_m * float(road.curvature_at(track.s_m)), 1.0) + abs(track.speed_d_mps)
    return frame_near(road, track.s_m, min(LASTS_S * fastest * pace, _FARTHEST_M))


def tabulated(
    road: Road, frame: FrenetFrame, start_s_m: float, poses: tuple[Array, Array, Array], velocity: tuple[Array, Array]
) -> TabulatedLine:
    """The motion along the road of a body that begins at `start_s_m`, by its poses and its velocity in the frame's plane at `TIMES_S`."""
    its_s, its_d, its_heading = _places(frame, *poses, start_s_m)
    road_yaw, (vx, vy) = poses[2] - its_heading, velocity
    stretch = np.maximum(1.0 - its_d * road.curvature_at(its_s), LEAST_STRETCH_MEASURED)
    along, across = (np.cos(road_yaw) * vx + np.sin(road_yaw) * vy) / stretch, np.cos(road_yaw) * vy - np.sin(road_yaw) * vx
    return TabulatedLine.of(np.array([TIMES_S, its_s, its_d, unwrapped(its_heading), along, across]))


def unwrapped(angle_rad: Array) -> Array:
    """`np.unwrap`, which takes its time where there is nothing to do."""
    return angle_rad if np.abs(angle_rad[1:] - angle_rad[:-1]).max() < np.pi else np.unwrap(angle_rad)


def way_m(speed_mps: Array) -> Array:
    """By the trapezoidal rule; of a constant speed exactly that times the time."""
    way: Array = speed_mps[0] * TIMES_S
    way[1:] += np.cumsum(0.5 * (speed_mps[1:] + speed_mps[:-1]) - speed_mps[0]) * _STEP_S
    return way


def _places(frame: FrenetFrame, x: Array, y: Array, yaw: Array, start_s_m: float) -> tuple[Array, Array, Array]:
    """(s, d, psi) of the samples of a line that begins at `start_s_m`. Where the road comes back to its own place, two are as near: the
    line stays on the piece of road that it is on, wherever s is counted from."""
    s, d, psi = to_road(frame, x, y, yaw, start_s_m)
    begin = 0
    for _ in range(_MOST_JUMPS):
        jumps = np.flatnonzero(np.abs(np.diff(s[begin:], prepend=s[begin - 1] if begin else start_s_m)) > _JUMP_MPS * _STEP_S)
        if not jumps.size:
            break
        begin += int(jumps[0])
        before_s_m = float(s[begin - 1]) if begin else start_s_m
        rest = slice(begin, None)
        going_on = frame.to_road(x[rest], y[rest], yaw[rest], guess_s_m=np.full(s.size - begin, before_s_m))
        as_near = np.abs(going_on[1] - d[rest]) <= _AS_NEAR_M
        s[rest], d[rest], psi[rest] = (
            np.where(as_near, new, old) for new, old in zip(going_on, (s[rest], d[rest], psi[rest]), strict=True)
        )
        begin += 1
    return s, d, psi
