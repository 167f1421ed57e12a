"""The constant-input prediction: a car that keeps its acceleration and its steering."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.manoeuvres.starts import Starts, rear_axle

PASSES = 4  # of the fixed point on a bend: each one gains a factor of kappa d
EVERY = 2  # steps of the lattice: the host that keeps its inputs is known so often


def constant_input(host: HostState, times_s: Array, vehicle: Vehicle, road: Road) -> Starts:
    """States at the times (T,) of an even grid from 0. A car that brakes to rest stands; one at top speed keeps it."""
    a, turn, c = host.acceleration_mps2, np.tan(host.steering_rad) / vehicle.wheelbase_m, vehicle.centre_m
    free = host.speed_mps + a * times_s
    v = np.clip(free, 0.0, max(vehicle.speed_max_mps, host.speed_mps))
    travelled = _sum(v, times_s)
    s0, d0, _, _ = rear_axle(host, vehicle, road)
    psi0 = host.heading_rad + float(road.curvature_at(host.s_m)) * c
    s, d = s0 + travelled, np.full_like(travelled, d0)
    for _ in range(1 if road.is_straight else PASSES):
        kappa = road.curvature_at(s)
        psi = psi0 + turn * travelled - _sum(kappa, s)
        s = s0 + _sum(np.cos(psi) / (1.0 - kappa * d), travelled)
        d = d0 + _sum(np.sin(psi), travelled)
    kappa = road.curvature_at(s)
    return Starts(
        s_m=s + c * np.cos(psi) / (1.0 - kappa * d),
        d_m=d + c * np.sin(psi) - 0.5 * kappa * (c * np.cos(psi)) ** 2,
        heading_rad=psi - kappa * c,
        speed_mps=v,
        acceleration_mps2=np.where(v == free, a, 0.0),
        steering_rad=np.full_like(travelled, host.steering_rad),
    )


def _sum(rate: Array, over: Array) -> Array:
    """Integral of `rate` over the steps of `over`, from 0."""
    return np.concatenate([np.zeros(1), np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(over))])
