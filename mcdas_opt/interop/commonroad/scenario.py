"""A CommonRoad scenario as a scene of ours: the ego's lane becomes the road, every obstacle a recorded neighbour on it."""

from __future__ import annotations

import math
import tempfile
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.catalogue.scenes import TRAJECTORY_COLUMNS, Scene, load_scene
from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.catalogue.vehicles import load_vehicle, vehicle_text
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, ParameterError, writing
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.commonroad.goal import destination
from mcdas_opt.interop.commonroad.lane_line import LaneLine, Placement, fit
from mcdas_opt.interop.commonroad.lanes import EgoLane, ego_lane, goal_lanelets
from mcdas_opt.interop.commonroad.library import read_file
from mcdas_opt.interop.commonroad.obstacle import Recorded, recorded
from mcdas_opt.interop.commonroad.road_lanes import with_lanes, with_surface

VEHICLE = "bmw_320i"  # vehicle type 2 of the benchmarks
VEHICLE_FILE = "commonroad_bmw_320i.toml"
SCENE_FILE = "scene.toml"
_LONGEST_S = 600.0
_ABOVE_MEAN, _HELD_UP = 1.25, 0.5
_LEAST_TOP_MPS, _TOP_TIMES = 20.0, 1.5  # nobody in these scenarios drives faster than so, or so many times its first speed


@dataclass(frozen=True, slots=True, kw_only=True)
class CommonRoadScene:
    """`scene` is ours; `placement` takes its plane to the scenario's. `left_out`: obstacles that are not in it, and why.

    `goal_is_off`: why no goal can be reached along the ego's road, empty where one may be: then it is the scene's destination.
    `map_end_s_m`: where the last lanelet ends, after which the road is taken to go on straight; None where it ends farther than we look.
    `lane_off_m`: the largest distance of our reference line from the lane's middle. `obstacles`: neighbour's name to the obstacle's id.
    """

    scene: Scene
    placement: Placement
    scenario_id: Any = field(repr=False)
    problem: Any = field(repr=False)
    step_s: float
    first_step: int
    obstacles: dict[str, int]
    left_out: dict[int, str]
    lane_off_m: float
    lanelets: tuple[int, ...]
    goal_is_off: str
    map_end_s_m: float | None
    files: dict[str, str] = field(repr=False)

    @property
    def problem_id(self) -> int:
        return int(self.problem.planning_problem_id)

    @property
    def frame(self) -> FrenetFrame:
        return FrenetFrame(road=self.scene.true_road)

    def write(self, folder: str | Path) -> Path:
        """The scene as files that `load_scene` reads; returns the scene file."""
        return _write(self.files, Path(folder))


