"""Cars of others as plants: TU Munich's single-track drift model and multi-body model, on Pacejka's tyres.

Source: Althoff and Wuersching, CommonRoad: Vehicle Models, 2020; package commonroad-vehicle-models (extra `vehicle-models`), its vehicle
2, a BMW 320i. Tyres: Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, section 4.3.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.errors import of_extra
from mcdas_opt.simulation.actuators import Actuators, Applied
from mcdas_opt.simulation.dynamic_plant import in_steady_turn
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.kinematic_plant import KinematicPlant

SLOW_MPS, FAST_MPS = 2.0, 2.5  # below the first it goes over to the no-slip bicycle, above the second back
_RELEASED = 2.0  # a wheel that slips by so many times what gives the most force gets no torque any more
_STABLE = 2.0  # of rk4, in steps times the fastest rate: it is stable up to 2.78
_LOADED = 1.5  # a wheel's load over its static one, at most

_OF_MASS = ("m", "m_s", "m_uf", "m_ur", "I_Phi_s", "I_y_s", "I_xz_s", "I_uf", "I_ur", "I_y_w")
_OF_FORCE = ("K_sf", "K_sdf", "K_sr", "K_sdr", "K_ras", "K_tsf", "K_tsr", "K_rad", "K_zt")


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleModel:
    """What differs between the package's models; `x` is their state, `p` their parameters, speeds are at the centre of gravity."""

    parameters: Any
    rates: Callable[[list[float], list[float], Any], list[float]]  # dx/dt under (steering rate, acceleration)
    begin: Callable[[list[float], Any], list[float]]  # of (x, y, steering, speed, heading, yaw rate, slip angle)
    velocity: Callable[[list[float]], tuple[float, float]]  # forward and to the left [m/s]
    lateral_acceleration: Callable[[list[float], list[float]], float]  # of a state and its rates [m/s^2]
    wheels: tuple[tuple[int, bool, int], ...]  # index of its speed in the state, whether at the front, which side (1 left, 0 axle)


