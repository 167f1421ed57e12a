"""The Intelligent Driver Model, with a reaction time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import SelectorSettings
from mcdas_opt.domain.track import CROSSING_MPS
from mcdas_opt.dynamics.car_following import IdmSettings, Leader, idm_acceleration
from mcdas_opt.situation.roles import CROSSES_S, reach_into_m

STEP_S = 0.01  # of plant and traffic
_INTRUSION_M = SelectorSettings().lane_intrusion_m


def step_times(first: int, count: int) -> Array:
    """Times [s] of `count` steps from step `first` on, rounded to a nanosecond."""
    return np.asarray(np.round(STEP_S * np.arange(first, first + count), 9), dtype=np.float64)


class Presence(NamedTuple):
    """A road user at one instant: body centre, speed along the road, size, speed across it to the left."""

    s_m: float
    d_m: float
    speed_s_mps: float
    length_m: float
    width_m: float
    speed_d_mps: float = 0.0


@dataclass(slots=True, kw_only=True)
class Follower:
    """A driver by the IDM: wants `desired_mps`, stays at its d, follows whoever is ahead in its lane, the host included.

    It answers the gap and the leader's speed of `delay_steps` steps ago with its own speed of now. Before t = 0 it has come at
    constant speed. `s_m` and `speed_mps` hold its motion at t = 0, STEP_S, ...; `seen` what it saw, from t = -delay on.
    """

    start: Presence
    desired_mps: float
    delay_steps: int
    road: Road
    settings: IdmSettings
    s_m: list[float] = field(init=False)
    speed_mps: list[float] = field(init=False)
    seen: list[Leader | None] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.s_m, self.speed_mps = [self.start.s_m], [self.start.speed_s_mps]

    @property
    def now(self) -> Presence:
        return self.start._replace(s_m=self.s_m[-1], speed_s_mps=self.speed_mps[-1])

    def before(self, t_s: float) -> Presence:
        """At a time before the scene begins."""
        return self.start._replace(s_m=self.start.s_m + self.start.speed_s_mps * t_s)

    def look(self, own: Presence, others: Iterable[Presence]) -> None:
        """Notes the nearest body ahead whose centre is in its lane or whose body overlaps its width; beside the road there is no lane."""
        lane = self.road.lane_of(own.d_m, own.s_m)
        is_inside = self._is_in(lane, own)
        best: Leader | None = None
        for other in others:
            across = abs(other.d_m - own.d_m) < 0.5 * (other.width_m + own.width_m)
            if other.s_m <= own.s_m or not (across or (is_inside and self._is_in(lane, other))):
                continue
            gap = other.s_m - own.s_m - 0.5 * (other.length_m + own.length_m)
            if best is None or gap < best.gap_m:
                best = Leader(gap_m=gap, speed_mps=other.speed_s_mps)
        self.seen.append(best)

    def _is_in(self, lane: int, one: Presence) -> bool:
        s, d, road = one.s_m, one.d_m, self.road
        moves = CROSSES_S * one.speed_d_mps if abs(one.speed_d_mps) > CROSSING_MPS else 0.0
        return road.lane_of(d, s) == lane and reach_into_m(s, d, one.width_m, lane, road, moves) >= _INTRUSION_M

    def advance(self) -> None:
        """One step of STEP_S, trapezoidal in the speed, which never falls below 0."""
        speed = self.speed_mps[-1]
        acceleration = idm_acceleration(speed, self.desired_mps, self.seen[len(self.s_m) - 1], self.settings)
        after = max(speed + acceleration * STEP_S, 0.0)
        self.s_m.append(self.s_m[-1] + 0.5 * (speed + after) * STEP_S)
        self.speed_mps.append(after)

    def __call__(self, t_s: Any) -> BodyMotion:
        """Motion at times up to the one reached, linear between steps; at constant speed before t = 0 and beyond."""
        t = np.asarray(t_s, dtype=np.float64)
        times = step_times(0, len(self.s_m))
        inside = np.clip(t, 0.0, times[-1])
        speed = np.interp(inside, times, self.speed_mps)
        s = np.interp(inside, times, self.s_m) + (t - inside) * speed
        zero = np.zeros_like(t)
        return BodyMotion(s_m=s, d_m=zero + self.start.d_m, heading_rad=zero, speed_s_mps=speed, speed_d_mps=zero)
