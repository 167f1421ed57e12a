"""The closed loop: sensors, planner, controller, plant and traffic, turn by turn."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import not_a_class, require_type, require_type_if_given, whole
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.simulation.car import Car, PlantError
from mcdas_opt.simulation.controller import Controller, default_controller, make_controller, planned_for
from mcdas_opt.simulation.drive import Drive
from mcdas_opt.simulation.driver import Driver, check_step
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.motion_sensors import MeasuredHost, MotionSensors
from mcdas_opt.simulation.motion_sensors import motion_sensors as sensors_named
from mcdas_opt.simulation.neighbours import Traffic
from mcdas_opt.simulation.perception import Perception
from mcdas_opt.simulation.plant import PlantFactory, PlantName
from mcdas_opt.simulation.record import Outcome, Simulation
from mcdas_opt.simulation.sensor_faults import SensorFaults

if TYPE_CHECKING:
    from mcdas_opt.planning.method import Method, PlannerName

T = TypeVar("T")


@usual_arithmetic
def simulate(
    scene: str | Path | Scene,
    planner: PlannerName | str | Driver | Method = "mpc",
    plant: PlantName | str | PlantFactory = "kinematic",
    seed: int | None = None,
    settings: Settings | None = None,
    controller: str | Controller | None = None,
    progress: Callable[[int, int], None] | None = None,
    faults: SensorFaults | None = None,
    motion_sensors: str | MotionSensors = "ideal",
) -> Simulation:
    """Drives a planner through a scene (or the shipped one of that name, or a path), and returns the drive with its figures.

    Ends at the scene's duration, at the first touch of another body, or when a corner is more than 0.02 m off the road. `planner` is
    a registered name, a `Driver`, or a method (`planning.method.Method`). It plans every `cycle_s` of `settings`; without them of its
    own, if it has any. `plant` is a registered name, or a class or function that
    builds one (`simulation.plant.Plant`). Planner and controller get the plant's pose and what `motion_sensors` (a name of
    `simulation.motion_sensors.MOTION_SENSORS`, or a record) measure of its motion; the sideslip of a dynamic vehicle is an observer's, and
    the planner gets the no-slip state that moves alike. Friction is what the scene assumes until `GripMonitor` finds less.
    `controller` is one of `simulation.controller.CONTROLLERS` by name, or an object; default the plant's (`default_controller`).
    `faults` is what the sensors and the host's own measurements do wrong beyond their noise (`simulation.sensor_faults`).
    `progress` is told after every turn how many are done, and of how many.
    Without its `cycle_ms` the result repeats to the byte for the same scene and seed (default the scene's). Raises `InputError` or
    `ParameterError` for a planner, plant or sensor that is not known; `PlantError`, with the drive up to there, for a plant that raises,
    gives a number that is not finite, or jumps.
    """
    if isinstance(scene, (str, Path)):
        scene = load_scene(scene)
    require_type("scene", scene, Scene)
    require_type_if_given("settings", settings, Settings)
    require_type_if_given("faults", faults, SensorFaults)
    own = _its_own(planner, "settings", Settings)
    settings = settings or own or Settings()
    seed = scene.seed if seed is None else whole("seed", seed)
    not_a_class("planner", planner)
    not_a_class("controller", controller)
    if controller is not None and not isinstance(controller, str) and not callable(getattr(controller, "command", None)):
        raise ParameterError("controller", controller, "must be the name of a controller, or have a method command")
    if progress is not None and not callable(progress):
        raise ParameterError("progress", progress, "must be a function of how many turns are done, and of how many")
    traffic, assumed = Traffic(scene), scene.assumed_road
    car = Car(plant, scene.vehicle, traffic.road, scene.host_state)
    host = MeasuredHost(scene.vehicle, car.state, sensors_named(motion_sensors), friction=assumed.friction, seed=seed)
    reserve = car.slips and own is None  # a method that was built with its own settings solves with them
    driver = _driver(planner, scene, planned_for(settings, slips=reserve), slips=car.slips)
    driver.set_destination(scene.destination_to_reach)
    monitor = GripMonitor(vehicle=scene.vehicle, believed=assumed.friction, step_s=STEP_S)
    turned = driver.takes_zero_sideslip_point
    if isinstance(controller, str):
        controller = make_controller(controller, scene.vehicle, turned=turned, grip=monitor)
    tracking = controller or default_controller(scene.vehicle, slips=car.slips, turned=turned, grip=monitor)
    perception = Perception(scene, seed, driver.tracker, faults)
    perception.warm_up(scene, traffic, car.state)
    drive = Drive(scene=scene, traffic=traffic, car=car, host=host, monitor=monitor)
    turns = _turns(scene.duration_s, settings.cycle_s)
    for turn, (now, steps) in enumerate(turns, start=1):
        started = time.perf_counter()
        road, seen = _believed(assumed, monitor), car.ahead(host.state, monitor.friction)
        point = car.zero_sideslip_point_m(seen) if turned else 0.0
        driver.set_zero_sideslip_point(point)
        state = car.without_slip(seen, road, point)
        plan = driver.step(
            perception.arrived(now, before_s=car.delay_s),
            state if faults is None else faults.told(state, scene.vehicle.wheelbase_m),
            now + car.delay_s,
            road=road,
            desired_speed_mps=scene.desired_speed_mps,
            request=scene.request,
        )
        require_type(f"{type(driver).__name__}.step()", plan, Plan)
        took_ms = 1e3 * (time.perf_counter() - started)
        drive.note(now, plan, () if driver.situation is None else driver.situation.tracks, took_ms)
        try:
            drive.advance(plan, tracking, steps, perception)
        except PlantError as error:
            error.drive = drive.summary(planner=driver.name, seed=seed, error=str(error))
            raise
        if progress is not None:
            progress(turn, len(turns))
        if drive.outcome is not Outcome.SAFE:
            break
    return drive.summary(planner=driver.name, seed=seed)


def _believed(road: Road, monitor: GripMonitor) -> Road:
    """The road as the planner believes it: no more friction than the monitor found. The same record where that changes nothing."""
    return road if monitor.friction == road.friction else replace(road, friction=monitor.friction)


def _turns(duration_s: float, cycle_s: float) -> list[tuple[float, int]]:
    """(time, plant steps) of each turn; the last may be shorter."""
    each, total = round(cycle_s / STEP_S), max(round(duration_s / STEP_S), 1)
    if each < 1 or abs(each * STEP_S - cycle_s) > 1e-9:
        raise ParameterError("cycle_s", cycle_s, f"must be a whole number of {STEP_S:g} s steps", "s")
    return [(round(k * STEP_S, 9), min(each, total - k)) for k in range(0, total, each)]


def _driver(planner: str | Driver | Method, scene: Scene, settings: Settings, *, slips: bool) -> Driver:
    """The driver, fresh. For a dynamic vehicle it is built as one that will be told the zero-sideslip point, at rest too."""
    _require_its_car(planner, scene)
    if isinstance(planner, Driver):
        check_step(planner)
        planner.reset()
        return planner
    from mcdas_opt.planning.planner import Planner

    car = scene.vehicle
    vehicle = replace(car, zero_sideslip_point_m=Chassis.of(car).zero_sideslip_point_m(car.speed_max_mps)) if slips else car
    return Planner(vehicle=vehicle, method=planner, settings=settings, road=scene.assumed_road)


def _require_its_car(planner: object, scene: Scene) -> None:
    """What plans with a vehicle plans with the scene's."""
    own = _its_own(planner, "vehicle", Vehicle)
    if own is not None and own.name != scene.vehicle.name:
        raise ParameterError("planner.vehicle", own.name, f"is not the car of this scene, {scene.vehicle.name!r}")


def _its_own(planner: object, name: str, kind: type[T]) -> T | None:
    """What a planner has of that kind, if anything."""
    own = getattr(planner, name, None)
    return own if isinstance(own, kind) else None