def read_scenario(path: str | Path, problem: int | None = None, *, vehicle: str | None = None) -> CommonRoadScene:
    """The scenario's planning problem (default the first) as a scene. The road is that of one direction, of the ego lane's width there.

    `vehicle` is a shipped name or a path; None: the benchmarks' BMW 320i, its body centred on its centre of gravity, as states are there.

    Raises `InputError` for a file that is no scenario, a planning problem that it does not have, an ego without a lane under it, or
    another version of commonroad-io than the pinned one (named); `MissingExtraError` without it.
    """
    path = Path(path)
    scenario, problems = read_file(path)
    chosen = _problem(problems, problem, path)
    lane = ego_lane(scenario, chosen, path)
    first = chosen.initial_state
    line = fit(lane.polyline, np.asarray(first.position, dtype=np.float64))
    road = _road(lane, line, path)
    frame = FrenetFrame(road=road)
    zero = np.zeros(1)
    x, y, yaw = line.placement.to_frame(zero + first.position[0], zero + first.position[1], zero + first.orientation)
    own_s, own_d, own_psi = (float(q[0]) for q in frame.to_road(x, y, yaw, near_s_m=0.0))
    if abs(own_s) > 1e-6:  # the fitted line's own foot is s = 0
        line, road, frame = _moved(line, lane, own_s, frame, path)
    begun_mps = max(float(first.velocity), 0.0)
    car = load_vehicle(vehicle) if vehicle else own_vehicle(begun_mps)
    goals = goal_lanelets(scenario.lanelet_network, chosen)
    road = _described(road, lane, line, scenario.lanelet_network, goals, own_d, own_psi, car)
    duration = _duration(scenario, chosen)
    begun = _begun(own_d, own_psi, begun_mps, chosen, path)
    goal, off = destination(chosen, scenario.lanelet_network, road, lane, line.placement, begun, float(scenario.dt), car)
    names: dict[str, int] = {}
    left_out: dict[int, str] = {}
    tables: dict[str, Recorded] = {}
    for obstacle in [*scenario.dynamic_obstacles, *scenario.static_obstacles]:
        found = recorded(obstacle, float(scenario.dt), int(first.time_step), duration, line.placement, frame)
        if isinstance(found, str):
            left_out[int(obstacle.obstacle_id)] = found
            continue
        name = f"obstacle-{obstacle.obstacle_id}"
        names[name] = int(obstacle.obstacle_id)
        tables[name] = found
    desired_mps = min(_pace_mps(road, begun, goal), car.speed_max_mps)
    host = {
        "d_m": own_d,
        "heading_rad": own_psi,
        "speed_mps": begun_mps,
        "desired_speed_mps": desired_mps,
        "vehicle": vehicle or VEHICLE_FILE,
    }
    while True:
        files = _files(path.stem, road, host, goal, tables, duration) | ({VEHICLE_FILE: vehicle_text(car)} if vehicle is None else {})
        try:
            with tempfile.TemporaryDirectory() as folder:
                scene = load_scene(_write(files, Path(folder)))
            break
        except InputError as error:
            blamed = _blamed(error, list(tables))
            if blamed is None:
                file = Path(error.file)
                of = "" if file.name == SCENE_FILE else f"{file.stem}: "
                raise InputError(path, f"{of}{error.key}", error.value, error.rule) from None
            left_out[names.pop(blamed)] = error.rule
            del tables[blamed]
    return CommonRoadScene(
        scene=scene,
        placement=line.placement,
        scenario_id=scenario.scenario_id,
        problem=chosen,
        step_s=float(scenario.dt),
        first_step=int(first.time_step),
        obstacles=names,
        left_out=left_out,
        lane_off_m=line.off_m,
        lanelets=lane.lanelets,
        goal_is_off=off,
        map_end_s_m=line.length_m if lane.ends else None,
        files=files,
    )


def scene_of(path: str | Path) -> Scene:
    """The scene of its first planning problem: what `load_scene` finds behind an .xml. Raises as `read_scenario`."""
    return read_scenario(path).scene


def _problem(problems: Any, wanted: int | None, path: Path) -> Any:
    known = problems.planning_problem_dict
    if not known:
        raise InputError(path, "planningProblem", None, "the scenario has none, so that there is no ego")
    if wanted is None:
        return next(iter(known.values()))
    if wanted not in known:
        raise InputError(path, "planningProblem", wanted, "is none of the scenario's: " + ", ".join(map(str, known)))
    return known[wanted]


def _begun(d_m: float, heading_rad: float, speed_mps: float, problem: Any, path: Path) -> HostState:
    try:
        return HostState(d_m=d_m, heading_rad=heading_rad, speed_mps=speed_mps)
    except ParameterError as error:
        raise InputError(path, f"planningProblem {problem.planning_problem_id}: {error.name}", error.value, error.rule) from None


def _road(lane: EgoLane, line: LaneLine, path: Path) -> Road:
    """The ego's lane alone."""
    try:
        return Road(lane_width_m=lane.width_m, curvature=line.curvature)
    except ParameterError as error:
        raise InputError(path, f"lanelets {lane.lanelets}: {error.name}", error.value, error.rule) from None


def _described(
    road: Road, lane: EgoLane, line: LaneLine, network: Any, goals: set[int], own_d_m: float, own_psi_rad: float, car: Vehicle
) -> Road:
    """The road with its lanes and what lies beside them; without what the lanelets make no road of."""
    reach = 0.5 * (car.width_m * math.cos(own_psi_rad) + car.length_m * abs(math.sin(own_psi_rad)))
    with suppress(ParameterError):
        road = with_lanes(road, network, lane, line.placement, goals)
    with suppress(ParameterError):
        road = with_surface(road, network, line.placement, own_d_m, reach)
    return road


def _pace_mps(road: Road, begun: HostState, goal: Destination | None) -> float:
    """What the ego wants to drive: the speed that it begins with, or what the goal asks for and some more, since its mean is not driven
    from the beginning on. Who begins at less than half of the lane's limit, where the map has one, is held up and wants that."""
    if goal is None or goal.s_m is None or goal.time_s is None:
        return begun.speed_mps
    limit_mps = road.limits_from(road.lane_of(begun.d_m, 0.0), 0.0)[0][1]
    if begun.speed_mps < _HELD_UP * limit_mps < _HELD_UP * road.speed_limit_mps:
        return limit_mps
    mean_mps = max(sum(goal.s_m), 0.0) / max(sum(goal.time_s), 1.0)
    return max(begun.speed_mps, min(_ABOVE_MEAN * mean_mps, limit_mps))


