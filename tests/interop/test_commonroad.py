"""The CommonRoad door against the pinned reader: scenarios written here, and the published ones where they are at hand."""

from __future__ import annotations

import json
import math
import re
import tarfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.catalogue.vehicles import load_vehicle, vehicle_text
from mcdas_opt.errors import InputError, MissingExtraError
from mcdas_opt.interop.commonroad import library
from mcdas_opt.interop.commonroad.scenario import VEHICLE, own_vehicle, read_scenario
from tests.cli.command_line import run

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data" / "commonroad"


def lanelet(identifier: int, lane: int, *, left: int | None = None, right: int | None = None) -> str:
    """300 m of a straight lane of 3.5 m, rising to the north-east; lane 1 is to the left of lane 0."""
    c, s = math.cos(0.5), math.sin(0.5)

    def bound(side: str, d: float) -> str:
        points = "".join(f"<point><x>{c * x - s * d}</x><y>{s * x + c * d}</y></point>" for x in (-100.0, 0.0, 100.0, 200.0))
        return f"<{side}Bound>{points}</{side}Bound>"

    beside = "".join(f'<adjacent{side} ref="{ref}" drivingDir="same"/>' for side, ref in (("Left", left), ("Right", right)) if ref)
    low, high = 3.5 * lane - 1.75, 3.5 * lane + 1.75
    return f'<lanelet id="{identifier}">{bound("left", high)}{bound("right", low)}{beside}<laneletType>urban</laneletType></lanelet>'


def place(along: float, left: float) -> tuple[float, float]:
    c, s = math.cos(0.5), math.sin(0.5)
    return c * along - s * left, s * along + c * left


def state(tag: str, along: float, left: float, speed: float, step: int, turned: float = 0.0, extra: str = "") -> str:
    x, y = place(along, left)
    return (
        f"<{tag}><position><point><x>{x}</x><y>{y}</y></point></position><orientation><exact>{0.5 + turned}</exact></orientation>"
        f"<time><exact>{step}</exact></time><velocity><exact>{speed}</exact></velocity>{extra}</{tag}>"
    )


def scenario(ego_left: float = 0.2, lanes: bool = True, problem: bool = True) -> str:
    """Two lanes; somebody 30 m ahead in ours, slower by 4 m/s; a parked car 60 m ahead, turned, at the left edge."""
    motion = "".join(state("state", 30.0 + 0.1 * k * 8.0, 0.0, 8.0, k) for k in range(1, 41))
    shape = "<shape><rectangle><length>4.4</length><width>1.7</width></rectangle></shape>"
    extra = "<yawRate><exact>0.0</exact></yawRate><slipAngle><exact>0.0</exact></slipAngle>"
    ahead = (
        f'<dynamicObstacle id="7"><type>car</type>{shape}{state("initialState", 30.0, 0.0, 8.0, 0)}'
        f"<trajectory>{motion}</trajectory></dynamicObstacle>"
    )
    parked = (
        f'<staticObstacle id="8"><type>parkedVehicle</type>{shape}{state("initialState", 60.0, 5.0, 0.0, 0, turned=0.3)}</staticObstacle>'
    )
    goal = "<goalState><time><intervalStart>20</intervalStart><intervalEnd>40</intervalEnd></time></goalState>"
    asked = f'<planningProblem id="100">{state("initialState", 0.0, ego_left, 12.0, 0, extra=extra)}{goal}</planningProblem>'
    return (
        '<?xml version="1.0"?><commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Own-1_1_T-1" timeStepSize="0.1" author="a" '
        'affiliation="b" source="c" date="2026-11-21"><location><geoNameId>-999</geoNameId><gpsLatitude>999</gpsLatitude>'
        "<gpsLongitude>999</gpsLongitude></location><scenarioTags><urban/></scenarioTags>"
        + (lanelet(1, 0, left=2) + lanelet(2, 1, right=1) if lanes else "")
        + parked + ahead + (asked if problem else "") + "</commonRoad>"
    )  # fmt: skip


