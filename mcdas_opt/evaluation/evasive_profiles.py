"""The finer library: evasive profiles by a saturated feedback, close to the quickest that the car can do.

They are driven exactly as they are tried.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.dynamics.stopping import times_to_rest
from mcdas_opt.geometry.rectangle import half_extent
from mcdas_opt.manoeuvres.paths import Paths

_BESIDE_M = (1.88, 2.2, 2.7)  # past a body in the middle of its lane: 1.8 m lets two cars of 1.8 m pass
_GRIP = (0.75, 1.0)  # of mu g, for braking and turning together
_BANDWIDTH_RADPS = (1.6, 2.6, 4.5)
_DELAYS_S = (0.0, 0.25, 0.6, 1.2)
_STEADY = (0.0, -0.25, -0.5, -0.75, -1.0, 0.5, 1.0)  # of the limit
_TURNS = ((-1.0, 1.0), (1.0, -1.0), (-1.0, 0.0), (1.0, 0.0), (-0.5, 0.5), (0.0, -1.0), (0.0, 1.0))
_TURN_S = (0.4, 0.8, 1.4, 2.2)
_SLOWEST_MPS = 2.0
_BEND_GRIP = (0.2, 0.35, 0.5, 0.65, 0.8)  # of mu g, for the bend alone
_BEND_PACES = (-0.25, 0.0, 0.1, 0.25, 0.5)  # of the limit
_BEND_ASIDE_M = (0.0, 0.7, -0.7, 1.4, -1.4)
_BEND_BRAKING = 0.3  # of mu g, before a bend
_BEND_S, _BEND_STEP_M = 0.5, 0.5  # time constant of keeping the speed, and how far ahead it is looked up; step of its table


@dataclass(frozen=True, slots=True, kw_only=True)
class EvasiveProfiles:
    """Members (n,): which d to go to [m] after which delay [s], with which share of the grip and which bandwidth [rad/s] of the
    feedback; which acceleration [m/s^2] first, until when [s], and which then; and which share of the grip bends may take, before which
    they brake in time (None: they do not)."""

    target_d_m: Array
    delay_s: Array
    grip: Array
    bandwidth_radps: Array
    first_mps2: Array
    switch_s: Array
    then_mps2: Array
    bend_grip: Array | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivenProfiles:
    """States (n, T, 6) and inputs (n, T - 1, 2) of the members on an even grid of times (T,)."""

    times_s: Array
    states: Array
    inputs: Array

    def paths(self) -> Paths:
        """For the test of clearance; the curvature is not needed there and left 0."""
        s, d, psi = (np.ascontiguousarray(self.states[..., k]) for k in (0, 1, 2))
        return Paths(s_m=s, d_m=d, heading_rad=psi, sine=np.sin(psi), cosine=np.cos(psi), curvature_1pm=np.zeros(1))

    def on_road(self, vehicle: Vehicle, road: Road) -> Array:
        """Which members (n,) keep to the road, by the corners' shadows."""
        s, d, psi = (self.states[..., k] for k in (0, 1, 2))
        _, aside = half_extent(psi, vehicle.length_m, vehicle.width_m)
        inside = ((d + aside).max(-1) <= road.left_edge_m) & ((d - aside).min(-1) >= road.right_edge_m)
        if road.road_end_s_m is not None:
            inside &= s.max(-1) + 0.5 * vehicle.length_m <= road.road_end_s_m
        return np.asarray(inside)

    def trajectory(self, member: int) -> Trajectory:
        return Trajectory.from_states(self.times_s, self.states[member], self.inputs[member])


def evasive_profiles(road: Road, vehicle: Vehicle, d_m: float, s_m: float = 0.0) -> EvasiveProfiles:
    """Every pair of a profile sideways and a profile along from d: some thousands."""
    limit = road.grip_mps2
    most = (min(-vehicle.acceleration_min_mps2, limit), min(vehicle.acceleration_max_mps2, limit))
    along = [(share, 0.0, share) for share in _STEADY] + [(a, t, then) for (a, then), t in itertools.product(_TURNS, _TURN_S)]
    half = 0.5 * vehicle.width_m
    lane = road.lane_of(d_m, s_m)
    ends = [d_m + side * beside for side in (1, -1) for beside in _BESIDE_M]
    ends += [road.lane_centre_m(lane + step, s_m) for step in (1, -1, 2, -2) if road.has_lane(lane + step, s_m)]
    ends = [d for d in ends if road.right_edge_m + half < d < road.left_edge_m - half]
    sideways = [(d_m, 0.0, 1.0, 1.6), *itertools.product(ends, _DELAYS_S, _GRIP, _BANDWIDTH_RADPS)]
    rows = np.array([(*side, *pace) for side in sideways for pace in along])
    target, delay, grip, bandwidth, first, switch, then = rows.T

    def asked(share: Array) -> Array:
        return np.asarray(share * np.where(share < 0.0, most[0], most[1]))

    return EvasiveProfiles(
        target_d_m=target,
        delay_s=delay,
        grip=grip,
        bandwidth_radps=bandwidth,
        first_mps2=asked(first),
        switch_s=switch,
        then_mps2=asked(then),
    )


def bend_profiles(road: Road, vehicle: Vehicle, d_m: float) -> EvasiveProfiles:
    """Every pair of a place near d and a pace, each slowing down in good time for bends: who drives as usual."""
    limit = road.grip_mps2
    most = min(vehicle.acceleration_max_mps2, limit)
    rows = np.array(list(itertools.product(_BEND_ASIDE_M, _BANDWIDTH_RADPS, _BEND_PACES, _BEND_GRIP)))
    aside, bandwidth, pace, grip = rows.T
    nothing, wanted = np.zeros(len(rows)), pace * np.where(pace < 0.0, limit, most)
    return EvasiveProfiles(
        target_d_m=d_m + aside,
        delay_s=nothing,
        grip=nothing + 1.0,
        bandwidth_radps=bandwidth,
        first_mps2=wanted,
        switch_s=nothing,
        then_mps2=wanted,
        bend_grip=grip,
    )


