"""A car that slips follows a plan that does not: feed-forward through understeer, feedback designed with `control`.

Lateral error model: Rajamani, Vehicle Dynamics and Control, 2nd ed. 2012, sections 2.5 and 3.1, with the steering angle as a further state
and the steering rate as input; gains: the discrete linear-quadratic regulator (Franklin, Powell and Workman, Digital Control of Dynamic
Systems, 3rd ed. 1998, ch. 9) on a grid of speeds, linear in between.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.rules import Array, positive
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.single_track import lateral_model

SPEEDS_MPS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 11.0, 15.0, 20.0, 26.0, 33.0, 41.0, 50.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingWeights:
    """The error of each that costs as much as `steering_rate_radps` does [Bryson's rule]."""

    lateral_m: float = 0.15
    lateral_speed_mps: float = 1.0
    heading_rad: float = 0.06
    yaw_rate_radps: float = 0.3
    steering_rad: float = 0.2
    steering_rate_radps: float = 0.25
    speed_mps: float = 0.3
    acceleration_mps2: float = 1.5
    jerk_mps3: float = 10.0

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            positive(name, getattr(self, name))


def error_model(chassis: Chassis, centre_m: float, speed: float, step_s: float) -> tuple[Array, Array]:
    """Sampled (A (5, 5), B (5, 1)) of the errors (lateral of the body centre [m], lateral speed of the rear axle [m/s], heading [rad],
    yaw rate [rad/s], steering [rad]) under a steering rate [rad/s] held over each step, at a constant speed [m/s]."""
    import control

    q, b = lateral_model(chassis, speed), chassis.cog_to_rear_axle_m
    a11, a12 = q.a11 - b * q.a21, q.a12 - b * q.a22  # at the rear axle: vy - b r
    a = [
        [0.0, 1.0, speed, centre_m, 0.0],
        [0.0, a11, 0.0, a12 + b * a11, q.b1 - b * q.b2],
        [0.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, q.a21, 0.0, q.a22 + b * q.a21, q.b2],
        [0.0] * 5,
    ]
    sampled = control.sample_system(control.ss(a, [[0.0]] * 4 + [[1.0]], np.eye(5), np.zeros((5, 1))), step_s, method="zoh")
    return np.asarray(sampled.A, dtype=np.float64), np.asarray(sampled.B, dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True)
class LqrTracking:
    """Implements the controller's seat: (jerk, steering rate) at a time of a plan for a car in a state.

    The plan is one of the no-slip bicycle. It asks for a path of the body centre, and a curvature and a speed on it: from those follow the
    yaw rate, the slip of the rear axle and the steering (understeer and lag included) with which this car drives it; deviations are fed
    back. Beyond the plan's end its inputs are 0. A state that says nothing of slip is taken to have none.

    `turned` plans are of the bicycle that has its rear axle where this car moves along its own axis (`Chassis.rolling_point_m`): their
    heading is the car's own. The heading of others is the course of the rear axle.
    """

    vehicle: Vehicle
    chassis: Chassis
    step_s: float
    gains: Array  # (len(SPEEDS_MPS), 5)
    speed_gains: Array  # (2,) on the errors of speed and acceleration
    turned: bool = False

    @classmethod
    def design(cls, vehicle: Vehicle, weights: TrackingWeights | None = None, step_s: float = 0.01, turned: bool = False) -> LqrTracking:
        """The regulator for a vehicle, with gains at each of SPEEDS_MPS."""
        return replace(_designed(vehicle, weights or TrackingWeights(), positive("step_s", step_s, "s")), turned=turned)

    def gain(self, speed: float) -> Array:
        """(5,) gains at a speed, in the order of `error_model`; held beyond the grid."""
        return np.array([np.interp(speed, SPEEDS_MPS, column) for column in self.gains.T])

    def command(self, trajectory: Trajectory, since_s: float, state: HostState) -> tuple[float, float]:
        if since_s >= trajectory.t_s[-1] - 1e-9:
            return 0.0, 0.0
        car, h = self.vehicle, self.step_s
        at, soon = _sample(trajectory, since_s, h)
        speed = max(state.speed_mps, SPEEDS_MPS[0])
        lag = lateral_model(self.chassis, speed).yaw_lag_s
        now, then = (self._steering(trajectory, t, speed, lag) for t in (since_s, since_s + h))
        rate = (then - now) / h - float(self.gain(speed) @ self._errors(at, state, speed, now))
        jerk = (soon.acceleration_mps2 - at.acceleration_mps2) / h
        off = np.array([state.speed_mps - at.speed_mps, state.acceleration_mps2 - at.acceleration_mps2])
        jerk -= float(self.speed_gains @ off)
        most = min(car.steering_rate_max_radps, max((car.steering_max_rad - state.steering_rad) / h, 0.0))
        least = -min(car.steering_rate_max_radps, max((car.steering_max_rad + state.steering_rad) / h, 0.0))
        return min(max(jerk, car.jerk_min_mps3), car.jerk_max_mps3), min(max(rate, least), most)

    def _steering(self, trajectory: Trajectory, t: float, speed: float, lag: float) -> float:
        """The wheel angle at time t: the plan's curvature a lag ahead, and what the front slips more than the rear there."""
        planned = float(np.interp(t + lag, trajectory.t_s, trajectory.steering_rad))
        lateral = speed**2 * math.tan(planned) / self.chassis.wheelbase_m
        return planned + self.chassis.understeer_gradient * lateral

    def _errors(self, wanted: HostState, state: HostState, speed: float, steering: float) -> Array:
        c = self.chassis
        turn = math.tan(wanted.steering_rad) / c.wheelbase_m
        rear_slip = c.rear_slip_gradient * speed**2 * turn
        aside, yaw_rate = 0.0, state.speed_mps * math.tan(state.steering_rad) / c.wheelbase_m
        if isinstance(state, SlidingState):
            aside, yaw_rate = state.lateral_speed_mps, state.yaw_rate_radps
        along, across = state.s_m - wanted.s_m, state.d_m - wanted.d_m
        return np.array(
            [
                across * math.cos(wanted.heading_rad) - along * math.sin(wanted.heading_rad),
                aside + rear_slip * speed,
                state.heading_rad - wanted.heading_rad - (0.0 if self.turned else rear_slip),
                yaw_rate - state.speed_mps * turn,
                state.steering_rad - steering,
            ]
        )


@cache
def _designed(vehicle: Vehicle, weights: TrackingWeights, step_s: float) -> LqrTracking:
    import control

    w, chassis = weights, Chassis.of(vehicle)
    each = (w.lateral_m, w.lateral_speed_mps, w.heading_rad, w.yaw_rate_radps, w.steering_rad)
    state_cost, input_cost = np.diag([q**-2 for q in each]), np.array([[w.steering_rate_radps**-2]])
    gains = [control.dlqr(*error_model(chassis, vehicle.centre_m, v, step_s), state_cost, input_cost)[0][0] for v in SPEEDS_MPS]
    along = np.array([[1.0, step_s], [0.0, 1.0]]), np.array([[0.5 * step_s**2], [step_s]])
    speed_gains = control.dlqr(*along, np.diag([w.speed_mps**-2, w.acceleration_mps2**-2]), np.array([[w.jerk_mps3**-2]]))[0][0]
    fixed = [np.array(value, dtype=np.float64) for value in (gains, speed_gains)]
    for value in fixed:
        value.setflags(write=False)
    return LqrTracking(vehicle=vehicle, chassis=chassis, step_s=step_s, gains=fixed[0], speed_gains=fixed[1])


def _sample(trajectory: Trajectory, t: float, h: float) -> tuple[HostState, HostState]:
    """The plan's state at t and a step later: linear between samples, but the speed, which is the integral of the acceleration."""
    k = min(max(int(np.searchsorted(trajectory.t_s, t + 1e-9, side="right")) - 1, 0), len(trajectory) - 2)
    first, second = trajectory.states[k], trajectory.states[k + 1]
    span = float(trajectory.t_s[k + 1] - trajectory.t_s[k])
    found = []
    for moment in (t, t + h):
        part = (moment - float(trajectory.t_s[k])) / span
        x = first + part * (second - first)
        x[3] += 0.5 * part * (part - 1.0) * span * (second[4] - first[4])
        found.append(HostState.from_vector(x))
    return found[0], found[1]
