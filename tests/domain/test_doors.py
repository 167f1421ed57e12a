"""Whatever is given to a constructor: a record, or one sentence that names field and rule; and what is made can be planned for."""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.attack.records import HOST, fields, needed, records
from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.catalogue.trajectories import load_trajectory
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import SelectorSettings, Settings, SigmoidSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request, Sector, Side
from mcdas_opt.errors import InputError, McdasError, ParameterError, printable, writing
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.recordings.csv_table import CsvTable
from mcdas_opt.interop.replay import replay
from mcdas_opt.parking.case_file import load_parking_case
from mcdas_opt.parking.park import PLANNERS, park
from mcdas_opt.parking.settings import ParkSettings
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.solver_settings import SolverSettings
from mcdas_opt.planning.stateless import plan as plan_of
from mcdas_opt.simulation.first_situation import load_situation
from mcdas_opt.simulation.judging import verify
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.studio.folder import Folder
from mcdas_opt.time_to_react.escapes import escapes
from mcdas_opt.tuning.request import DesignRequest
from mcdas_opt.tuning.tune import tune

PLAN = plan_of(Situation(host=HOST, coverage=Coverage()), planner="closed-form-corrected")
HOSTILE: tuple[Any, ...] = (
    None, "x", "", b"x", (), (1,), [None], {}, {"front": False}, object(), True, 1j, math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324,
    0, -1, 7, 10**400, np.array([1.0, 2.0]), np.float64(3.0), np.nan, ((1e300, 0.0),), ((0.0, 1e300),), (("0", "1"),), [(0.0, 5e-324)],
)  # fmt: skip


class Answering:
    """A method that has one answer."""

    has_ladder, vehicle = False, Vehicle()

    def __init__(self, answer: Any) -> None:
        self.answers = answer

    def plan(self, situation: Situation, previous: Plan | None) -> Any:
        return self.answers


def answering(answer: Any) -> Plan:
    return Planner(method=Answering(answer)).plan(Situation(host=HOST, coverage=Coverage()))


@pytest.mark.parametrize("record", records())
def test_a_field_takes_a_value_or_says_why_not(record: type) -> None:
    """Of every record that has rules: one that is new is here without being named."""
    assert record(**needed(record))
    for field in fields(record):
        for value in HOSTILE:
            with contextlib.suppress(McdasError):
                record(**{**needed(record), field.name: value})
        if field.type != "object":
            with pytest.raises(McdasError):
                record(**{**needed(record), field.name: object()})