def written(folder: Path, **changes: Any) -> Path:
    path = folder / "own.xml"
    path.write_text(scenario(**changes), "utf-8")
    return path


def test_the_benchmarks_car_is_a_vehicle_file_whose_centre_is_that_of_gravity(tmp_path: Path) -> None:
    file, shipped = tmp_path / "centred.toml", load_vehicle(VEHICLE)
    file.write_text(vehicle_text(own_vehicle(15.0)), "utf-8")
    centred = load_vehicle(str(file))
    assert shipped.cog_to_front_axle_m is not None
    assert centred.centre_m == pytest.approx(centred.wheelbase_m - shipped.cog_to_front_axle_m)
    assert centred.length_m == pytest.approx(shipped.length_m)


@pytest.mark.parametrize(("begun_mps", "top_mps"), [(0.0, 20.0), (10.0, 20.0), (20.0, 30.0), (45.0, 50.8)])
def test_the_benchmarks_car_accelerates_as_it_can_at_every_speed_that_a_drive_needs(
    tmp_path: Path, begun_mps: float, top_mps: float
) -> None:
    file = tmp_path / "own.toml"
    file.write_text(vehicle_text(own_vehicle(begun_mps)), "utf-8")
    car = load_vehicle(str(file))
    assert car.speed_max_mps == pytest.approx(top_mps)
    assert car.acceleration_max_mps2 == pytest.approx(11.5 * 7.319 / top_mps, rel=0.01)


@pytest.fixture
def reader() -> None:
    pytest.importorskip("commonroad")
    pytest.importorskip("defusedxml")
    warnings.simplefilter("ignore")


@pytest.mark.usefixtures("reader")
def test_a_scenario_goes_wherever_a_scene_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path)
    assert load_scene(path).model_dump() == read_scenario(path).scene.model_dump()
    code, out, _ = run(monkeypatch, capsys, "simulate", str(path), "--json")
    drive = json.loads(out)
    assert (code, drive["outcome"], drive["unverified_plans"]) == (0, "safe", 0)
    _, out, _ = run(monkeypatch, capsys, "simulate", str(path))
    said = " ".join(out.replace("│", " ").split())
    assert "obstacles 2 in the scene, 0 left out" in said
    assert "goal reached after" in said or "goal not reached: " in said
    code, out, _ = run(monkeypatch, capsys, "plan", str(path), "--json")
    assert (code, json.loads(out)["status"]) == (0, "planned")


@pytest.mark.usefixtures("reader")
def test_an_xml_that_is_no_scenario_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "other.xml"
    path.write_text("<html/>", "utf-8")
    code, _, err = run(monkeypatch, capsys, "simulate", str(path))
    (line,) = err.splitlines()
    assert (code, "other.xml" in line) == (2, True)


@pytest.mark.usefixtures("reader")
def test_a_scenario_becomes_a_scene(tmp_path: Path) -> None:
    read = read_scenario(written(tmp_path))
    scene = read.scene
    assert (scene.road.lanes_left, scene.road.lanes_right) == (1, 0)
    assert scene.road.lane_width_m == pytest.approx(3.5)
    assert (scene.host.d_m, scene.host.heading_rad, scene.host.speed_mps) == pytest.approx((0.2, 0.0, 12.0), abs=1e-6)
    assert scene.duration_s == pytest.approx(4.0)
    assert read.obstacles == {"obstacle-7": 7, "obstacle-8": 8}
    assert read.left_out == {}
    ahead, parked = (part.samples for part in scene.neighbour)
    assert ahead is not None
    assert parked is not None
    assert ahead[:, 1] == pytest.approx(30.0 + 8.0 * ahead[:, 0], abs=1e-6)
    assert ahead[-1, 0] == pytest.approx(4.0)
    assert parked[:, 1:] == pytest.approx(np.array([[60.0, 5.0, 0.3, 0.0]] * 2), abs=1e-6)
    assert (read.placement.x_m, read.placement.y_m) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert read.placement.yaw_rad == pytest.approx(0.5)