class VehicleModelPlant:
    """One of the package's models in the loop, by fourth-order Runge-Kutta in as many equal parts of STEP_S as its wheels need.

    The vehicle's file gives limits, mass, yaw inertia, place of the axles, height of the centre of gravity and the stiffness of the tyres
    across, of both axles together; suspension, wheels and the rest of the tyres are the BMW 320i's, springs and inertias scaled with the
    mass. The road's friction is the peak of the tyres' force over their load, along and across (Pacejka's lambda_mu). Torque on a wheel
    ends where it slips most usefully (anti-lock brakes, traction control). The models drive the rear wheels.

    As with our own plants, the acceleration in the state is the one asked of brakes and engine, and a car that hardly moves is a no-slip
    bicycle: what it still slides sideways when it slows down to SLOW_MPS is lost.
    """

    def __init__(self, model: VehicleModel, vehicle: Vehicle, road: Road, state: HostState) -> None:
        self._model, self._vehicle, self._road, self._straight = model, vehicle, road, road.is_straight
        self._chassis = Chassis.of(vehicle)
        self._actuators = Actuators(vehicle=vehicle, friction=road.friction)
        self._best_slip = _best_slip(model.parameters.tire)
        self._acceleration = 0.0
        self._x: list[float] = []  # (s, d, heading along the road) and the model's own
        self._slow: KinematicPlant | None = None
        start = in_steady_turn(state, vehicle, road)
        if start.speed_mps < FAST_MPS:
            self._slow = KinematicPlant(vehicle, road, start)
        else:
            self._go(start)

    @property
    def state(self) -> SlidingState:
        if self._slow is not None:
            return _sliding(self._slow.state, self._vehicle)
        forward, aside = self._model.velocity(self._x[3:])
        yaw_rate = self._x[8]
        return SlidingState(
            s_m=self._x[0],
            d_m=self._x[1],
            heading_rad=self._x[2],
            speed_mps=forward,
            acceleration_mps2=self._acceleration,
            steering_rad=self._x[5],
            lateral_speed_mps=aside - self._chassis.cog_to_rear_axle_m * yaw_rate,
            yaw_rate_radps=yaw_rate,
        )

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        if self._slow is not None:
            applied = self._slow.step(jerk_mps3, steering_rate_radps)
            if self._slow.state.speed_mps > FAST_MPS:
                self._go(self.state)
            return applied
        car, x = self._vehicle, self._x
        forward, _ = self._model.velocity(x[3:])
        jerk, rate = self._actuators.follow(jerk_mps3, steering_rate_radps, forward, self._acceleration, x[5])
        acceleration = self._acceleration + 0.5 * jerk * STEP_S  # the step's mean
        lateral = self._model.lateral_acceleration(x[3:], self._rates(x[3:], rate, acceleration))

        def motion(y: list[float]) -> list[float]:
            s, d, psi, *inner = y
            rates = self._rates(inner, rate, acceleration)
            ahead, left = self._model.velocity(inner)
            left += (car.centre_m - self._chassis.cog_to_rear_axle_m) * inner[5]
            kappa = 0.0 if self._straight else float(self._road.curvature_at(s))
            s_dot = (ahead * math.cos(psi) - left * math.sin(psi)) / (1.0 - d * kappa)
            return [s_dot, ahead * math.sin(psi) + left * math.cos(psi), inner[5] - kappa * s_dot, *rates]

        parts = max(math.ceil(STEP_S * self._fastest_rate(forward) / _STABLE), 1)
        for _ in range(parts):
            x = rk4(motion, x, STEP_S / parts)  # type: ignore[arg-type]
        self._x, before = x, self._acceleration
        forward, _ = self._model.velocity(x[3:])
        self._acceleration, x[5] = self._actuators.hold(forward, before + jerk * STEP_S, x[5])  # rounding
        if forward < SLOW_MPS:
            self._slow = KinematicPlant(
                car, self._road, HostState.from_vector(replace(self.state, speed_mps=max(forward, 0.0)).to_vector())
            )
        return Applied(jerk_mps3=jerk, steering_rate_radps=rate, lateral_acceleration_mps2=lateral)

    def _go(self, start: SlidingState) -> None:
        self._slow = None
        aside = start.lateral_speed_mps + self._chassis.cog_to_rear_axle_m * start.yaw_rate_radps
        speed, slip = math.hypot(start.speed_mps, aside), math.atan2(aside, start.speed_mps)
        given = [0.0, 0.0, start.steering_rad, speed, 0.0, start.yaw_rate_radps, slip]
        self._acceleration = start.acceleration_mps2
        self._x = [start.s_m, start.d_m, start.heading_rad, *self._model.begin(given, self._model.parameters)]

    def _fastest_rate(self, forward_mps: float) -> float:
        """Of a wheel whose slip follows its torque [1/s]."""
        p = self._model.parameters
        return float(p.R_w**2 * abs(p.tire.p_kx1) * _LOADED * 0.5 * p.m * GRAVITY_MPS2 / (p.I_y_w * max(forward_mps, 1.0)))

    def _rates(self, x: list[float], rate: float, acceleration: float) -> list[float]:
        """The model's, with the torque on each wheel that it can use."""
        model, p = self._model, self._model.parameters
        rates = model.rates(x, [rate, acceleration], p)
        forward, aside = model.velocity(x)
        if acceleration < 0.0 and not self._chassis.anti_lock:
            return rates
        share = p.T_sb if acceleration < 0.0 else p.T_se
        for index, at_front, side in model.wheels:
            along = forward + (0.5 * (p.T_f if at_front else p.T_r) * side * x[5])
            if at_front:
                along = along * math.cos(x[2]) + (aside + p.a * x[5]) * math.sin(x[2])
            slip = 1.0 - p.R_w * x[index] / max(along, 0.1)
            too_much = (math.copysign(1.0, -acceleration) * slip / self._best_slip - 1.0) / (_RELEASED - 1.0)
            if too_much > 0.0:
                torque = p.m * p.R_w * acceleration * (share if at_front else 1.0 - share) * (1.0 if side == 0 else 0.5)
                rates[index] -= min(too_much, 1.0) * torque / p.I_y_w
        return rates