def lane_keeping(d_m: float) -> EvasiveProfiles:
    """One member, which keeps its d and its speed."""
    nothing = np.zeros(1)
    steady = {"first_mps2": nothing, "switch_s": nothing, "then_mps2": nothing}
    return EvasiveProfiles(
        target_d_m=np.full(1, d_m), delay_s=nothing, grip=np.ones(1), bandwidth_radps=np.full(1, _BANDWIDTH_RADPS[0]), **steady
    )


def drive_profiles(members: EvasiveProfiles, times_s: Array, host: HostState, vehicle: Vehicle, road: Road) -> DrivenProfiles:
    """The bicycle under the members' feedback: critically damped in the rear axle's offset and heading, its turning cut off at what
    the acceleration leaves of the friction circle and at the steering's own limits. A car that comes to rest stands."""
    count, steps = members.target_d_m.size, times_s.size
    x = [np.full(count, value) for value in host.to_vector()]
    states, inputs = np.empty((count, steps, 6)), np.empty((count, steps - 1, 2))
    states[:, 0] = np.stack(x, axis=-1)
    circle = members.grip * road.friction * GRAVITY_MPS2
    centre, wheelbase, straight = vehicle.centre_m, vehicle.wheelbase_m, road.is_straight
    slowed = None if members.bend_grip is None else _Bends.of(members.bend_grip, host, float(times_s[-1]), vehicle, road)
    for k in range(steps - 1):
        now, h = float(times_s[k]), float(times_s[k + 1] - times_s[k])
        s, d, psi, v, a, delta = x
        wanted = np.where(now < members.switch_s - 1e-9, members.first_mps2, members.then_mps2)
        if slowed is not None:
            wanted = np.minimum(wanted, (slowed.allowed_mps(s + _BEND_S * v) - v) / _BEND_S)
        wanted = np.clip(wanted, -circle, circle)
        jerk = np.clip((wanted - a) / h, vehicle.jerk_min_mps3, vehicle.jerk_max_mps3)
        topped = v + (a + 0.5 * jerk * h) * h > vehicle.speed_max_mps - 0.2
        jerk = np.where(topped, np.clip(-np.maximum(a, 0.0) / h, vehicle.jerk_min_mps3, 0.0), jerk)
        ahead = a + jerk * h
        rest = (v <= 0.0) | (v + 0.5 * (a + ahead) * h <= 0.0)
        pace = np.maximum(np.maximum(v, v + 0.5 * (a + ahead) * h), _SLOWEST_MPS)
        left = np.sqrt(np.maximum(circle**2 - np.maximum(a * a, ahead * ahead), 0.0)) / pace**2
        bend = 0.0 if straight else road.curvature_at(s)
        goal = np.where(now < members.delay_s - 1e-9, host.d_m, members.target_d_m)
        w = members.bandwidth_radps / pace
        turn = bend - w * w * (d - centre * np.sin(psi) - goal) - 2.0 * w * psi
        aim = np.clip(np.arctan(wheelbase * np.clip(turn, -left, left)), -vehicle.steering_max_rad, vehicle.steering_max_rad)
        rate = np.clip((aim - delta) / h, -vehicle.steering_rate_max_radps, vehicle.steering_rate_max_radps)
        jerk, rate = np.where(rest, np.where(v > 0.0, np.minimum(jerk, 0.0), 0.0), jerk), np.where(rest, 0.0, rate)
        span = np.where(rest, np.where(v > 0.0, np.minimum(times_to_rest(v, a, jerk), h), 0.0), h)
        u = (jerk, rate)

        def right_side(state: Any, u: tuple[Array, Array] = u) -> list[Any]:
            kappa = 0.0 if straight else road.curvature_at(state[0])
            return road_bicycle(state, u, kappa, wheelbase, centre, np)

        x = rk4(right_side, x, span)
        x[3], x[4] = np.where(rest, 0.0, x[3]), np.where(rest, 0.0, x[4])
        states[:, k + 1] = np.stack(x, axis=-1)
        inputs[:, k] = np.stack(u, axis=-1)
    return DrivenProfiles(times_s=times_s, states=states, inputs=inputs)


@dataclass(frozen=True, slots=True)
class _Bends:
    """The speed [m/s] that each member's share of the grip allows, over s from `begin_m` on: (members, n)."""

    begin_m: float
    table_mps: Array

    @classmethod
    def of(cls, shares: Array, host: HostState, lasts_s: float, vehicle: Vehicle, road: Road) -> _Bends:
        """Backwards from each bend, by braking gently before it."""
        s = host.s_m + np.arange(0.0, vehicle.speed_max_mps * (lasts_s + 1.0), _BEND_STEP_M)
        bend = np.maximum(np.abs(road.curvature_at(s)), 1e-6)
        rise = 2.0 * _BEND_BRAKING * road.grip_mps2 * s
        squared = shares[:, None] * road.grip_mps2 / bend + rise
        return cls(host.s_m, np.sqrt(np.minimum.accumulate(squared[:, ::-1], axis=1)[:, ::-1] - rise))

    def allowed_mps(self, s: Array) -> Array:
        at = np.clip(((s - self.begin_m) / _BEND_STEP_M).astype(np.intp), 0, self.table_mps.shape[1] - 1)
        return np.asarray(self.table_mps[np.arange(len(s)), at])
