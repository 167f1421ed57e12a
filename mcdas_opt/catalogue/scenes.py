"""Scene files: the contract's TOML as frozen, checked models."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, TypeVar

import numpy as np
from pydantic import Field, PrivateAttr, ValidationError, field_validator

from mcdas_opt.catalogue.data_files import checked, find, read_text, read_toml, told
from mcdas_opt.catalogue.neighbour_tables import NeighbourPart
from mcdas_opt.catalogue.part import Acceleration, Part, Place, Speed
from mcdas_opt.catalogue.road_tables import DestinationPart, RoadPart
from mcdas_opt.catalogue.sensors import IDEAL, NONE, load_sensor
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.registry import Registry
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request, Sector
from mcdas_opt.errors import InputError, McdasError
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners, separation

Loaded = TypeVar("Loaded")
TRAJECTORY_COLUMNS = ("t_s", "s_m", "d_m", "heading_rad", "speed_mps")
# others' files that are scenes too, by the end of their name: a function of the path that gives the scene
SCENE_FORMATS = Registry(group="mcdas_opt.scenes", what="scene format", own={"xml": "mcdas_opt.interop.commonroad.scenario:scene_of"})
_FASTEST_MPS, _NOISE_M = 100.0, 2.0  # what a recorded car may seem to move by
_RECORDED_M = 1e5  # from where a drive begins: it lasts 600 s at most


class HostPart(Part):
    vehicle: Annotated[str, Field(description="a file in models/vehicles, or a path")] = "sedan"
    d_m: Annotated[Place, Field(description="body centre across the road, left positive; its s is 0")] = 0.0
    heading_rad: Annotated[float, Field(gt=-math.pi / 2, lt=math.pi / 2, description="relative to the road")] = 0.0
    speed_mps: Annotated[Speed, Field(description="at the start")]
    acceleration_mps2: Annotated[Acceleration, Field(description="at the start")] = 0.0
    desired_speed_mps: Annotated[Speed | None, Field(description="what the driver wants; default speed_mps")] = None
    assumed_friction: Annotated[
        Annotated[float, Field(gt=0.0, le=1.5)] | None, Field(description="plans are made and judged with it; default the road's")
    ] = None
    request: Annotated[Literal["drive", "park"], Field(description="park is granted only at standstill")] = "drive"


def _looks(where: str) -> Any:
    return Field(description=f"who looks {where}: a file in models/sensors, ideal, or none (then that side counts as occupied)")


class SensorsPart(Part):
    front: Annotated[str, _looks("ahead")] = "ideal"
    rear: Annotated[str, _looks("behind")] = "ideal"
    left: Annotated[str, _looks("on the left")] = "ideal"
    right: Annotated[str, _looks("on the right")] = "ideal"
    latency_s: Annotated[float, Field(ge=0.0, le=1.0, description="age of a measurement at the planner")] = 0.0
    warmup_s: Annotated[float, Field(ge=0.0, le=10.0, description="how long the sensors have seen everybody before t = 0")] = 1.0

    def of(self, sector: Sector) -> str:
        return str(vars(self)[sector])  # a field is called what its sector is


class Scene(Part):
    """A scene of the contract, all its rules kept and the files that it names read.

    From a file: `load_scene`, whose faults are `InputError`. From a dict: `Scene.model_validate`, whose faults are pydantic's (a
    `ValueError` too); files that it names are sought as paths and among the shipped ones.
    """

    KIND: ClassVar[str] = "scene"

    name: Annotated[str, Field(description="of the scene")] = "scene"
    duration_s: Annotated[float, Field(gt=0.0, le=600.0, description="the drive ends there, or before where something is touched")] = 8.0
    seed: Annotated[int, Field(ge=0, description="of the measurement noise")] = 1
    road: Annotated[RoadPart, Field(description="the road, in the frame of the host's lane: s forward, d left")] = RoadPart()
    host: Annotated[HostPart, Field(description="the car that is planned for")]
    neighbour: Annotated[list[NeighbourPart], Field(description="everybody else", default_factory=list)]
    destination: Annotated[DestinationPart | None, Field(description="where to be, and when; without it, along the road")] = None
    sensors: Annotated[SensorsPart, Field(description="what looks where")] = SensorsPart()
    _vehicle: Vehicle = PrivateAttr()
    _file: str = PrivateAttr(default="scene")

    @field_validator("neighbour")
    @classmethod
    def _names(cls, neighbours: list[NeighbourPart]) -> list[NeighbourPart]:
        names = [n.name for n in neighbours if n.name]
        twice = next((n for n, often in Counter(names).items() if often > 1), None)
        if twice is not None:
            raise ValueError(f"two neighbours are called {twice!r}")
        return neighbours

    def model_post_init(self, context: Any) -> None:
        path = context if isinstance(context, Path) else Path(self._file)
        beside = path.parent if isinstance(context, Path) else None
        self._file = str(path)
        self._vehicle = _named_file(load_vehicle, self.host.vehicle, beside, path, "host.vehicle")
        for sector in Sector:
            name = self.sensors.of(sector)
            if name not in (IDEAL, NONE):
                _named_file(load_sensor, name, beside, path, f"sensors.{sector.value}")
        for index, neighbour in enumerate(self.neighbour):
            if neighbour.trajectory is not None:
                neighbour.take(_read_trajectory(path, index, neighbour.trajectory, self.true_road))
        _check_values(self, path)

    @property
    def vehicle(self) -> Vehicle:
        return self._vehicle

    @property
    def file(self) -> str:
        return self._file

    @property
    def host_state(self) -> HostState:
        """At t = 0, wheels straight along the road's curvature."""
        host = self.host
        kappa = float(self.road.record().curvature_at(0.0))
        return HostState(
            s_m=0.0,
            d_m=host.d_m,
            heading_rad=host.heading_rad,
            speed_mps=host.speed_mps,
            acceleration_mps2=host.acceleration_mps2,
            steering_rad=math.atan(self.vehicle.wheelbase_m * kappa),
        )

    @property
    def true_road(self) -> Road:
        """With the friction that the plant has."""
        return self.road.record()

    @property
    def assumed_road(self) -> Road:
        """With the friction that plans are made and judged with."""
        return self.road.record(self.host.assumed_friction)

    @property
    def desired_speed_mps(self) -> float:
        host = self.host
        return host.speed_mps if host.desired_speed_mps is None else host.desired_speed_mps

    @property
    def destination_to_reach(self) -> Destination | None:
        return None if self.destination is None else self.destination.record()

    @property
    def request(self) -> Request:
        return Request(self.host.request)

    def neighbour_name(self, index: int) -> str:
        return self.neighbour[index].name or f"neighbour-{index + 1}"


