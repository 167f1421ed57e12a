"""What the optimiser's inputs make of the car: the equations of motion from the measured state, standstill included."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.stopping import held_step, time_to_stop
from mcdas_opt.native.binding import LastAddress
from mcdas_opt.native.library import library

_STARTS_MPS = 0.2  # a standing car drives off when the optimiser means it to go at least so fast
_STARTS_WITHIN_S = 0.5  # ... so soon: the first step of driving off is slower than that
_HELD_MPS2 = 1e-6  # who stops within a step stands at its end: no jerk there makes more of its deceleration than nearly nothing
_EASING = 0.95  # share of the jerk with which a stop, or the approach to top speed, can be eased
_steps = LastAddress()  # a grid's stay the same


def roll_out(host: HostState, planned_speed_mps: Array, inputs: Array, grid: TimeGrid, vehicle: Vehicle, road: Road) -> Trajectory:
    """The trajectory (N + 1 samples) of inputs (N, 2) from the measured state.

    Where the speed would fall through zero the brakes hold the car: it stands, with no acceleration, until the planned speed (N + 1) says
    that it drives off; until then it steers, if it ever does, and then it accelerates as the inputs mean it to by then. A jerk that would
    turn its deceleration round within the step in which it stops is lowered. Road beyond its knots keeps its curvature.
    """
    u = np.array(inputs, dtype=np.float64)
    planned = soon(np.asarray(planned_speed_mps, dtype=np.float64), grid)
    compiled = library()
    if compiled is None:
        return Trajectory.from_states(grid.times_s, interpreted(host, planned, u, grid, vehicle, road), u)
    states = np.empty((grid.nodes + 1, 6))
    states[0] = host.to_vector()
    bends = road.knots
    compiled.mcdas_drive(len(u), _steps.of(grid.steps_s), planned, _STARTS_MPS, _car(vehicle), bends.shape[1], bends, u, states)
    return Trajectory.from_states(grid.times_s, states, u)


def soon(planned_mps: Array, grid: TimeGrid) -> Array:
    """(N + 1,): the fastest that is planned between each time and half a second after it."""
    if planned_mps.min() >= _STARTS_MPS:
        return np.ascontiguousarray(planned_mps)
    last = np.searchsorted(grid.times_s, grid.times_s + _STARTS_WITHIN_S + 1e-9)
    return np.array([planned_mps[k:end].max() for k, end in enumerate(last)])


@lru_cache(maxsize=16)
def _car(vehicle: Vehicle) -> Array:
    return np.array([vehicle.wheelbase_m, vehicle.centre_m, vehicle.jerk_max_mps3])


def interpreted(host: HostState, planned_speed_mps: Array, u: Array, grid: TimeGrid, vehicle: Vehicle, road: Road) -> Array:
    """States (N + 1, 6) of the roll-out, where there is no compiler; the reference of the compiled one. Writes into `u` as that does."""
    x = [float(value) for value in host.to_vector()]

    def curvature(s: float) -> float:
        return 0.0 if road.is_straight else float(road.curvature_at(s))

    states = [x]
    meant = max(x[4], 0.0) if x[3] <= 1e-9 else x[4]  # acceleration, by the inputs so far
    leaves = max((k for k, speed in enumerate(planned_speed_mps.tolist()) if speed >= _STARTS_MPS), default=0)
    for k, h in enumerate(grid.steps_s.tolist()):
        stands = x[3] <= 1e-9 and x[4] <= 0.0
        jerk = float(u[k, 0]) + (meant - x[4]) / h
        meant += float(u[k, 0]) * h
        if stands and (planned_speed_mps[k + 1] < _STARTS_MPS or jerk <= 0.0):
            u[k] = (0.0, u[k, 1] if k < leaves else 0.0)
            x = [*x[:4], 0.0, x[5] + float(u[k, 1]) * h]
            states.append(x)
            continue
        if stands:
            u[k, 0] = min(jerk, vehicle.jerk_max_mps3)
        if x[4] < 0.0 <= x[4] + u[k, 0] * h and time_to_stop(x[3], x[4], float(u[k, 0])) < h:
            u[k, 0] = -(x[4] + _HELD_MPS2) / h
        x = held_step(x, (float(u[k, 0]), float(u[k, 1])), h, curvature, vehicle)
        states.append(x)
    return np.array(states)


def within_reach(host: HostState, vehicle: Vehicle) -> Array:
    """The measured state (s, d, psi, v, a, delta) for the optimiser, whose bounds on speed are hard: with the acceleration that can still
    be eased before standstill, or before top speed. What is cut off, the brakes' hold at standstill takes care of.
    """
    x = host.to_vector().copy()
    v = max(x[3], 0.0)
    easing = math.sqrt(2.0 * _EASING * vehicle.jerk_max_mps3 * v)
    topping = math.sqrt(2.0 * _EASING * -vehicle.jerk_min_mps3 * max(0.99 * vehicle.speed_max_mps - v, 0.0))
    x[4] = min(max(x[4], -easing), topping)
    return np.asarray(x)