@pytest.mark.usefixtures("reader")
def test_the_scene_is_written_as_files_that_load(tmp_path: Path) -> None:
    read = read_scenario(written(tmp_path))
    again = load_scene(read.write(tmp_path / "scene"))
    assert load_scene(read.write(str(tmp_path / "in_words"))).model_dump() == again.model_dump()
    assert again.model_dump() == read.scene.model_dump()
    assert all(
        np.array_equal(a.samples, b.samples) for a, b in zip(again.neighbour, read.scene.neighbour, strict=True) if a.samples is not None
    )


@pytest.mark.usefixtures("reader")
def test_a_drive_becomes_a_solution_that_the_reader_reads(tmp_path: Path) -> None:
    from commonroad.common.solution import CommonRoadSolutionReader

    from mcdas_opt.interop.commonroad.solution import write_solution
    from mcdas_opt.simulation.loop import simulate

    read = read_scenario(written(tmp_path))
    drive = simulate(read.scene)
    assert drive.outcome.value == "safe"
    path = write_solution(read, drive.trajectory, tmp_path / "solution.xml")
    assert path.read_bytes() == write_solution(read, drive.trajectory, tmp_path / "again.xml").read_bytes()
    answer = CommonRoadSolutionReader.open(str(path)).planning_problem_solutions[0]
    states = answer.trajectory.state_list
    assert answer.planning_problem_id == 100
    assert [state.time_step for state in states] == list(range(41))
    assert states[0].position == pytest.approx(np.array(place(0.0, 0.2)), abs=1e-6)
    assert states[0].velocity == pytest.approx(12.0)
    assert states[0].orientation == pytest.approx(0.5, abs=1e-6)
    last = read.frame.to_plane(*(np.array([q[-1]]) for q in (drive.trajectory.s_m, drive.trajectory.d_m, drive.trajectory.heading_rad)))
    assert states[-1].position == pytest.approx(np.concatenate(read.placement.to_plane(*last)[:2]), abs=1e-3)


@pytest.mark.usefixtures("reader")
def test_the_drivability_checker_finds_the_solution_valid(tmp_path: Path) -> None:
    pytest.importorskip("commonroad_dc")
    from commonroad.common.file_reader import CommonRoadFileReader
    from commonroad_dc.feasibility.solution_checker import obstacle_collision, solution_feasible

    from mcdas_opt.interop.commonroad.solution import solution
    from mcdas_opt.simulation.loop import simulate

    path = written(tmp_path)
    read = read_scenario(path)
    answer = solution(read, simulate(read.scene).trajectory)
    theirs, problems = CommonRoadFileReader(str(path)).open()
    assert not obstacle_collision(theirs, problems, answer)
    assert solution_feasible(answer, theirs.dt, problems)[100][0]


@pytest.mark.usefixtures("reader")
@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"lanes": False}, "lanelet: the scenario has no lane"),
        ({"ego_left": 9.0}, "no lane lies under the ego's first position"),
        ({"problem": False}, "planningProblem: the scenario has none, so that there is no ego"),
    ],
)
def test_a_scenario_without_a_lane_or_an_ego_is_refused(tmp_path: Path, changes: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_scenario(written(tmp_path, **changes))


@pytest.mark.usefixtures("reader")
def test_an_ego_without_a_speed_is_named_with_its_file(tmp_path: Path) -> None:
    path = written(tmp_path)
    path.write_text(path.read_text().replace("<exact>12.0</exact></velocity>", "<exact>nan</exact></velocity>"))
    with pytest.raises(InputError, match=r"own\.xml: planningProblem 100: speed_mps = nan: must be finite"):
        read_scenario(path)


@pytest.mark.usefixtures("reader")
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("not xml", "is no XML that is safe to read"),
        ('<!DOCTYPE a [<!ENTITY b "c"><!ENTITY d "&b;&b;">]><commonRoad>&d;</commonRoad>', "is no XML that is safe to read.*Entit"),
        ("<osm/>", "root element = 'osm': must be commonRoad"),
        ("<commonRoad/>", "is no CommonRoad scenario"),
    ],
)
def test_a_file_that_is_no_scenario_is_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "bad.xml"
    path.write_text(text)
    with pytest.raises(InputError, match=said):
        read_scenario(path)