@pytest.mark.parametrize("record", [HostState, Road, Track, Situation])
def test_what_is_taken_is_planned_for(record: type) -> None:
    """Judged and finite, however absurd."""
    planner = Planner()
    for field in fields(record):
        for value in HOSTILE if field.name != "vehicle" else ():  # another car has another planner
            try:
                made = record(**{**needed(record), field.name: value})
                parts = {Situation: {}, HostState: {"host": made}, Road: {"road": made}, Track: {"tracks": (made,)}}[record]
                situation = made if record is Situation else Situation(**{"host": HOST, "coverage": Coverage(), **parts})
            except McdasError:
                continue
            planner.reset()
            plan = planner.plan(situation)
            assert np.isfinite(plan.trajectory.table).all(), (field.name, value)


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: Situation(host=None, coverage=Coverage()), "host = None: must be a HostState"),
        (lambda: Situation(host=HOST, tracks=None, coverage=Coverage()), "tracks = None: must be a list of Track"),
        (lambda: Situation(host=HOST, tracks=(1,), coverage=Coverage()), "tracks[0] = 1: must be a Track"),
        (lambda: Situation(host=HOST, coverage={"front": False}), "coverage = {'front': False}: must be a Coverage"),
        (lambda: Situation(host=HOST, vehicle=Vehicle(), coverage=Coverage()), "must be a str"),
        (lambda: Situation(host=HOST, request="fly", coverage=Coverage()), "request = 'fly': must be one of drive, park"),
        (lambda: Situation(host=HostState(s_m=1e10), coverage=Coverage()), "host.s_m = 10000000000.0 m: must lie in [-1e+09, 1e+09]"),
        (lambda: Road(friction=5e-324), "friction = 5e-324: must lie in [0.01, 10]"),
        (lambda: Road(lane_width_m=5e-324), "lane_width_m = 5e-324 m: must lie in [0.1, 20]"),
        (lambda: Road(lane_width_m=25.0), "must lie in [0.1, 20]"),
        (lambda: Road(road_end_s_m="x"), "road_end_s_m = 'x' m: must be a number"),
        (lambda: Road(road_end_s_m=math.nan), "road_end_s_m = nan m: must be finite"),
        (lambda: Road(curvature=((1e300, 0.0),)), "must lie within"),
        (lambda: Track(**needed(Track) | {"id": 1}), "id = 1: must be a str"),
        (lambda: Track(**needed(Track) | {"speed_s_mps": 1e308}), "speed_s_mps = 1e+308 m/s: must lie in"),
        (lambda: Track(**needed(Track) | {"acceleration_s_mps2": 1e308}), "acceleration_s_mps2 = 1e+308 m/s^2: must lie in"),
        (lambda: Track(**needed(Track) | {"acceleration_s_sd_mps2": -1.0}), "acceleration_s_sd_mps2 = -1.0 m/s^2: must lie in"),
        (lambda: Coverage(front="yes"), "front = 'yes': must be true or false"),
        (lambda: Scan(**needed(Scan) | {"t_s": "now"}), "t_s = 'now' s: must be a number"),
        (lambda: Scan(**needed(Scan) | {"sector": "up"}), "sector = 'up': must be one of front, rear, left, right"),
        (lambda: Scan(**needed(Scan), radar=None), "radar = None: must be a list of RadarDetection"),
        (lambda: RadarDetection(range_m="far", azimuth_rad=0.0, range_rate_mps=0.0), "range_m = 'far' m: must be a number"),
        (lambda: HostState(speed_mps=10**400), "must be finite"),
        (lambda: Settings(cycle_s=0), "cycle_s = 0 s: must lie in [0.001, 10]"),
        (lambda: Settings(selector={}), "selector = {}: must be a SelectorSettings"),
        (lambda: SelectorSettings(tie_break="up"), "tie_break = 'up': must be one of"),
        (lambda: Planner(method=None), "method = None: must be the name of a planner"),
        (lambda: Planner(vehicle=3), "vehicle = 3: must be a str or a Vehicle"),
        (lambda: Planner(settings={}), "settings = {}: must be a Settings"),
        (lambda: Planner(settings={"cycle_s": 0.1}), "must be a Settings"),
        (lambda: Planner(road="straight"), "road = 'straight': must be a Road"),
        (lambda: Planner().plan("sandwich-60-40"), "situation = 'sandwich-60-40': must be a Situation"),
        (lambda: plan_of(load_scene("sandwich-60-40")), "must be a Situation"),
        (lambda: simulate(None), "scene = None: must be a Scene"),
        (lambda: simulate("sandwich-60-40", settings={"cycle_s": 0.1}), "must be a Settings"),
        (lambda: park(None), "case = None: must be a ParkingCase"),
        (lambda: park("parallel", settings={}), "settings = {}: must be a ParkSettings"),
        (lambda: plan_of(None), "situation = None: must be a Situation"),
        (lambda: Planner().step(None, HOST, 0.0), "measurements = None: must be a list of Scan"),
        (lambda: Planner().step(["scan"], HOST, 0.0), "measurements[0] = 'scan': must be a Scan"),
        (lambda: Planner().step([], None, 0.0), "host = None: must be a HostState"),
        (lambda: Planner().step([], HOST, "now"), "now = 'now' s: must be a number"),
        (lambda: Planner().step([], HOST, 0.0, road="straight"), "road = 'straight': must be a Road"),
        (lambda: Planner().step([], HOST, 0.0, request="fly"), "request = 'fly': must be one of drive, park"),
        (lambda: Planner(method=Planner), "is a class: give Planner(...)"),
        (lambda: Planner(name=3), "name = 3: must be a str"),
        (
            lambda: Planner("bmw_320i", "aeb").plan(Situation(host=HOST, vehicle="sedan", coverage=Coverage())),
            "is not the car of this planner, 'bmw_320i'",
        ),
        (lambda: answering(None), "the answer of Answering = None: must be a Plan or a Refusal"),
        (lambda: answering(3), "must be a Plan or a Refusal"),
        (lambda: replace(PLAN, mode="fly"), "mode = 'fly': must be one of hold, cruise"),
        (lambda: replace(PLAN, verdict=True), "verdict = True: must be a Verdict"),
        (lambda: replace(PLAN, trajectory=None), "trajectory = None: must be a Trajectory"),
        (lambda: replace(PLAN, candidates=("left",)), "candidates[0] = 'left': must be a Candidate"),
        (lambda: Refusal(reason=3), "reason = 3: must be a str"),
        (lambda: plan_of(Situation(host=HOST, coverage=Coverage()), planner=3), "planner = 3: must be a str"),
        (lambda: plan_of(Situation(host=HOST, coverage=Coverage()), vehicle={}), "vehicle = {}: must be a str or a Vehicle"),
        (lambda: plan_of(Situation(host=HOST, coverage=Coverage()), settings={}), "settings = {}: must be a Settings"),
        (lambda: simulate("sandwich-60-40", Planner), "planner = <class"),
        (lambda: simulate("sandwich-60-40", seed="x"), "seed = 'x': must be a whole number"),
        (lambda: simulate("sandwich-60-40", seed=-1), "seed = -1: must be at least 0"),
        (lambda: simulate("sandwich-60-40", None), "must be the name of a planner"),
        (lambda: simulate("sandwich-60-40", plant="x"), "plant = 'x'"),
        (lambda: park("parallel", None), "planner = None: is unknown"),
        (lambda: verify(PLAN, load_scene("sandwich-60-40")), "must be a Trajectory"),
        (lambda: verify(PLAN.trajectory, None), "target = None: must be a Scene or a Situation"),
        (lambda: escapes(load_scene("sandwich-60-40")), "must be a Situation"),
        (lambda: escapes(Situation(host=HOST, coverage=Coverage()), 3), "vehicle = 3: must be a Vehicle"),
        (lambda: tune(vehicle="sedan"), "vehicle = 'sedan': must be a Vehicle"),
        (lambda: tune(side="up"), "side = 'up': must be one of left, right, none"),
        (lambda: Situation.from_json(None), "text = None: must be a str"),
        (lambda: Vehicle(wheelbase_m=2.7e-9), "wheelbase_m = 2.7e-09 m: must lie in [0.1, 50]"),
        (lambda: Vehicle(cog_height_m=10.0), "cog_height_m = 10.0 m: must lie in [0, 5.29559]"),
        (lambda: Vehicle(cog_to_front_axle_m=3.0), "cog_to_front_axle_m = 3.0 m: must be less than the wheelbase 2.7"),
        (lambda: GripMonitor(vehicle=Vehicle(), believed=1.0, step_s=5e-324), "step_s = 5e-324 s: must lie in [0.0001, 1]"),
        (lambda: FrenetFrame(road=Road(curvature=((0.0, 0.01),)), s_max_m=1e9), "s_max_m = 1000000000.0 m: must lie in [-400, 999600]"),
        (lambda: SolverSettings(weights=(("jerk", "x"),)), "weights[0][1] = 'x': must be a number"),
        (lambda: SolverSettings(slots=(10**9,)), "slots = (1000000000,): must be numbers of neighbours from 1 to 64"),
        (lambda: SolverSettings(newton_steps=10**9), "newton_steps = 1000000000: must lie in [1, 10000]"),
        (lambda: SigmoidSettings(lateral_acceleration_mps2=5e-324), "must lie in [1e-09, 1e+09]"),
        (lambda: Settings(speed_limit_excess=5), "speed_limit_excess = 5: must lie in [0, 1], a share: 0.05 is 5 %?"),
        (lambda: Settings(speed_limit_excess=-0.1), "speed_limit_excess = -0.1: must lie in [0, 1]"),
        (lambda: ParkSettings(resolutions=(None,)), "resolutions[0] = None: must be a Resolution"),
        (lambda: DesignRequest(b_bounds=(3.0,)), "b_bounds = (3.0,): must be a list of 2"),
        (lambda: CsvTable("a\0b"), "no file has a NUL in its name"),
        (lambda: CsvTable(3), "path = 3: must be a str or a Path"),
        (lambda: Situation.from_json(b"{}"), "text = b'{}': must be a str"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_sentence(build: Callable[[], object], said: str) -> None:
    with pytest.raises((ParameterError, InputError)) as caught:
        build()
    assert said in str(caught.value)


def _written(name: str) -> None:
    with writing(name):
        pytest.fail("nothing is written")


def _studio_folder(name: str) -> None:
    Folder(root=Path(name))


@pytest.mark.parametrize("load", [load_scene, load_vehicle, load_parking_case, load_situation, load_trajectory])
@pytest.mark.parametrize("name", ["", "a" * 5000, "a\0b", "/", "/dev/null", ".", "a/b.toml", "\ud800", "x.json", "a" * 5000 + ".json"])
def test_a_name_that_no_file_has_is_bad_input(load: Callable[[str], object], name: str) -> None:
    with pytest.raises(InputError):
        load(name)


@pytest.mark.parametrize(
    ("name", "rule"),
    [
        ("a\0b", "no file has a NUL in its name"),
        ("a" * 5000, "is longer than a file's name may be"),
        ("a/" * 3000, "is longer than a file's name may be"),
        ("\ud800\ud801", "no file has a name with characters that the system cannot encode"),
    ],
    ids=["nul", "long", "long path", "surrogates"],
)
@pytest.mark.parametrize(
    "take",
    [
        load_scene,
        load_vehicle,
        load_parking_case,
        load_situation,
        load_trajectory,
        replay,
        simulate,
        park,
        CsvTable,
        _written,
        _studio_folder,
    ],
)
def test_a_name_that_no_file_can_have_is_told_with_its_rule(take: Callable[[str], object], name: str, rule: str) -> None:
    with pytest.raises(InputError, match=rule) as told:
        take(name)
    assert str(told.value).startswith(printable(name[:2]))
    assert len(str(told.value)) < 300


@pytest.mark.parametrize("name", ["a" * 5000, b"\xff" * 300])
@pytest.mark.parametrize("command", [["plan", "{}"], ["replay", "{}"], ["park", "{}"], ["studio", "--no-show", "--folder", "{}"]])
def test_a_command_given_such_a_name_says_so_in_a_line(command: list[str], name: str | bytes) -> None:
    arguments = [os.fsencode(word) if word != "{}" else os.fsencode(name) for word in command]
    done = subprocess.run([os.fsencode(sys.executable), b"-m", b"mcdas_opt", *arguments], capture_output=True, timeout=120)
    assert done.returncode == 2
    assert done.stderr.count(b"\n") == 1
    assert b"longer than a file's name may be" in done.stderr


def test_a_planner_of_words_drives_as_one_of_enums() -> None:
    """It died at the end of the drive, where its modes are counted."""
    said = simulate("benign-following", planner=Answering(replace(PLAN, mode="brake", side="none", status="planned", alert="warn")))
    assert said.modes == ((0.0, "brake"),)


def test_an_acceleration_whose_square_is_no_number_is_planned_for() -> None:
    """It divided nothing by nothing."""
    track = Track(**needed(Track) | {"acceleration_s_mps2": 1e-200, "acceleration_s_sd_mps2": 0.0})
    assert Planner().plan(Situation(host=HOST, tracks=(track,), coverage=Coverage())).verdict.passed


def test_words_will_do_where_a_closed_set_is_meant() -> None:
    assert Situation(host=HOST, request="park", coverage=Coverage()).request is Request.PARK
    assert Scan(**needed(Scan) | {"sector": "rear"}).sector is Sector.REAR
    assert SelectorSettings(tie_break="right").tie_break is Side.RIGHT
    assert Situation(host=HOST, tracks=[Track(**needed(Track))], coverage=Coverage()).tracks == (Track(**needed(Track)),)


def test_names_will_do_where_a_scene_or_a_case_is_meant() -> None:
    by_name = simulate("sandwich-60-40", "closed-form-corrected")
    assert by_name.outcome == simulate(load_scene("sandwich-60-40"), "closed-form-corrected").outcome
    assert park("parallel", PLANNERS[-1]).planner == PLANNERS[-1]
    with pytest.raises(InputError, match="sandwich"):
        simulate("sandwich-60-4")
