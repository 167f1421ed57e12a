"""States in which manoeuvres begin, many at once, and what follows of them for the rear axle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle


@dataclass(frozen=True, slots=True, kw_only=True)
class Starts:
    """A `HostState` each: arrays that broadcast with the manoeuvres."""

    s_m: Array
    d_m: Array
    heading_rad: Array
    speed_mps: Array
    acceleration_mps2: Array
    steering_rad: Array

    def __getitem__(self, index: Any) -> Starts:
        parts = (self.s_m, self.d_m, self.heading_rad, self.speed_mps, self.acceleration_mps2, self.steering_rad)
        s, d, heading, speed, acceleration, steering = (q[index] for q in parts)
        return Starts(s_m=s, d_m=d, heading_rad=heading, speed_mps=speed, acceleration_mps2=acceleration, steering_rad=steering)


def rear_axle(start: HostState | Starts, vehicle: Vehicle, road: Road) -> tuple[Array, Array, Array, Array]:
    """s and d [m] of the rear axle; d' and d'' [1/m] over the distance that it drives."""
    c = vehicle.centre_m
    kappa0 = np.zeros(1) if road.is_straight else road.curvature_at(start.s_m)
    psi0 = start.heading_rad + kappa0 * c
    sine0, cosine0 = np.sin(psi0), np.cos(psi0)
    d0 = np.asarray(start.d_m - c * sine0 + 0.5 * kappa0 * (c * cosine0) ** 2)
    s0 = np.asarray(start.s_m - c * cosine0 / (1.0 - kappa0 * d0))
    turn0 = np.tan(start.steering_rad) / vehicle.wheelbase_m
    bend0 = np.asarray((turn0 - kappa0 * cosine0 / (1.0 - kappa0 * d0)) * cosine0)
    return s0, d0, sine0, bend0
