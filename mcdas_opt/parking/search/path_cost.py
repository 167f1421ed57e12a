"""What a path of arcs costs, in seconds, roughly: enough to rank paths before anything is driven."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.path import Arc, top_curvature
from mcdas_opt.parking.search.detours import Detours
from mcdas_opt.parking.search.reeds_shepp import WORD_TURNS, reeds_shepp

_GEAR_S = 0.8
_STEERING_SHARE = 0.6  # of the time that steering takes at standstill
_SPEED_SHARE = 0.7  # of the mean speed limit


@dataclass(frozen=True, slots=True)
class PathCost:
    """Length over speed, a cost per gear change, and a share of the time that steering takes at standstill."""

    speed_mps: float
    steering_s_per_1pm: float  # for a change of curvature
    radius_m: float
    detours: Detours | None = None

    @classmethod
    def of(cls, case: ParkingCase, detours: Detours | None = None) -> PathCost:
        car, top = case.vehicle, top_curvature(case.vehicle)
        lock_s = car.steering_max_rad / car.steering_rate_max_radps
        speed = _SPEED_SHARE * 0.5 * (case.limits.forward_mps + case.limits.reverse_mps)
        return cls(speed, _STEERING_SHARE * lock_s / top, 1.0 / top, detours)

    def step(self, direction0: Array, kappa0: Array, direction: Array, kappa: Array, length: Array) -> Array:
        """Of an arc after another one (direction 0: after none)."""
        change = (direction0 != 0.0) & (direction0 != direction)
        steer = np.where(direction0 == 0.0, 0.0, np.abs(kappa - kappa0))
        return np.asarray(length / self.speed_mps + _GEAR_S * change + self.steering_s_per_1pm * steer)

    def words(self, lengths: Array, direction0: Array, kappa0: Array) -> Array:
        """(n, 44) of Reeds-Shepp words after an arc; infinite where a word does not exist."""
        total = np.abs(lengths).sum(-1)
        sign = np.sign(lengths)
        changes = (sign[..., 1:] * sign[..., :-1] < 0.0).sum(-1) + (sign[..., 0] * direction0[:, None] < 0.0)
        turns = np.abs(np.diff(WORD_TURNS, axis=1)) * (np.abs(lengths[..., 1:]) > 1e-9)
        first_turn = np.abs(WORD_TURNS[:, 0] - kappa0[:, None] * self.radius_m)
        steer = turns.sum(-1) + np.where(direction0[:, None] == 0.0, 0.0, first_turn)
        value = total / self.speed_mps + _GEAR_S * changes + self.steering_s_per_1pm / self.radius_m * steer
        return np.where(np.isnan(value), np.inf, value)

    def path(self, arcs: tuple[Arc, ...]) -> float:
        """Of arcs one after another, from rest."""
        value = 0.0
        gear, kappa = 0.0, 0.0
        for arc in arcs:
            value += float(self.step(*(np.asarray(q) for q in (gear, kappa, arc.gear, arc.curvature, abs(arc.length)))))
            gear, kappa = arc.gear, arc.curvature
        return value

    def estimate(self, poses: Array, target: Array) -> Array:
        """Of the rest of the path from poses (n, 3) to `target`: Reeds-Shepp without obstacles, or a point's path round them."""
        free = np.zeros(len(poses))
        value = self.words(reeds_shepp(poses, target, self.radius_m), free, free).min(axis=1)
        if self.detours is None:
            return np.asarray(value)
        return np.asarray(np.maximum(value, self.detours.lengths(poses) / self.speed_mps))
