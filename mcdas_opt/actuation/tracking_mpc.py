"""Tracking of plans by a short linear time-varying model predictive controller of the front wheels.

Source: Falcone, Borrelli, Asgari, Tseng and Hrovat, Predictive active steering control for autonomous vehicle systems, IEEE Trans. Control
Systems Technology 15(3) 2007, section V (the single track, linearised anew in every step; bounds on the front tyres' slip). Tyres are
Fiala's, along the chord from the present slip to the one that the plan needs next. The quadratic program is condensed to the steering
rates and solved with OSQP (Stellato et al., Math. Prog. Comp. 12, 2020).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.actuation.lateral_lqr import GRIP_SHARE, PLENTY, LqrTracking, sample
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.single_track import SLIPS_ABOVE_MPS, axle_loads, fiala, fiala_slip

STEPS, STEP_S = 16, 0.04  # of the horizon
NEEDED = 4  # the step whose lateral acceleration tyres are linearised for
_LEAST_SLOPE = 0.05  # of a tyre that slides, over its stiffness: it is not without effect
_SHORT_RAD = 1e-3
_SLACK_PER_RAD = 1e4  # for slip beyond the bound

# the errors that cost as much as a steering rate of _RATE_RADPS [Bryson's rule]: lateral position and speed, yaw rate
_LATERAL_M, _LATERAL_SPEED_MPS, _YAW_RATE_RADPS, _RATE_RADPS = 0.15, 0.3, 0.1, 1.0


@dataclass(slots=True, kw_only=True)
class TrackingMpc:
    """Implements `Controller`; plans and states as `LqrTracking`, which minds the speed, and the wheels of a car that hardly slips."""

    vehicle: Vehicle
    step_s: float = 0.01
    turned: bool = False
    grip: GripMonitor | None = None
    _solve: Callable[[Array, Array, Array, Array, Array], Array | None] | None = None

    def command(self, trajectory: Trajectory, since_s: float, state: HostState) -> tuple[float, float]:
        slow = LqrTracking.design(self.vehicle, self.step_s, turned=self.turned, grip=self.grip)
        jerk, rate = slow.command(trajectory, since_s, state)
        if not isinstance(state, SlidingState) or state.speed_mps < SLIPS_ABOVE_MPS or since_s >= trajectory.t_s[-1] - 1e-9:
            return jerk, rate
        rates = self._rates(trajectory, since_s, state)
        return jerk, rate if rates is None else self._within_limits(float(rates[0]), state)

    def _within_limits(self, rate: float, state: HostState) -> float:
        car = self.vehicle
        most = min(car.steering_rate_max_radps, max((car.steering_max_rad - state.steering_rad) / self.step_s, 0.0))
        least = -min(car.steering_rate_max_radps, max((car.steering_max_rad + state.steering_rad) / self.step_s, 0.0))
        return min(max(rate, least), most)

    def _rates(self, trajectory: Trajectory, since_s: float, state: SlidingState) -> Array | None:
        """(STEPS,) steering rates of the horizon; None where the solver has none."""
        car, c, v = self.vehicle, Chassis.of(self.vehicle), state.speed_mps
        at, _ = sample(trajectory, since_s, self.step_s)
        behind = c.zero_sideslip_point_m(v) if self.turned else 0.0
        times = since_s + STEP_S * np.arange(STEPS + 1)
        bend = np.tan(np.interp(times, trajectory.t_s, trajectory.steering_rad)) / car.wheelbase_m
        model, begin, most_slip = self._model(state, v**2 * float(bend[NEEDED]))
        lead = car.centre_m - behind
        course = at.heading_rad + math.atan(lead * math.tan(at.steering_rad) / car.wheelbase_m)  # of the plan's body centre
        along, across = state.s_m - at.s_m, state.d_m - at.d_m
        begin[0] = across * math.cos(course) - along * math.sin(course)
        begin[1] = state.heading_rad - course
        turned = v * 0.5 * (bend[1:] + bend[:-1]) * STEP_S + lead * np.diff(bend)  # of the plan's course, in each step
        free, forced = _condensed(model, begin, turned)

        # outputs that cost: lateral error, its rate, yaw rate less the plan's
        to_centre = car.centre_m - c.cog_to_rear_axle_m
        outputs = np.array([[1.0, 0.0, 0.0, 0.0, 0.0], [0.0, v, 1.0, to_centre, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0]])
        outputs /= np.array([[_LATERAL_M], [_LATERAL_SPEED_MPS], [_YAW_RATE_RADPS]])
        weighted = np.einsum("oj,kji->koi", outputs, forced)  # (STEPS, 3, STEPS)
        off = free @ outputs.T
        off[:, 2] -= v * bend[1:] / _YAW_RATE_RADPS
        flat = weighted.reshape(-1, STEPS)
        hessian = np.zeros((STEPS + 1, STEPS + 1))
        hessian[:STEPS, :STEPS] = flat.T @ flat + np.eye(STEPS) / _RATE_RADPS**2
        hessian[STEPS, STEPS] = _SLACK_PER_RAD
        gradient = np.append(flat.T @ off.reshape(-1), _SLACK_PER_RAD)

        slip = np.array([0.0, 0.0, -1.0 / v, -c.cog_to_front_axle_m / v, 1.0])  # of the front axle
        slips, slips_free = np.einsum("j,kji->ki", slip, forced), free @ slip
        wheels, wheels_free = forced[:, 4, :], free[:, 4]
        one, none = np.ones((STEPS, 1)), np.zeros((STEPS, 1))
        rows = np.block(
            [
                [np.eye(STEPS), none],
                [wheels, none],
                [slips, -one],
                [-slips, -one],
                [np.zeros((1, STEPS)), np.ones((1, 1))],
            ]
        )
        steering, rate = car.steering_max_rad, car.steering_rate_max_radps
        upper = np.concatenate([np.full(STEPS, rate), steering - wheels_free, most_slip - slips_free, most_slip + slips_free, [math.inf]])
        lower = np.concatenate([np.full(STEPS, -rate), -steering - wheels_free, np.full(2 * STEPS, -math.inf), [0.0]])
        if self._solve is None:
            self._solve = _solver(hessian, rows)
        return self._solve(hessian, gradient, rows, lower, upper)

    def _model(self, state: SlidingState, lateral_mps2: float) -> tuple[tuple[Array, Array, Array], Array, float]:
        """((A, b, w) of one step, x(0), the front tyres' largest slip), with x+ = A x + b rate + w: x = (lateral error, heading against the
        plan's course, lateral speed and yaw rate of the centre of gravity, wheels). `lateral_mps2` is what the plan needs next."""
        from scipy.linalg import expm

        c, v = Chassis.of(self.vehicle), state.speed_mps
        a, b, m, inertia = c.cog_to_front_axle_m, c.cog_to_rear_axle_m, c.mass_kg, c.yaw_inertia_kgm2
        aside, r, delta = state.lateral_speed_mps + b * state.yaw_rate_radps, state.yaw_rate_radps, state.steering_rad
        friction = PLENTY if self.grip is None else self.grip.friction
        left = math.sqrt(max(friction**2 - (state.acceleration_mps2 / GRAVITY_MPS2) ** 2, 1e-6))
        loads = axle_loads(c, state.acceleration_mps2)
        slips = delta - math.atan2(aside + a * r, v), -math.atan2(aside - b * r, v)
        stiffness = c.cornering_stiffness_front_nprad, c.cornering_stiffness_rear_nprad
        (front, slope_f), (rear, slope_r) = (
            _chord(slip, m * lateral_mps2 * lever / c.wheelbase_m, stiff, left * load)
            for slip, lever, stiff, load in zip(slips, (b, a), stiffness, loads, strict=True)
        )
        rates = np.zeros((7, 7))  # of (x, rate, 1)
        rates[0, 1:4] = v, 1.0, self.vehicle.centre_m - b
        rates[1, 3] = 1.0
        for row, lever_f, lever_r in ((2, 1.0 / m, 1.0 / m), (3, a / inertia, -b / inertia)):
            rates[row, 2] = -(slope_f * lever_f + slope_r * lever_r) / v
            rates[row, 3] = (-a * slope_f * lever_f + b * slope_r * lever_r) / v
            rates[row, 4] = slope_f * lever_f
            rates[row, 6] = (front - slope_f * slips[0]) * lever_f + (rear - slope_r * slips[1]) * lever_r
        rates[2, 3] -= v
        rates[4, 5] = 1.0
        step = expm(STEP_S * rates)
        most = fiala_slip(1.0, stiffness[0] / max(left * loads[0], 1.0), 1.0, share=GRIP_SHARE)
        return (step[:5, :5], step[:5, 5], step[:5, 6]), np.array([0.0, 0.0, aside, r, delta]), most


def _chord(slip: float, needed: float, stiffness: float, limit: float) -> tuple[float, float]:
    """(force, slope) of a tyre at a slip angle: along the chord to where it gives the force that is needed; its tangent if here."""
    force, there = fiala(slip, stiffness, limit), fiala_slip(needed, stiffness, limit, share=GRIP_SHARE)
    if abs(there - slip) < _SHORT_RAD:
        there = slip + _SHORT_RAD
    slope = (fiala(there, stiffness, limit) - force) / (there - slip)
    return force, max(slope, _LEAST_SLOPE * stiffness)


def _condensed(model: tuple[Array, Array, Array], begin: Array, turned: Array) -> tuple[Array, Array]:
    """(free (STEPS, 5), forced (STEPS, 5, STEPS)): states 1 .. STEPS are free + forced @ rates."""
    matrix, column, drift = model
    free, forced = np.empty((STEPS, 5)), np.zeros((STEPS, 5, STEPS))
    x, effect = begin, np.zeros((5, STEPS))
    for k in range(STEPS):
        x = matrix @ x + drift
        x[0] -= matrix[0, 1] * 0.5 * turned[k]  # the course turns evenly within the step
        x[1] -= turned[k]
        effect = matrix @ effect
        effect[:, k] += column
        free[k], forced[k] = x, effect
    return free, forced


def _solver(hessian: Array, rows: Array) -> Callable[[Array, Array, Array, Array, Array], Array | None]:
    """A solver for problems of that shape, that begins each where the last one ended."""
    import osqp
    from scipy.sparse import csc_matrix

    upper = np.triu(np.ones_like(hessian)) > 0.0
    across = np.ones_like(rows, dtype=bool)
    program: Any = osqp.OSQP()
    order = upper.T  # columns first
    program.setup(
        csc_matrix((hessian.T[order], np.nonzero(order)[1], np.append(0, np.cumsum(upper.sum(axis=0)))), shape=hessian.shape),
        np.zeros(len(hessian)),
        csc_matrix((rows.T[across.T], np.nonzero(across.T)[1], np.append(0, np.cumsum(across.sum(axis=0)))), shape=rows.shape),
        np.full(len(rows), -math.inf),
        np.full(len(rows), math.inf),
        verbose=False,
        eps_abs=1e-4,
        eps_rel=1e-4,
        max_iter=200,
        polishing=False,
    )

    def solve(hessian: Array, gradient: Array, rows: Array, lower: Array, upper_bound: Array) -> Array | None:
        program.update(Px=hessian.T[order], Ax=rows.T[across.T], q=gradient, l=lower, u=upper_bound)
        found = program.solve(raise_error=False)
        return np.asarray(found.x[:STEPS]) if found.info.status_val in (1, 2) or found.info.status == "maximum iterations reached" else None

    return solve
