"""Tracking of plans by a dynamic vehicle: regulators designed with `control`, and the tyres' own curve between them and the wheels.

The outer one asks for lateral acceleration, of the path; the inner one, of the slip of the rear axle and the yaw rate that go with it, for
yaw acceleration. The front tyres' curve is solved for the slip that gives the force for it, and the wheels are turned by so much against
the way that the front axle moves. So what is asked for is what the tyres can give, and the rear axle is never asked to slide (Fiala's curve
solved for its slip: Kapania and Gerdes, Vehicle System Dynamics 53(12) 2015; slip and yaw rate instead of path alone: Beal and Gerdes, IEEE
Trans. Control Systems Technology 21(4) 2013). Gains: the discrete linear-quadratic regulator (Franklin, Powell and Workman, Digital Control
of Dynamic Systems, 3rd ed. 1998, ch. 9).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.rules import Array, positive
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.single_track import SLIPS_ABOVE_MPS, axle_loads, fiala, fiala_slip, slip_share

SPEEDS_MPS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 11.0, 15.0, 20.0, 26.0, 33.0, 41.0, 50.0)
GRIP_SHARE = 0.93  # of what an axle can give, asked of it at most: beyond, more slip gives hardly more, and takes long to take back
_STEERING_LAG_S = 0.02
PLENTY = 10.0  # friction, where nobody says how much there is: tyres in proportion to their slip


# the errors that cost as much as their regulator's input does [Bryson's rule]
_LATERAL_M, _LATERAL_SPEED_MPS, _COURSE_RAD, _LATERAL_ACCELERATION_MPS2 = 0.15, 0.32, 0.06, 1.35  # of the path; its input comes last
_SLIP_RAD, _YAW_RATE_RADPS, _YAW_ACCELERATION_RADPS2 = 0.05, 0.7, 4.5  # of slip and yaw rate
_SPEED_MPS, _ACCELERATION_MPS2, _JERK_MPS3 = 0.3, 1.5, 10.0  # along the road


@dataclass(frozen=True, slots=True, kw_only=True)
class LqrTracking:
    """Implements `Controller`: (jerk, steering rate) at a time of a plan for a car in a state.

    The plan is one of the no-slip bicycle. It asks for a path of the body centre, and a curvature and a speed on it: from those follow the
    slip of the rear axle and the yaw rate with which this car drives it; deviations are fed back. Beyond the plan's end its inputs are 0. A
    state without slip is that of a kinematic vehicle.

    `turned`: plans are made about the zero-sideslip point (`Chassis.zero_sideslip_point_m`), else about the rear axle. `grip` knows the
    friction; without it, tyre forces are taken to be in proportion to slip.
    """

    vehicle: Vehicle
    chassis: Chassis
    step_s: float
    path_gains: Array  # (len(SPEEDS_MPS), 2) on the lateral position and speed of the body centre
    slip_gains: Array  # (2,) on the slip of the rear axle and the yaw rate
    speed_gains: Array  # (2,) on the errors of speed and acceleration
    turned: bool = False
    grip: GripMonitor | None = None

    @classmethod
    def design(
        cls,
        vehicle: Vehicle,
        step_s: float = 0.01,
        turned: bool = False,
        grip: GripMonitor | None = None,
    ) -> LqrTracking:
        """The regulators for a vehicle, that of the path with gains at each of SPEEDS_MPS."""
        return replace(_designed(vehicle, positive("step_s", step_s, "s")), turned=turned, grip=grip)

    def command(self, trajectory: Trajectory, since_s: float, state: HostState) -> tuple[float, float]:
        if since_s >= trajectory.t_s[-1] - 1e-9:
            return 0.0, 0.0
        car, h = self.vehicle, self.step_s
        at, soon = sample(trajectory, since_s, h)
        jerk = self.jerk(at, soon, state)
        ahead = float(np.interp(since_s + self._lag_s(state), trajectory.t_s, trajectory.steering_rad))
        return within_limits(jerk, self._wheels(at, state, ahead), state, car, h)

    def jerk(self, at: HostState, soon: HostState, state: HostState) -> float:
        """The plan's, from now to a step later, and feedback of the errors of speed and acceleration."""
        off = np.array([state.speed_mps - at.speed_mps, state.acceleration_mps2 - at.acceleration_mps2])
        return (soon.acceleration_mps2 - at.acceleration_mps2) / self.step_s - float(self.speed_gains @ off)

    def _lag_s(self, state: HostState) -> float:
        """Delay of the lateral acceleration behind what is asked of the inner loop: slip grows by the yaw rate less the turn of the course,
        which is slip / (K_r v), so that slip'' + (k_r + g) slip' + (k_s + k_r g) slip follows with g = 1 / (K_r v)."""
        of_slip, of_yaw = self.slip_gains
        turn = 1.0 / (self.chassis.rear_slip_gradient * _moving(state))
        return float((of_yaw + turn) / (of_slip + of_yaw * turn))

    def _wheels(self, wanted: HostState, state: HostState, ahead_rad: float) -> float:
        """The angle of the wheels that the regulators ask for; `ahead_rad` is the plan's steering a lag later."""
        c, speed = self.chassis, _moving(state)
        deviation, least_speed = self._deviation(wanted, state), max(speed, SLIPS_ABOVE_MPS)
        # a vehicle that hardly moves is brought back as at that speed: within a length, not a time
        no_slip = math.atan(
            math.tan(ahead_rad) - c.wheelbase_m * float(gains_at(least_speed, self.path_gains) @ deviation) / least_speed**2
        )
        share = slip_share(state.speed_mps) if isinstance(state, SlidingState) else 0.0
        if share == 0.0:
            return no_slip
        grip = grip_left(self.grip, state)
        most = GRIP_SHARE * grip * GRAVITY_MPS2
        asked = speed**2 * math.tan(ahead_rad) / c.wheelbase_m - float(gains_at(speed, self.path_gains) @ deviation)
        asked = min(max(asked, -most), most)
        aside, yaw_rate = state.turning(c.wheelbase_m)
        of_front, of_rear = (
            (stiffness, grip * load)
            for stiffness, load in zip(
                (c.cornering_stiffness_front_nprad, c.cornering_stiffness_rear_nprad), axle_loads(c, state.acceleration_mps2), strict=True
            )
        )
        slip, course = -math.atan2(aside, speed), math.atan2(aside + c.wheelbase_m * yaw_rate, speed)
        wanted_slip = fiala_slip(c.mass_kg * asked * c.cog_to_front_axle_m / c.wheelbase_m, *of_rear)
        turning = self._turning(wanted_slip - slip, asked / speed - yaw_rate, grip * GRAVITY_MPS2)
        force = (c.cog_to_rear_axle_m * fiala(slip, *of_rear) + c.yaw_inertia_kgm2 * turning) / c.cog_to_front_axle_m
        return share * (course + fiala_slip(force, *of_front, share=GRIP_SHARE)) + (1.0 - share) * no_slip

    def _turning(self, slip_off: float, yaw_rate_off: float, grip_mps2: float) -> float:
        """Yaw acceleration asked for: by the regulator, but slip grows no faster than can be stopped with a quarter of the yaw acceleration
        that the grip of one axle gives (mu g / L, with a yaw inertia of m a b)."""
        of_slip, of_yaw = (float(gain) for gain in self.slip_gains)
        most = math.sqrt(0.5 * grip_mps2 / self.chassis.wheelbase_m * abs(slip_off))
        return of_yaw * (yaw_rate_off + min(max(of_slip / of_yaw * slip_off, -most), most))

    def _deviation(self, wanted: HostState, state: HostState) -> Array:
        """(2,) how far the body centre is to the left of the plan's, and how fast it goes there."""
        car, c = self.vehicle, self.chassis
        aside, yaw_rate = state.turning(c.wheelbase_m)
        along, across = state.s_m - wanted.s_m, state.d_m - wanted.d_m
        behind = c.zero_sideslip_point_m(state.speed_mps) if self.turned else 0.0
        planned = (car.centre_m - behind) * state.speed_mps * math.tan(wanted.steering_rad) / c.wheelbase_m
        moves = state.speed_mps * math.sin(state.heading_rad - wanted.heading_rad) + aside + car.centre_m * yaw_rate
        return np.array([across * math.cos(wanted.heading_rad) - along * math.sin(wanted.heading_rad), moves - planned])