@usual_arithmetic
def load_scene(name: str | Path) -> Scene:
    """The scene behind a path or a shipped name. A CommonRoad scenario (.xml) is one too: its first planning problem, with the extra
    `commonroad`. Raises `InputError` that names file, key, value and rule."""
    path = find("scenes", str(name))
    form = path.suffix.lower().lstrip(".")
    if form != "toml" and form in SCENE_FORMATS.known():
        return _of_a_format(form, path)
    document = read_toml(path)
    return scene_from_document(document, path)


def _of_a_format(form: str, path: Path) -> Scene:
    """What the format's function, which may be anybody's, makes of the file."""
    scene_of = SCENE_FORMATS.load(form)
    with of_a_format(form, path):
        scene = scene_of(path)
    if not isinstance(scene, Scene):
        raise InputError(path, "", None, f"the scene format {form!r} gave {type(scene).__name__}, which must be a Scene")
    return scene


@contextmanager
def of_a_format(form: str, path: Path) -> Iterator[None]:
    """What a format's reader raises of a file, as an `InputError` that names the file."""
    try:
        yield
    except McdasError:
        raise
    except ValidationError as error:
        fault = told(error, Scene, path)
        raise InputError(path, f"the scene format {form!r} gave {fault.key}", fault.value, fault.rule) from error
    except Exception as error:
        raise InputError(path, "", None, f"the scene format {form!r} raised {type(error).__name__}: {error}") from error


def scene_from_document(document: Any, path: Path) -> Scene:
    """A scene from its parsed TOML; files that it names are sought beside `path`."""
    return checked(Scene, document, path, context=path)


def _named_file(load: Callable[[str, Path | None], Loaded], name: str, beside: Path | None, scene: Path, key: str) -> Loaded:
    """What `load` reads from the file of that name; that there is none is the scene's fault, at `key`."""
    try:
        return load(name, beside)
    except InputError as error:
        if os.path.isfile(error.file):
            raise
        raise InputError(scene, key, name, error.rule) from None


def _read_trajectory(scene: Path, index: int, name: str, road: Road) -> Array:
    """Samples (n, 5). Nobody jumps in the plane; across a bend a body's s may."""
    path = next((p for p in (scene.parent / name, Path(name)) if os.path.isfile(p)), None)
    if path is None:
        raise InputError(scene, f"neighbour[{index}].trajectory", name, "no such file")
    lines = read_text(path).splitlines()
    header = tuple(part.strip() for part in lines[0].split(",")) if lines else ()
    if header != TRAJECTORY_COLUMNS:
        raise InputError(path, "line 1", ",".join(header), f"must be the header {','.join(TRAJECTORY_COLUMNS)}")
    rows: list[list[float]] = []
    numbers = [number for number, line in enumerate(lines) if number and line.strip()]
    for number, line in ((number + 1, lines[number]) for number in numbers):
        try:
            row = [float(part) for part in line.split(",")]
        except ValueError:
            raise InputError(path, f"line {number}", line, "must be numbers") from None
        if len(row) != len(TRAJECTORY_COLUMNS) or not all(math.isfinite(v) for v in row):
            raise InputError(path, f"line {number}", line, f"must be {len(TRAJECTORY_COLUMNS)} finite numbers")
        if rows and row[0] <= rows[-1][0]:
            raise InputError(path, f"line {number}", row[0], "t_s must increase")
        if max(abs(row[1]), abs(row[2])) > _RECORDED_M:
            raise InputError(path, f"line {number}", line, f"must lie within {_RECORDED_M:g} m")
        rows.append(row)
    if len(rows) < 2:
        raise InputError(path, "", None, "needs at least two rows")
    samples = np.array(rows)
    jump = _first_jump(samples, road)
    if jump is not None:
        after, moved_m = jump
        rule = f"jumps by {moved_m:.0f} m in {np.diff(samples[:, 0])[after - 1]:g} s: no car is so fast"
        raise InputError(path, f"line {numbers[after] + 1}", lines[numbers[after]], rule)
    return samples