@pytest.mark.usefixtures("reader")
def test_a_scenario_is_read_as_xml_whatever_the_file_is_called(tmp_path: Path) -> None:
    """One called `.pb` went to protobuf, of the one version that CommonRoad allows, which nested data bring down."""
    path = written(tmp_path).rename(tmp_path / "own.pb")
    assert read_scenario(path).scene.neighbour


@pytest.mark.usefixtures("reader")
def test_a_problem_that_is_not_there_and_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"planningProblem = 5: is none of the scenario's: 100"):
        read_scenario(written(tmp_path), problem=5)
    with pytest.raises(InputError, match="cannot be read"):
        read_scenario(tmp_path / "none.xml")


def test_another_version_is_refused_by_the_pins_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "version", lambda name: "2026.1")
    with pytest.raises(InputError, match=r"commonroad-io: version = '2026.1': must be 2024.3: pip install 'mcdas-opt\[commonroad\]'"):
        library.require()


def test_without_the_package_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> str:
        raise library.PackageNotFoundError(name)

    monkeypatch.setattr(library, "version", missing)
    with pytest.raises(MissingExtraError, match=r"pip install 'mcdas-opt\[commonroad\]'"):
        library.require()


def unpacked(folder: Path) -> list[Path]:
    with tarfile.open(SHARED / "reactive_planner_examples.tar.xz") as archive:
        archive.extractall(folder, filter="data")
    return sorted(folder.glob("**/*.xml"))[:4]


@pytest.mark.usefixtures("reader")
@pytest.mark.parametrize(
    ("scenarios", "least"),
    [
        pytest.param(lambda folder: [written(folder)], 2, id="our own"),
        pytest.param(unpacked, 11, id="published", marks=pytest.mark.published(SHARED)),
    ],
)
def test_obstacles_stay_where_they_are(tmp_path: Path, scenarios: Callable[[Path], list[Path]], least: int) -> None:
    """Whatever the fitted road is like, an obstacle goes into its frame and comes back to its own place."""
    read_any = 0
    for path in scenarios(tmp_path):
        try:
            read = read_scenario(path)
        except InputError:  # an ego that stands on no lane
            continue
        theirs, _ = library.read_file(path)
        obstacles = {obstacle.obstacle_id: obstacle for obstacle in [*theirs.dynamic_obstacles, *theirs.static_obstacles]}
        assert read.lane_off_m < 0.5
        for part, (name, identifier) in zip(read.scene.neighbour, read.obstacles.items(), strict=True):
            assert part.name == name
            assert part.samples is not None
            _, s, d, psi, _ = part.samples[0]
            x, y, yaw = read.placement.to_plane(*read.frame.to_plane(np.array([s]), np.array([d]), np.array([psi])))
            first = obstacles[identifier].initial_state
            assert (x[0], y[0]) == pytest.approx(tuple(first.position), abs=1e-6)
            assert math.remainder(float(yaw[0]) - first.orientation, math.tau) == pytest.approx(0.0, abs=1e-6)
            read_any += 1
    assert read_any >= least


@pytest.mark.parametrize("far", ["1e8", "1e300", "nan", "inf"])
def test_a_lanelet_that_goes_on_for_ever_is_refused_before_it_is_sampled(tmp_path: Path, far: str) -> None:
    """Every metre of it was: gigabytes, and a MemoryError."""
    path = tmp_path / "own.xml"
    path.write_text(re.sub(r"(<leftBound>.*?<x>)[^<]*", rf"\g<1>{far}", scenario(), count=1, flags=re.S), "utf-8")
    with pytest.raises(InputError, match=r"own\.xml"):
        read_scenario(path)
