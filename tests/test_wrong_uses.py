"""Wrong uses of the Python API, as a beginner or a hurried colleague makes them: each is one sentence that says what is wrong.

Python's own `TypeError` for an argument that a function does not have is left to Python; everything else is an error of ours.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import mcdas_opt as mo


@cache
def situation() -> mo.Situation:
    return mo.load_situation("sandwich-60-40")


@cache
def scene() -> mo.Scene:
    return mo.load_scene("sandwich-60-40")


@cache
def plan() -> mo.Plan:
    return mo.plan(situation(), planner="closed-form-corrected")


def planner() -> mo.Planner:
    return mo.Planner(method="closed-form-corrected")


def scan(**changes: Any) -> mo.Scan:
    return mo.Scan(**{"sensor": "front", "sector": mo.Sector.FRONT, "t_s": 0.0, "mounting": mo.Mounting(), "radar": (), **changes})


def detection(**changes: Any) -> mo.RadarDetection:
    return mo.RadarDetection(**{"range_m": 30.0, "azimuth_rad": 0.0, "range_rate_mps": 0.0, **changes})


def track(**changes: Any) -> mo.Track:
    return mo.Track(**{"id": "1", "s_m": 30.0, "d_m": 0.0, "speed_s_mps": 10.0, **changes})


ANY: Any = None  # what a type checker would have refused
WRONG: dict[str, Callable[[], object]] = {
    # planning
    "plan(a file's name that is none)": lambda: mo.plan(mo.load_situation("sandwich-60-4O")),
    "plan(a scene)": lambda: mo.plan(ANY or scene()),
    "plan(a document)": lambda: mo.plan(ANY or situation().to_dict()),
    "plan(None)": lambda: mo.plan(ANY),
    "plan(text)": lambda: mo.plan(ANY or "sandwich-60-40"),
    "plan by an unknown planner": lambda: mo.plan(situation(), planner="mcp"),
    "plan by a number": lambda: mo.plan(situation(), planner=ANY or 3),
    "plan for an unknown vehicle": lambda: mo.Planner("sedam"),
    "Planner(a number)": lambda: mo.Planner(ANY or 5),
    "Planner(a document)": lambda: mo.Planner(ANY or {"wheelbase_m": 2.7}),
    "Planner by None": lambda: mo.Planner(method=ANY),
    "Planner with a document as settings": lambda: mo.Planner(settings=ANY or {"cycle_s": 0.1}),
    "Planner with a scene as road": lambda: mo.Planner(road=ANY or scene()),
    "Planner with a deadline of text": lambda: mo.Planner(deadline_s=ANY or "fast"),
    "Planner with a deadline of nothing": lambda: mo.Planner(deadline_s=-1.0),
    "Planner.plan(None)": lambda: planner().plan(ANY),
    "Planner.plan(a plan)": lambda: planner().plan(ANY or plan()),
    # scans to plans
    "step(a detection)": lambda: planner().step(ANY or detection(), mo.HostState(speed_mps=10.0), 0.0),
    "step(detections)": lambda: planner().step(ANY or [detection()], mo.HostState(speed_mps=10.0), 0.0),
    "step(one scan)": lambda: planner().step(ANY or scan(), mo.HostState(speed_mps=10.0), 0.0),
    "step(None)": lambda: planner().step(ANY, mo.HostState(speed_mps=10.0), 0.0),
    "step with a speed as host": lambda: planner().step((), ANY or 10.0, 0.0),
    "step at no time": lambda: planner().step((), mo.HostState(speed_mps=10.0), ANY),
    "step at NaN": lambda: planner().step((), mo.HostState(speed_mps=10.0), float("nan")),
    # records
    "host at NaN": lambda: mo.HostState(speed_mps=float("nan")),
    "host of text": lambda: mo.HostState(speed_mps=ANY or "fast"),
    "host of None": lambda: mo.HostState(speed_mps=ANY),
    "track without a size": lambda: track(length_m=0.0),
    "track of text": lambda: track(s_m="thirty"),
    "track with an infinite speed": lambda: track(speed_s_mps=float("inf")),
    "track with a diagonal as covariance": lambda: track(covariance=np.ones(4)),
    "track with an indefinite covariance": lambda: track(covariance=-np.eye(4)),
    "road without a width": lambda: mo.Road(lane_width_m=0.0),
    "road with half a lane": lambda: mo.Road(lanes_left=ANY or 0.5),
    "road of ice and more": lambda: mo.Road(friction=-0.1),
    "road with a number as curvature": lambda: mo.Road(curvature=ANY or 0.01),
    "situation without a host": lambda: mo.Situation(time_s=0.0, coverage=mo.Coverage(), host=ANY),
    "situation with one track": lambda: mo.Situation(
        time_s=0.0, coverage=mo.Coverage(), host=mo.HostState(speed_mps=10.0), tracks=ANY or track()
    ),
    "situation with text as tracks": lambda: mo.Situation(
        time_s=0.0, coverage=mo.Coverage(), host=mo.HostState(speed_mps=10.0), tracks=ANY or "none"
    ),
    "situation with two tracks of one id": lambda: mo.Situation(
        time_s=0.0, coverage=mo.Coverage(), host=mo.HostState(speed_mps=10.0), tracks=(track(), track())
    ),
    "coverage of text": lambda: mo.Coverage(front=ANY or "yes"),
    "scan of an unknown sector": lambda: scan(sector="top"),
    "scan with one detection": lambda: scan(radar=detection()),
    "settings of an endless cycle": lambda: mo.Settings(cycle_s=float("inf")),
    "vehicle without a wheelbase": lambda: mo.Vehicle(wheelbase_m=0.0),
    # files
    "load_scene(nothing)": lambda: mo.load_scene(ANY),
    "load_scene(a name that is none)": lambda: mo.load_scene("sandwich"),
    "load_scene(a folder)": lambda: mo.load_scene("/"),
    "load_vehicle(a name that is none)": lambda: mo.load_vehicle("sedann"),
    "load_sensor(a name that is none)": lambda: mo.load_sensor("esr"),
    "load_situation(a number)": lambda: mo.load_situation(ANY or 7),
    "load_trajectory(a file that is none)": lambda: mo.load_trajectory("nowhere.csv"),
    "load_parking_case(a number)": lambda: mo.load_parking_case(ANY or 7),
    # driving and judging
    "simulate(a situation)": lambda: mo.simulate(ANY or situation()),
    "simulate(a name that is none)": lambda: mo.simulate(mo.load_scene("cut-in-nowhere")),
    "simulate by an unknown planner": lambda: mo.simulate(scene(), "mpcc"),
    "simulate on an unknown plant": lambda: mo.simulate(scene(), "aeb", plant="kinematik"),
    "simulate with text as seed": lambda: mo.simulate(scene(), "aeb", seed=ANY or "one"),
    "verify(a plan without its place)": lambda: mo.verify(ANY, plan().trajectory),
    "verify(a plan, not its trajectory)": lambda: mo.verify(scene(), ANY or plan()),
    "escapes(a scene)": lambda: mo.escapes(ANY or scene()),
    "escapes(None)": lambda: mo.escapes(ANY),
    # parking, tuning, benchmarks, recordings
    "park(a name that is none)": lambda: mo.park("paralel"),
    "park by an unknown planner": lambda: mo.park("parallel", "nlpp"),
    "park(None)": lambda: mo.park(ANY),
    "follow(None)": lambda: mo.follow(ANY),
    "tune at no speed": lambda: mo.tune(speed_mps=0.0),
    "tune at text": lambda: mo.tune(speed_mps=ANY or "60km/h"),
    "tune into a number": lambda: mo.tune(speed_mps=16.7, out=ANY or 3),
    "tune for an unknown objective": lambda: mo.tune(speed_mps=16.7, objective=ANY or "fastest"),
    "benchmark(a name that is none)": lambda: mo.benchmark("sandwhich"),
    "benchmark by an unknown planner": lambda: mo.benchmark("sandwich", ["mpc", "magic"], scenes=1),
    "benchmark by nobody": lambda: mo.benchmark("sandwich", [], scenes=1),
    "benchmark of half a scene": lambda: mo.benchmark("sandwich", ["aeb"], scenes=ANY or 0.5),
    "replay(a name that is none)": lambda: mo.replay("front_and_rea"),
    "replay(None)": lambda: mo.replay(ANY),
    "replay in an unknown format": lambda: mo.replay("front_and_rear", "mdf"),
    "replay on a road, not a scene": lambda: mo.replay("front_and_rear", road=ANY or mo.Road()),
    "replay with a number as mapping": lambda: mo.replay("front_and_rear", columns=ANY or 3),
    # answers
    "plot(a situation)": lambda: mo.plot(ANY or situation()),
    "plot into a film": lambda: plan().plot("a.mp4"),
    "save as nothing": lambda: plan().save("plan"),
    "save as None": lambda: plan().save(ANY),
    "to_dataframe of an unknown library": lambda: plan().to_dataframe(ANY or "arrow"),
}


def test_there_are_sixty_and_more() -> None:
    assert len(WRONG) >= 60


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_use_is_told_in_one_sentence(name: str) -> None:
    with pytest.raises(mo.McdasError) as told:
        WRONG[name]()
    text = str(told.value)
    assert 10 < len(text) <= 400
    assert "\n" not in text
    assert "object at 0x" not in text
