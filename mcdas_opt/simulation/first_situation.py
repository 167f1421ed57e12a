"""The situation at t = 0: of a scene, after its sensors' warm-up, or one saved as JSON."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from mcdas_opt.catalogue.data_files import read_text
from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.catalogue.vehicles import load_vehicle, vehicle_text
from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, writing
from mcdas_opt.simulation.neighbours import Traffic
from mcdas_opt.simulation.perception import Perception
from mcdas_opt.tracking.tracker import Tracker


def first_situation(scene: Scene, seed: int | None = None) -> Situation:
    """The planner's situation at t = 0, as in the closed loop of the same scene and seed."""
    tracker, traffic = Tracker(vehicle=scene.vehicle), Traffic(scene)
    perception = Perception(scene, scene.seed if seed is None else seed, tracker)
    perception.warm_up(scene, traffic, scene.host_state)
    host, road = scene.host_state, scene.assumed_road
    tracker.update(perception.arrived(0.0), host, road, 0.0)
    return Situation(
        time_s=0.0,
        host=host,
        tracks=tracker.tracks(0.0),
        coverage=tracker.coverage(0.0),
        road=road,
        vehicle=scene.host.vehicle,
        desired_speed_mps=scene.desired_speed_mps,
        request=scene.request,
        destination=scene.destination_to_reach,
    )


@usual_arithmetic
def load_situation(name: str | Path, seed: int | None = None) -> Situation:
    """What a planner is told at t = 0 of a scene (path or shipped name; `seed` of its sensors' noise), or a situation saved as `.json`.
    Raises `InputError` that names file, key, value and rule."""
    return situation_of(str(name), seed)[0]


def situation_of(name: str, seed: int | None = None) -> tuple[Situation, Vehicle]:
    """From a scene (path or shipped name) or a situation saved as `.json`. Raises `InputError`."""
    path = Path(name)
    if path.suffix == ".json":
        if not os.path.isfile(path):
            raise InputError(name, "", None, "no such file")
        situation = Situation.from_json(read_text(path), path)
        vehicle = load_vehicle(situation.vehicle_name, path.parent)
        if situation.host.speed_mps > vehicle.speed_max_mps:
            rule = f"exceeds the vehicle's maximum {vehicle.speed_max_mps:g} m/s (speeds are m/s, not km/h)"
            raise InputError(path, "host.speed_mps", situation.host.speed_mps, rule)
        return situation, vehicle
    scene = load_scene(name)
    return first_situation(scene, seed), scene.vehicle


def save_situation(situation: Situation, vehicle: Vehicle, path: Path) -> Path | None:
    """Writes it as JSON that `situation_of` reads. A vehicle that its name does not lead to from there is written beside it, as a vehicle
    file of its own; returns that file. Raises `InputError` where a file cannot be written."""
    beside = None
    if not _leads_to(situation.vehicle_name, path.parent, vehicle):
        beside = path.with_name(f"{path.stem}-{vehicle.name}.toml")
        with writing(beside):
            beside.write_text(vehicle_text(vehicle), "utf-8")
        situation = replace(situation, vehicle=beside.name)
    with writing(path):
        path.write_text(situation.to_json(), "utf-8")
    return beside


def _leads_to(name: str, folder: Path, vehicle: Vehicle) -> bool:
    try:
        return replace(load_vehicle(name, folder), name=vehicle.name) == vehicle
    except InputError:
        return False
