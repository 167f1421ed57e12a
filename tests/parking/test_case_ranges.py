"""A case that is none is refused in one sentence, and what would take for ever is not begun."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mcdas_opt as mo
from mcdas_opt.domain.parking import ParkingLimits
from mcdas_opt.parking.park import PLANNERS
from tests.cli.command_line import run

CASE: dict[str, Any] = {"start": [6.0, 3.0, 0.0], "goal": [0.0, 0.0, 0.0]}


@pytest.mark.parametrize(
    ("wrong", "name"),
    [
        ({"start": [0.0, 1e6, 0.0]}, "goal"),
        ({"obstacles": ([(1e300, 0.0), (1e300, 1.0), (2.0, 2.0)],)}, r"obstacles\[0\]"),
        ({"obstacles": ([(0.0, 0.0), (math.nan, 1.0), (2.0, 2.0)],)}, r"obstacles\[0\]"),
        ({"origin_m": (0.0, 1e16)}, r"origin_m\[1\]"),
    ],
)
def test_what_no_case_has_is_refused(wrong: dict[str, Any], name: str) -> None:
    with pytest.raises(mo.ParameterError, match=name):
        mo.ParkingCase(**{**CASE, **wrong})


def test_a_file_that_says_so_is_named(tmp_path: Path) -> None:
    file = tmp_path / "far.csv"
    file.write_text("0,0,0,5000,0,0,0\n")
    with pytest.raises(mo.InputError, match=r"far\.csv: goal = 5000\.0.*must lie within 1000 m of the start"):
        mo.load_parking_case(file)


@pytest.mark.parametrize("planner", [planner for planner in PLANNERS if planner != "closed-form"])
def test_a_drive_of_days_is_refused(planner: str) -> None:
    """At a micrometre a second; the paper's own form drives at the speed that stands there."""
    case = mo.ParkingCase(**CASE, limits=ParkingLimits(reverse_mps=1e-6, forward_mps=1e-6))
    with pytest.raises(mo.ParameterError, match="must last no longer than 600 s"):
        mo.park(case, planner)


@pytest.mark.parametrize("aside_m", [50.0, 400.0, 900.0])
def test_a_sigmoid_that_reaches_as_far_as_no_car_steers_is_refused(aside_m: float) -> None:
    """The search for it ran away, until the machine had no memory left."""
    case = mo.ParkingCase(start=[6.0, 3.0, 0.0], goal=[0.0, aside_m, 0.0])
    with pytest.raises(mo.ParameterError, match="farther to the side than one sigmoid"):
        mo.park(case, "closed-form-corrected")


@pytest.mark.parametrize(
    ("said", "planner", "key"),
    [
        ("[slot]\nlength_m = 999.0\n[limits]\nforward_mps = 0.05\nreverse_mps = 0.05\n", "two-arc", r"limits = \d+.*: the drive must last"),
        ("[slot]\nlength_m = 6.0\nstreet_m = 900.0\n[start]\ny_m = 100.0\n", "closed-form-corrected", r"goal = 101\.05.*: is farther"),
    ],
    ids=["too long", "too far aside"],
)
def test_a_file_whose_case_nobody_drives_is_named(
    said: str, planner: str, key: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "slot.toml"
    file.write_text(said)
    with pytest.raises(mo.InputError, match=rf"slot\.toml: {key}"):
        mo.park(file, planner)
    code, _, told = run(monkeypatch, capsys, "park", str(file), "--planner", planner)
    assert code == 2
    assert re.search(rf"slot\.toml: {key}", told)
    with pytest.raises(mo.ParameterError, match=r"^planner = 'nobody': is unknown"):
        mo.park(file, "nobody")


def test_answers_far_from_the_origin_are_those_at_it() -> None:
    here, there = (mo.park(mo.ParkingCase(**CASE, origin_m=origin), "search") for origin in ((0.0, 0.0), (5e5, 5.4e6)))
    assert here.trajectory is not None
    assert there.trajectory is not None
    assert np.array_equal(there.trajectory.speed_mps, here.trajectory.speed_mps)
    assert np.allclose(there.trajectory.x_m - 5e5, here.trajectory.x_m, atol=1e-8)