def _first_jump(samples: Array, road: Road) -> tuple[int, float] | None:
    """The first sample that no car reaches from the one before it, and how far it lies from that in the plane [m]."""
    s, d = samples[:, 1:3].T
    most_m = _FASTEST_MPS * np.diff(samples[:, 0]) + _NOISE_M
    moved_m = np.hypot(np.diff(s), np.diff(d))
    if not road.is_straight and (moved_m > most_m).any():  # across a bend its s may
        x, y, _ = FrenetFrame(road=road, s_min_m=float(s.min()) - 1.0, s_max_m=float(s.max()) + 1.0).to_plane(s, d, np.zeros(s.size))
        moved_m = np.where(moved_m > most_m, np.hypot(np.diff(x), np.diff(y)), moved_m)
    jumps = np.flatnonzero(moved_m > most_m)
    return (int(jumps[0]) + 1, float(moved_m[jumps[0]])) if jumps.size else None


def _check_values(scene: Scene, path: Path) -> None:
    """Rules that need the vehicle or several keys at once."""
    vehicle, host, road = scene.vehicle, scene.host, scene.true_road
    top = vehicle.speed_max_mps
    for key, value in (("host.speed_mps", host.speed_mps), ("host.desired_speed_mps", host.desired_speed_mps)):
        if value is not None and value > top:
            raise InputError(path, key, value, f"exceeds the vehicle's maximum {top:g} m/s (speeds are m/s, not km/h)")
    end, bumper = road.road_end_s_m, 0.5 * vehicle.length_m
    if end is not None and end <= bumper:
        raise InputError(path, "road.road_end_s_m", end, f"is not ahead of the host's front bumper at {bumper:g} m")
    if host.request == "park" and host.speed_mps > 0.0:
        raise InputError(path, "host.request", "park", "parking is granted only at standstill")
    low, high = vehicle.acceleration_min_mps2, vehicle.acceleration_max_mps2
    if not low <= host.acceleration_mps2 <= high:
        raise InputError(path, "host.acceleration_mps2", host.acceleration_mps2, f"must lie in [{low:g}, {high:g}]")
    destination = scene.destination_to_reach
    why = "" if destination is None else destination.why_unreachable(scene.host_state, 0.0, road, vehicle)
    if why:
        raise InputError(path, "destination", None, f"cannot be reached: {why}")
    width = road.lane_width_at(0, 0.0)
    if road.lanes and width < vehicle.width_m:
        raise InputError(path, "road.lane 0: width_m", width, f"is narrower at the host than its {vehicle.width_m:g} m")
    low, high = float(road.right_edge_at(0.0)), float(road.left_edge_at(0.0))
    if not low < host.d_m < high:
        raise InputError(path, "host.d_m", host.d_m, f"is off the road [{low:g}, {high:g}] m")
    frame = FrenetFrame(road=road)
    starts = [(0.0, host.d_m, host.heading_rad, host.speed_mps), *(neighbour.initial for neighbour in scene.neighbour)]
    sizes = np.array([(vehicle.length_m, vehicle.width_m), *((car.length_m, car.width_m) for car in scene.neighbour)])
    bodies = corners(*frame.to_plane(*np.array(starts)[:, :3].T), *sizes.T)
    for index, (s, _, _, v) in enumerate(starts[1:]):
        key = f"neighbour[{index}]"
        if v > 100.0:
            raise InputError(path, f"{key}.speed_mps", v, "exceeds 100 m/s (speeds are m/s, not km/h)")
        if not frame.s_min_m < s < frame.s_max_m:
            raise InputError(path, f"{key}.s_m", s, f"must lie in ({frame.s_min_m:g}, {frame.s_max_m:g}) m")
        apart = separation(bodies[index + 1], bodies[: index + 1])
        if apart.min() < 0.0:
            one = int(np.argmax(apart < 0.0))  # the first of them
            other = "host" if one == 0 else f"neighbour[{one - 1}] ({scene.neighbour_name(one - 1)})"
            raise InputError(path, f"{key}.s_m", s, f"overlaps {other} at the start by {-apart[one]:.2f} m")
