"""Members of a family driven exactly: the bicycle follows each of them within its limits, sample by sample."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.dynamics.stopping import times_to_rest
from mcdas_opt.manoeuvres.family import Rolled

_BANDWIDTH_RADPS = 1.5  # of the feedback that takes out what the grid's steering, linear between samples, leaves over
_SPEED_FLOOR_MPS = 2.0
_SHARE = 0.99


def driven(rolled: Rolled, host: HostState, vehicle: Vehicle, road: Road) -> tuple[Trajectory, ...]:
    """One trajectory for each member (leading axis; one axis only), from the host's own state, sampled on the family's grid.

    Inputs are constant between samples and the states are the bicycle's, so that nothing is left for the judge to doubt but the
    limits. Where the member comes to rest the car stands.
    """
    times = rolled.times_s
    count, steps = rolled.paths.s_m.shape
    speed, wanted_a = (np.broadcast_to(q, (count, steps)) for q in (rolled.speeds.speed_mps, rolled.speeds.acceleration_mps2))
    x = [np.full(count, value) for value in host.to_vector()]
    states, inputs = np.empty((count, steps, 6)), np.empty((count, steps - 1, 2))
    states[:, 0] = np.stack(x, axis=-1)
    fastest = _SHARE * vehicle.steering_rate_max_radps
    most = _SHARE * vehicle.steering_max_rad
    straight = road.is_straight
    for k in range(steps - 1):
        h = float(times[k + 1] - times[k])
        v, a = x[3], x[4]
        standing, stopping = speed[:, k] <= 0.0, (speed[:, k] > 0.0) & (speed[:, k + 1] <= 0.0)
        jerk = (wanted_a[:, k + 1] - a) / h
        jerk = np.where(stopping, np.where(v + a * h > 0.0, vehicle.jerk_min_mps3, 0.0), np.where(standing, 0.0, jerk))
        pace = np.maximum(v, _SPEED_FLOOR_MPS)
        off, turned = x[1] - rolled.paths.d_m[:, k], x[2] - rolled.paths.heading_rad[:, k]
        back = (_BANDWIDTH_RADPS / pace) ** 2 * off + 2.0 * _BANDWIDTH_RADPS / pace * turned
        target = np.clip(rolled.steering_rad[:, k + 1] - np.arctan(vehicle.wheelbase_m * back), -most, most)
        rate = np.where(standing | stopping, 0.0, np.clip((target - x[5]) / h, -fastest, fastest))
        # the step of a car that comes to rest ends there
        span = np.where(standing, 0.0, np.where(stopping, np.minimum(h, times_to_rest(v, a, jerk)), h))
        u = (jerk, rate)

        def right_side(state: Any, u: tuple[Array, Array] = u) -> list[Any]:
            kappa = 0.0 if straight else road.curvature_at(state[0])
            return road_bicycle(state, u, kappa, vehicle.wheelbase_m, vehicle.centre_m, np)

        x = rk4(right_side, x, span)
        rest = standing | stopping
        x[3], x[4] = np.where(rest, 0.0, x[3]), np.where(rest, 0.0, x[4])
        states[:, k + 1] = np.stack(x, axis=-1)
        inputs[:, k] = np.stack(u, axis=-1)
    return tuple(Trajectory.from_states(times, states[i], inputs[i]) for i in range(count))
