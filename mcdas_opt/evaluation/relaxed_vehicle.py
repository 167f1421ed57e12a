"""A car that can do more than any real one: what it cannot reach, nobody can."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle

STEP_S = 0.05
_FRICTION = 1.02  # of the road's: what the judge forgives; the plants have no more than the road's own
_LIMIT = 1.01  # of the vehicle's limits: what the judge forgives
EDGE_M = 0.02  # beyond the road's edge: what a drive is forgiven
_DIRECTIONS = np.linspace(0.0, 0.5 * np.pi, 25)[1:-1]
_SLOWEST_MPS = 1e-3
QUADRATURE_M = 3e-3  # what means over steps may lack of the integrals, over a whole manoeuvre


@dataclass(frozen=True, slots=True, kw_only=True)
class Beside:
    """How far the front or the rear bumper's middle can get sideways (T,) [m], and the weights (T, T - 1) with which the size of the
    lateral acceleration in a step counts for that at each time [s]."""

    most_m: Array
    weights_s: Array


@dataclass(frozen=True, kw_only=True)
class RelaxedVehicle:
    """Bounds over time on a car, for every way of driving it.

    A point mass at the rear axle with more friction than the road has; body, engine, brakes and steering only bound how quickly its
    acceleration comes about. Along the road the state is (place of the rear axle, speed). All vectors are over the times (T,), or
    over the steps between them (T - 1,). Bounds that build up in a step are taken at their mean in it: what is reached later counts less
    for a displacement, so that this is not too little (Chebyshev's sum inequality).
    """

    host: HostState
    vehicle: Vehicle
    road: Road
    duration_s: float

    @cached_property
    def times_s(self) -> Array:
        return np.round(np.arange(int(np.floor(self.duration_s / STEP_S + 1e-9)) + 1) * STEP_S, 9)

    @property
    def _middle_s(self) -> Array:
        return self.times_s[:-1] + 0.5 * STEP_S

    @cached_property
    def grip_mps2(self) -> float:
        return _FRICTION * self.road.friction * GRAVITY_MPS2

    @cached_property
    def bend_1pm(self) -> float:
        return self.road.sharpest_1pm

    @cached_property
    def reach_1(self) -> float:
        """The largest d kappa there is on the road."""
        return self.bend_1pm * max(self.road.left_edge_m, -self.road.right_edge_m)

    @cached_property
    def braking_mps2(self) -> Array:
        """Least acceleration in each step, negative."""
        least = max(_LIMIT * self.vehicle.acceleration_min_mps2, -self.grip_mps2)
        return np.maximum(least, self.host.acceleration_mps2 + _LIMIT * self.vehicle.jerk_min_mps3 * self._middle_s)

    @cached_property
    def driving_mps2(self) -> Array:
        """Largest acceleration in each step."""
        most = min(_LIMIT * self.vehicle.acceleration_max_mps2, self.grip_mps2)
        return np.minimum(most, self.host.acceleration_mps2 + _LIMIT * self.vehicle.jerk_max_mps3 * self._middle_s)

    @cached_property
    def slowest_mps(self) -> Array:
        return np.maximum(self.host.speed_mps + _summed(self.braking_mps2), 0.0)

    @cached_property
    def fastest_mps(self) -> Array:
        return np.minimum(self.host.speed_mps + _summed(self.driving_mps2), self.top_speed_mps)

    @property
    def top_speed_mps(self) -> float:
        return _LIMIT * self.vehicle.speed_max_mps

    @cached_property
    def _freedom_1pm(self) -> Array:
        """Largest difference between the curvature of the rear axle's way and the road's in each step, by the steering alone."""
        first = abs(self.host.steering_rad)
        turned = np.minimum(first + _LIMIT * self.vehicle.steering_rate_max_radps * self.times_s, _LIMIT * self.vehicle.steering_max_rad)
        bend = np.tan(turned) / self.vehicle.wheelbase_m
        held = float(np.tan(self.host.steering_rad)) / self.vehicle.wheelbase_m
        off = max(abs(held - kappa) for _, kappa in self.road.curvature)
        frame = self.bend_1pm * (self.reach_1 / (1.0 - self.reach_1) + 1.0 - np.cos(self._widest_rad))
        return np.asarray(np.maximum(0.5 * (bend[1:] + bend[:-1]) - abs(held), 0.0) + off + frame)

    @cached_property
    def _drift(self) -> Array:
        """How far sideways a car gets that does not begin along the road, or on a bend, where its ends point elsewhere than its middle."""
        turned = abs(np.sin(self.host.heading_rad)) + self.vehicle.centre_m * self.bend_1pm
        reach = self.vehicle.length_m * turned + 0.5 * self.bend_1pm * self.vehicle.length_m**2
        return np.asarray(reach + self.fastest_mps * turned * self.times_s)

    @cached_property
    def _follow_mps2(self) -> Array:
        """What following the bend itself amounts to at most, in each step: it comes on top of the grip, seen from the road."""
        return np.asarray(self.bend_1pm * self.fastest_mps[1:] ** 2 / (1.0 - self.reach_1))

    @cached_property
    def heading_rad(self) -> Array:
        """Largest angle to the road: by the steering, by the grip, by the width of the road."""
        bend = self._freedom_1pm
        pace = np.clip(np.sqrt(self.grip_mps2 / np.maximum(bend, 1e-9)), self.slowest_mps[1:], self.fastest_mps[1:])  # both bounds meet
        by_grip = self.grip_mps2 / np.maximum(pace, _SLOWEST_MPS) + self.bend_1pm * self.fastest_mps[1:] / (1.0 - self.reach_1)
        rate = np.minimum(np.maximum(pace, self.fastest_mps[1:] * (self.bend_1pm > 0.0)) * bend, by_grip)
        first = abs(self.host.heading_rad) + self.vehicle.centre_m * self.bend_1pm
        return np.minimum(first + _summed(rate), self._widest_rad)

    @cached_property
    def _widest_rad(self) -> float:
        """The angle at which the body spans the whole road."""
        angle = np.linspace(0.0, 0.5 * np.pi, 1571)
        car = self.vehicle
        span = car.length_m * np.sin(angle) + car.width_m * np.cos(angle)
        too_wide = span > self.road.left_edge_m - self.road.right_edge_m + 2.0 * EDGE_M + self.bend_1pm * car.length_m**2
        return float(angle[too_wide.argmax()]) if too_wide.any() else 0.5 * np.pi

    @cached_property
    def _aside_mps(self) -> float:
        """Largest speed across the road: gained and lost again at full grip between its edges."""
        turned = float(self.heading_rad[-1])
        width = self.road.left_edge_m - self.road.right_edge_m + 2.0 * EDGE_M + self.bend_1pm * self.vehicle.length_m**2
        room = width - self.vehicle.width_m * np.cos(turned) + 2.0 * self.vehicle.rear_overhang_m * np.sin(turned)
        return float(np.sqrt(max(room, 0.0) * (self.grip_mps2 + float(self._follow_mps2[-1]))))

    def weaving_mps(self, k: int) -> float:
        """The speed from which on the room between the edges bounds the heading in the step to time k more than the steering does."""
        sine = float(np.sin(self.heading_rad[k]))
        return self._aside_mps / max(sine, 1e-9) - float(self.braking_mps2[k - 1]) * STEP_S

    def short_mps(self, k: int, speed_mps: Array) -> Array:
        """By how much ds/dt can fall short of a speed in the step to time k, at most, for a car that weaves: linear in the speed up to
        `weaving_mps`, convex from there on."""
        slowest, fastest = speed_mps + self.braking_mps2[k - 1] * STEP_S, speed_mps + self.driving_mps2[k - 1] * STEP_S
        by_heading = fastest * (1.0 - np.cos(self.heading_rad[k]))
        by_room = slowest - np.sqrt(np.maximum(slowest**2 - self._aside_mps**2, 0.0))
        edge = self.weaving_mps(k)
        short = np.where(speed_mps < edge, by_heading, by_room)
        short = np.where(np.abs(speed_mps - edge) < 1e-6, np.maximum(by_heading, by_room), short)
        return np.asarray(short + fastest * self.reach_1)

    @property
    def faster(self) -> float:
        """Share by which it exceeds it, at most: the inside of a bend."""
        return 1.0 / (1.0 - self.reach_1) - 1.0

    @cached_property
    def turning_mps2(self) -> Array:
        """Largest acceleration across the way driven, beyond what follows the road, in each step."""
        return np.minimum(self.grip_mps2 + self._follow_mps2, self.fastest_mps[1:] ** 2 * self._freedom_1pm)

    @cached_property
    def across_mps2(self) -> Array:
        """Largest acceleration across the road, in each step."""
        leaning = np.maximum(-self.braking_mps2, self.driving_mps2) * np.sin(self.heading_rad[1:])
        return np.asarray(np.minimum(self.grip_mps2 + self._follow_mps2, self.turning_mps2 + leaning))

    @cached_property
    def _along_mps2(self) -> tuple[Array, Array]:
        """Least and largest acceleration along a straight road, in each step."""
        leaning = self.turning_mps2 * np.sin(self.heading_rad[1:])
        return np.maximum(-self.grip_mps2, self.braking_mps2 - leaning), np.minimum(self.grip_mps2, self.driving_mps2 + leaning)

    @cached_property
    def _weights_s(self) -> tuple[Array, NDArray[np.bool_]]:
        """Time left at the middle of each step, seen from each time; and which steps lie before it."""
        before = self.times_s[:, None] > self._middle_s
        return np.where(before, self.times_s[:, None] - self._middle_s, 0.0), before

    @cached_property
    def rear(self) -> Beside:
        """The rear bumper: the car turns away from where it steers to, so that it lags by overhang x heading."""
        left, before = self._weights_s
        lag = self.vehicle.rear_overhang_m / np.maximum(self.fastest_mps, _SLOWEST_MPS)
        weights = np.where(before, _mean_size(left - lag[:, None]), 0.0)
        return Beside(most_m=weights @ self.across_mps2 * STEP_S + QUADRATURE_M + self._drift, weights_s=weights)

    @cached_property
    def front(self) -> Beside:
        """The front bumper: it leads by (wheelbase + overhang) x heading."""
        left, before = self._weights_s
        ahead = self.vehicle.wheelbase_m + self.vehicle.front_overhang_m
        lead = ahead / np.maximum(self.slowest_mps, _SLOWEST_MPS)
        weights = np.where(before, left + lead[:, None], 0.0)
        sideways = left @ self.across_mps2 * STEP_S
        most = np.minimum(weights @ self.across_mps2 * STEP_S, sideways + ahead * np.sin(self.heading_rad))
        return Beside(most_m=most + QUADRATURE_M + self._drift, weights_s=weights)

    def along_m(self, k: int, beside: Beside, sideways_m: float) -> tuple[float, float]:
        """Least and largest way along the road at time k, beyond that at constant speed, for a bumper that is `sideways_m` aside then.

        Grip that goes into one is missing for the other: for every direction, the displacement that the friction circle allows in it.
        Only the lateral bound holds on a bend, or for a car that begins at an angle: there the range is not cut.
        """
        if self.bend_1pm > 0.0 or self.host.heading_rad:
            return -np.inf, np.inf
        p, q = np.cos(_DIRECTIONS)[:, None], np.sin(_DIRECTIONS)[:, None]
        left, across = self._weights_s[0][k], beside.weights_s[k]
        circle = self.grip_mps2 * np.hypot(p * left, q * across)
        low, high = self._along_mps2
        sides = q * across * self.across_mps2
        most = np.minimum(circle, p * left * high + sides).sum(-1) * STEP_S
        least = np.minimum(circle, sides - p * left * low).sum(-1) * STEP_S
        p, q = p[:, 0], q[:, 0]
        least, most = least + QUADRATURE_M, most + QUADRATURE_M
        return float((-(least - q * sideways_m) / p).max()), float(((most - q * sideways_m) / p).min())


def _summed(rate: Array) -> Array:
    return np.concatenate([np.zeros(1), np.cumsum(rate)]) * STEP_S


def _mean_size(weight: Array) -> Array:
    """The mean of |w| over a step in which w falls by STEP_S, from its value in the middle."""
    return np.where(np.abs(weight) < 0.5 * STEP_S, weight * weight / STEP_S + 0.25 * STEP_S, np.abs(weight))