@cache
def _designed(vehicle: Vehicle, step_s: float) -> LqrTracking:
    path = [
        _regulator(step_s, (_LATERAL_M**-2, _LATERAL_SPEED_MPS**-2 + (_COURSE_RAD * speed) ** -2), _LATERAL_ACCELERATION_MPS2)
        for speed in SPEEDS_MPS
    ]
    slip = _regulator(step_s, (_SLIP_RAD**-2, _YAW_RATE_RADPS**-2), _YAW_ACCELERATION_RADPS2)
    along = _regulator(step_s, (_SPEED_MPS**-2, _ACCELERATION_MPS2**-2), _JERK_MPS3)
    path_gains = np.array(path)
    path_gains.setflags(write=False)
    return LqrTracking(
        vehicle=vehicle, chassis=Chassis.of(vehicle), step_s=step_s, path_gains=path_gains, slip_gains=slip, speed_gains=along
    )


def _regulator(step_s: float, costs: tuple[float, float], input_weight: float) -> Array:
    """(2,) gains of a double integrator, sampled: of an error and its rate, whose own rate is the input."""
    import control

    moves = np.array([[1.0, step_s], [0.0, 1.0]]), np.array([[0.5 * step_s**2], [step_s]])
    gains = np.array(control.dlqr(*moves, np.diag(costs), np.array([[input_weight**-2]]))[0][0], dtype=np.float64)
    gains.setflags(write=False)
    return gains


def _moving(state: HostState) -> float:
    return max(state.speed_mps, SPEEDS_MPS[0])


def sample(trajectory: Trajectory, t: float, h: float) -> tuple[HostState, HostState]:
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


def within_limits(jerk_mps3: float, wheels_rad: float, state: HostState, car: Vehicle, step_s: float) -> tuple[float, float]:
    """Jerk, and the steering rate towards this angle of the wheels, within the vehicle's limits."""
    rate = (wheels_rad - state.steering_rad) / _STEERING_LAG_S
    most = min(car.steering_rate_max_radps, max((car.steering_max_rad - state.steering_rad) / step_s, 0.0))
    least = -min(car.steering_rate_max_radps, max((car.steering_max_rad + state.steering_rad) / step_s, 0.0))
    return min(max(jerk_mps3, car.jerk_min_mps3), car.jerk_max_mps3), min(max(rate, least), most)


def grip_left(grip: GripMonitor | None, state: HostState) -> float:
    """What is left of friction beside the acceleration along the car, as a share of the load."""
    friction = PLENTY if grip is None else grip.friction
    return math.sqrt(max(friction**2 - (state.acceleration_mps2 / GRAVITY_MPS2) ** 2, 1e-6))


def gains_at(speed: float, table: Array) -> Array:
    """Gains scheduled over SPEEDS_MPS, (len(SPEEDS_MPS), n) -> (n,); held beyond the grid."""
    return np.array([np.interp(speed, SPEEDS_MPS, column) for column in table.T])