def std(vehicle: Vehicle, road: Road, state: HostState) -> VehicleModelPlant:
    """Plant `std`: single track, nine states, combined slip, wheel speeds. Raises `MissingExtraError`."""
    with of_extra("commonroad-vehicle-models", "vehicle-models"):
        from vehiclemodels.init_std import init_std
        from vehiclemodels.vehicle_dynamics_std import vehicle_dynamics_std

    def lateral_acceleration(x: list[float], rates: list[float]) -> float:
        return rates[3] * math.sin(x[6]) + x[3] * math.cos(x[6]) * (rates[6] + x[5])

    model = VehicleModel(
        parameters=_parameters(vehicle, road.friction),
        rates=vehicle_dynamics_std,
        begin=init_std,
        velocity=lambda x: (x[3] * math.cos(x[6]), x[3] * math.sin(x[6])),
        lateral_acceleration=lateral_acceleration,
        wheels=((7, True, 0), (8, False, 0)),
    )
    return VehicleModelPlant(model, vehicle, road, state)


def multi_body(vehicle: Vehicle, road: Road, state: HostState) -> VehicleModelPlant:
    """Plant `multi-body`: 29 states; body, axles, suspension, four wheels. Raises `MissingExtraError`."""
    with of_extra("commonroad-vehicle-models", "vehicle-models"):
        from vehiclemodels.init_mb import init_mb
        from vehiclemodels.vehicle_dynamics_mb import vehicle_dynamics_mb
    model = VehicleModel(
        parameters=_parameters(vehicle, road.friction),
        rates=vehicle_dynamics_mb,
        begin=init_mb,
        velocity=lambda x: (x[3], x[10]),
        lateral_acceleration=lambda x, rates: rates[10] + x[5] * x[3],
        wheels=((23, True, 1), (24, True, -1), (25, False, 1), (26, False, -1)),
    )
    return VehicleModelPlant(model, vehicle, road, state)


def _parameters(vehicle: Vehicle, friction: float) -> Any:
    """The BMW 320i's, as this vehicle is."""
    from vehiclemodels.parameters_vehicle2 import parameters_vehicle2

    chassis, p = Chassis.of(vehicle), parameters_vehicle2()
    heavier = chassis.mass_kg / p.m
    scaled = {name: heavier * vars(p)[name] for name in (*_OF_MASS, *_OF_FORCE)}
    tire = p.tire
    along, across = friction / tire.p_dx1, friction / tire.p_dy1
    across_per_load = (chassis.cornering_stiffness_front_nprad + chassis.cornering_stiffness_rear_nprad) / (chassis.mass_kg * GRAVITY_MPS2)
    tire = replace(
        tire,
        p_ky1=-across_per_load,
        p_dx1=friction,
        p_dy1=friction,
        p_vx1=along * tire.p_vx1,
        p_vy1=across * tire.p_vy1,
        p_vy3=across * tire.p_vy3,
    )
    steering = replace(p.steering, min=-math.inf, max=math.inf, v_min=-math.inf, v_max=math.inf)  # ours are the vehicle's
    longitudinal = replace(p.longitudinal, a_max=math.inf, v_switch=math.inf, v_max=math.inf)
    return replace(
        p,
        **scaled,
        K_lt=p.K_lt / heavier,
        a=chassis.cog_to_front_axle_m,
        b=chassis.cog_to_rear_axle_m,
        I_z=chassis.yaw_inertia_kgm2,
        T_sb=p.T_sb if chassis.brake_share_front is None else chassis.brake_share_front,
        h_s=chassis.cog_height_m,
        tire=tire,
        steering=steering,
        longitudinal=longitudinal,
    )


def _best_slip(tire: Any) -> float:
    """The longitudinal slip that gives the most force: C atan(B k - E (B k - atan(B k))) = pi / 2."""
    stiffness, shape, curvature = tire.p_kx1 / (tire.p_cx1 * tire.p_dx1), tire.p_cx1, tire.p_ex1
    wanted = math.tan(0.5 * math.pi / shape)
    low, high = 0.0, wanted / (1.0 - curvature)
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if middle - curvature * (middle - math.atan(middle)) < wanted else (low, middle)
    return float(low / stiffness)


def _sliding(state: HostState, vehicle: Vehicle) -> SlidingState:
    """A state without slip as one of a car whose tyres could."""
    aside, yaw_rate = state.turning(vehicle.wheelbase_m)
    return SlidingState(**asdict(state), lateral_speed_mps=aside, yaw_rate_radps=yaw_rate)