def _moved(line: LaneLine, lane: EgoLane, by_m: float, frame: FrenetFrame, path: Path) -> tuple[LaneLine, Road, FrenetFrame]:
    """The same line with s counted from `by_m` on, so that the ego's s is 0."""
    zero = np.zeros(1)
    x, y, yaw = line.placement.to_plane(*frame.to_plane(zero + by_m, zero, zero))
    moved = LaneLine(
        placement=Placement(x_m=float(x[0]), y_m=float(y[0]), yaw_rad=float(yaw[0])),
        curvature=tuple((s - by_m, kappa) for s, kappa in line.curvature),
        off_m=line.off_m,
        length_m=line.length_m - by_m,
    )
    road = _road(lane, moved, path)
    return moved, road, FrenetFrame(road=road)


def _duration(scenario: Any, problem: Any) -> float:
    """Until the last moment in which the goal may be reached, or the scenario's obstacles end."""
    from commonroad.common.util import Interval

    steps = (state.time_step for state in problem.goal.state_list if state.time_step is not None)
    ends = [int(step.end if isinstance(step, Interval) else step) for step in steps]
    last = max((end - problem.initial_state.time_step for end in ends), default=0)
    return round(float(min(max(last * scenario.dt, 1.0), _LONGEST_S)), 9)


def _files(
    name: str,
    road: Road,
    host: dict[str, Any],
    goal: Destination | None,
    tables: dict[str, Recorded],
    duration_s: float,
) -> dict[str, str]:
    """The scene's files by name."""
    files: dict[str, str] = {}
    neighbours = []
    for neighbour, one in tables.items():
        table = {"name": neighbour, "trajectory": f"{neighbour}.csv", "length_m": one.length_m, "width_m": one.width_m}
        neighbours.append(table | {"leaves": one.leaves, "kind": None if one.kind is None else one.kind.value})
        rows = [",".join(repr(float(value)) for value in row) for row in one.samples]
        files[f"{neighbour}.csv"] = "\n".join([",".join(TRAJECTORY_COLUMNS), *rows]) + "\n"
    document = {
        "name": _plain(name),
        "duration_s": duration_s,
        "road": {
            "lane_width_m": road.lane_width_m,
            "lanes_left": road.lanes_left,
            "lanes_right": road.lanes_right,
            "curvature": road.curvature,
            "lane": [to_document(lane) for lane in road.lanes],
        },
        "destination": goal and asdict(goal),
        "host": host,
        "neighbour": neighbours,
    }
    return {SCENE_FILE: toml_text(document), **files}


def own_vehicle(speed_mps: float) -> Vehicle:
    """The shipped car for drives that begin at this speed: the body's centre is the centre of gravity.

    The benchmarks' car accelerates by 11.5 m/s^2 up to 7.319 m/s, and by that times 7.319 / v beyond. The shipped file holds what it can do
    at every speed up to 50.8 m/s; this one is no faster than a drive needs, and accelerates as it can at every speed up to there.
    """
    car = load_vehicle(VEHICLE)
    top = min(max(_LEAST_TOP_MPS, _TOP_TIMES * speed_mps), car.speed_max_mps)
    car = replace(car, speed_max_mps=top, acceleration_max_mps2=car.acceleration_max_mps2 * car.speed_max_mps / top)
    assert car.cog_to_front_axle_m is not None
    front = 0.5 * car.length_m - car.cog_to_front_axle_m
    rear = car.length_m - car.wheelbase_m - front
    return replace(car, front_overhang_m=front, rear_overhang_m=rear)


def _plain(name: str) -> str:
    return "".join(letter if letter.isalnum() or letter in "-_. " else "_" for letter in name)


def _write(files: dict[str, str], folder: Path) -> Path:
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).write_text(text, "utf-8")
    return folder / SCENE_FILE


def _blamed(error: InputError, names: list[str]) -> str | None:
    """The neighbour that a scene is refused for: it overlaps somebody at the start, or stands beyond the road's ends."""
    if not (error.key.startswith("neighbour[") and error.key.endswith("].s_m")):
        return None
    index = int(error.key.removeprefix("neighbour[").split("]")[0])
    return names[index] if index < len(names) else None
