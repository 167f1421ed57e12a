"""Speeds with their units, and what a shell completes."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer import BadParameter
from typer.main import get_command
from typer.testing import CliRunner

from mcdas_opt.cli import completion
from mcdas_opt.cli.app import app
from mcdas_opt.cli.speeds import speed

RUN = CliRunner()


@given(st.floats(0.0, 300.0))
def test_a_speed_is_the_same_in_every_unit(kmh: float) -> None:
    mps = pytest.approx(kmh / 3.6, abs=1e-9)
    for text in (f"{kmh!r}km/h", f"{kmh!r} KM/H", f"{kmh!r}kmh", f"{kmh!r}kph", f"{kmh / 3.6!r}m/s", f"{kmh / 1.609344!r}mph"):
        assert speed(text) == mps
    assert speed(repr(kmh)) == kmh


@pytest.mark.parametrize("text", ["", "fast", "60 km", "-3", "nan", "inf", "1..2", "km/h", "60km/h!"])
def test_what_is_no_speed_is_refused_by_name(text: str) -> None:
    with pytest.raises(BadParameter, match="is not a speed"):
        speed(text)


def test_a_number_that_looks_like_kilometres_an_hour_is_asked_about(capsys: pytest.CaptureFixture[str]) -> None:
    assert speed("40") == 40.0
    assert "write 40km/h" in capsys.readouterr().err
    assert speed("16.7") == 16.7
    assert speed("144km/h") == pytest.approx(40.0)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("unit", ["m/s", "mps", "km/h", "kmh", "kph", "mph"])
def test_the_help_names_every_unit(unit: str) -> None:
    assert speed(f"1{unit}") > 0.0
    asked = [one for one in get_command(app).commands["tune"].params if one.opts[0].endswith(("speed", "speed-bounds"))]
    assert len(asked) == 4
    assert all(re.search(rf"\b{unit}\b", one.help) for one in asked)


def test_tune_takes_them_everywhere() -> None:
    plain = RUN.invoke(app, ["tune", "--speed", "20", "--front-gap", "30", "--front-speed", "15", "--json"])
    units = RUN.invoke(app, ["tune", "--speed", "72km/h", "--front-gap", "30", "--front-speed", "54km/h", "--json"])
    assert json.loads(plain.stdout)["value"] == pytest.approx(json.loads(units.stdout)["value"], rel=1e-9)
    bounded = RUN.invoke(app, ["tune", "--speed-bounds", "50km/h", "15", "--objective", "jerk", "--json"])
    assert 50 / 3.6 - 1e-6 <= json.loads(bounded.stdout)["speed_mps"] <= 15.0 + 1e-6


def test_every_option_that_is_a_speed_takes_its_unit() -> None:
    group = get_command(app)
    options = {
        f"{name} {option.opts[0]}": option
        for name, command in group.commands.items()
        for option in command.params
        if "m/s]" in (getattr(option, "help", None) or "")
    }
    assert len(options) >= 6
    assert [name for name, option in options.items() if "km/h" not in option.help] == []


def test_a_shell_is_offered_names_and_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sandwich-mine.toml").touch()
    (tmp_path / "sandwich.txt").touch()
    assert completion.scenes("sandw")[0] == "sandwich-60-40"
    assert completion.scenes("sandw")[-1] == "sandwich-mine.toml"
    assert completion.planner_lists("mpc,closed-form-c") == ["mpc,closed-form-corrected"]
    assert "euro-ncap-aeb" in completion.suites("")
    assert completion.vehicles("sed") == ["sedan"]
    assert "parallel" in completion.cases("par")
    assert completion.scenes("[") == []


def test_bash_completes_a_scene() -> None:
    asked = {"_MCDAS_OPT_COMPLETE": "complete_bash", "COMP_WORDS": "mcdas-opt plan curv", "COMP_CWORD": "2"}
    command = [sys.executable, "-c", "import sys; sys.argv[0] = 'mcdas-opt'; from mcdas_opt.cli.app import app; app(prog_name='mcdas-opt')"]
    done = subprocess.run(command, env={**os.environ, **asked}, capture_output=True, text=True, check=False)
    assert done.stdout.split() == ["curved-road"], done.stderr
