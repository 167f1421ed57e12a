"""A plant in the loop: its steps checked, and what follows from its state for whoever plans, tracks and looks."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from mcdas_opt.actuation.grip_monitor import within_grip
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import finite, require
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.single_track import zero_sideslip_point_m
from mcdas_opt.errors import McdasError, ParameterError
from mcdas_opt.simulation.actuators import Applied
from mcdas_opt.simulation.command_chain import CommandChain
from mcdas_opt.simulation.dynamic_plant import DynamicPlant
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.kinematic_plant import KinematicPlant
from mcdas_opt.simulation.plant import Plant, PlantFactory, make_plant, plant_name

if TYPE_CHECKING:
    from mcdas_opt.simulation.record import Simulation

# A step that no car makes. Well beyond what tyres give, so that a spin is not taken for a fault.
_SPEED_SHARE, _MOVED_M = 2.0, 0.05  # moved by so many times what its speed is good for, and so much besides
_FASTER_MPS = 1.0
_TURNED_RAD = 0.2


class PlantError(McdasError, RuntimeError):
    """A plant raised, or moved as no car does. `drive` is the drive up to there; None where the plant could not begin."""

    def __init__(self, plant: str, time_s: float, fault: str, drive: Simulation | None = None) -> None:
        self.plant, self.time_s, self.fault, self.drive = plant, time_s, fault, drive
        super().__init__(f"plant {plant!r} at t = {time_s:.2f} s: {fault}")

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.plant, self.time_s, self.fault, self.drive)


class Car:
    """A plant under its name. Raises `PlantError` where the plant raises, gives a number that is not finite, or jumps."""

    def __init__(self, plant: str | PlantFactory, vehicle: Vehicle, road: Road, state: HostState) -> None:
        self.name = plant_name(plant)
        self._vehicle, self._road, self._chassis = vehicle, road, Chassis.of(vehicle)
        self._steps = 0
        try:
            self._plant: Plant = make_plant(plant, vehicle, road, state)
            self._state = _checked(self._plant.state)
            self._commands = CommandChain(vehicle, self._state)
        except McdasError:
            raise
        except Exception as error:
            raise PlantError(self.name, 0.0, _words(error)) from error

    @property
    def state(self) -> HostState:
        """The plant's true state."""
        return self._state

    @property
    def slips(self) -> bool:
        """Whether its tyres slip: a dynamic vehicle."""
        return isinstance(self._state, SlidingState)

    @property
    def delay_s(self) -> float:
        """How long a command takes to reach the actuators."""
        return self._commands.delay_steps * STEP_S

    def ahead(self, state: HostState, friction: float) -> HostState:
        """The state of now, as measured, at the moment at which a command of now takes effect, on a road of that friction; its wheels as
        commanded by then.

        Without delay and lag, the state itself. Else the commands on their way, through the single track with the file's tyres
        (`DynamicPlant`), or through the kinematic bicycle for a car that does not slip.
        """
        if self._vehicle.actuators.is_immediate:
            return state
        road = self._road if friction == self._road.friction else replace(self._road, friction=friction)
        model = (DynamicPlant if self.slips else KinematicPlant)(self._vehicle, road, state)
        commands = self._commands.copied()
        for _ in range(commands.delay_steps):
            model.step(*commands.apply(0.0, 0.0, model.state))
        return replace(model.state, steering_rad=self._commands.steering_rad)

    def zero_sideslip_point_m(self, state: HostState) -> float:
        """The zero-sideslip point at that speed, ahead of the rear axle (`Vehicle.zero_sideslip_point_m`)."""
        return zero_sideslip_point_m(self._chassis, state.speed_mps) if self.slips else 0.0

    def without_slip(self, state: HostState, road: Road, point_m: float) -> HostState:
        """The no-slip bicycle that moves as the car does in that state, its rear axle at that point: what plans are made with. Of a dynamic
        vehicle its path bends no more than the road's grip allows."""
        moving = state.without_slip(self._vehicle.wheelbase_m, point_m)
        return within_grip(moving, road, self._vehicle.wheelbase_m) if self.slips else moving

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        """As `Plant.step`."""
        before, time_s = self._state, (self._steps + 1) * STEP_S
        try:
            applied = self._plant.step(*self._commands.apply(jerk_mps3, steering_rate_radps, before))
            after = _checked(self._plant.state)
            require(applied, finite, "jerk_mps3", "steering_rate_radps", "lateral_acceleration_mps2")
        except Exception as error:
            raise PlantError(self.name, time_s, _words(error)) from error
        fault = _jump(before, after, self._road)
        if fault:
            raise PlantError(self.name, time_s, fault)
        self._state, self._steps = after, self._steps + 1
        return applied


def _checked(state: object) -> HostState:
    if not isinstance(state, HostState):
        raise ParameterError("state", state, "must be a HostState")
    return state


def _words(error: Exception) -> str:
    return str(error) if isinstance(error, McdasError) else f"raised {type(error).__name__}: {error}"


def _jump(before: HostState, after: HostState, road: Road) -> str:
    """What is wrong with a step between two states, in words; "" if nothing."""
    stretch = 1.0 if road.is_straight else 1.0 - before.d_m * float(road.curvature_at(before.s_m))
    moved = math.hypot((after.s_m - before.s_m) * stretch, after.d_m - before.d_m)
    farthest = _SPEED_SHARE * STEP_S * max(_speed(before), _speed(after)) + _MOVED_M
    if moved > farthest:
        return f"moved by {moved:.3g} m in a step of {STEP_S:g} s: must be at most {farthest:.3g} m at its speed"
    faster = abs(after.speed_mps - before.speed_mps)
    if faster > _FASTER_MPS:
        return f"speed_mps changed by {faster:.3g} m/s in a step of {STEP_S:g} s: must be at most {_FASTER_MPS:g} m/s"
    turned = abs(after.heading_rad - before.heading_rad)
    if turned > _TURNED_RAD:
        return f"heading_rad changed by {turned:.3g} rad in a step of {STEP_S:g} s: must be at most {_TURNED_RAD:g} rad"
    if after.speed_mps < 0.0:
        return f"speed_mps = {after.speed_mps:.3g} m/s: must be at least 0, nobody reverses in the lane"
    return ""


def _speed(state: HostState) -> float:
    aside = state.lateral_speed_mps if isinstance(state, SlidingState) else 0.0
    return math.hypot(state.speed_mps, aside)
