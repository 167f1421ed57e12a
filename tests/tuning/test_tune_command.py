"""The command, its files, and planning with them."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mcdas_opt import tune
from mcdas_opt.catalogue.designs import load_parameters
from mcdas_opt.cli.app import app
from mcdas_opt.cli.tune import named_as_written
from mcdas_opt.errors import InputError, McdasError, ParameterError
from mcdas_opt.planning.parameter_files import planner_with
from mcdas_opt.planning.planner import Planner
from mcdas_opt.plotting import style
from mcdas_opt.simulation.first_situation import situation_of
from tests.plotting.pixels import coloured, pixels

RUN = CliRunner()


def test_json_holds_what_the_contract_says() -> None:
    answer = RUN.invoke(app, ["tune", "--speed", "20", "--lateral-acceleration", "3", "--json"])
    assert answer.exit_code == 0
    document = json.loads(answer.stdout)
    keys = {"a_per_m", "b", "y_max_m", "length_m", "objective", "value", "constraints", "method", "evaluations", "path", "schema_version"}
    assert keys <= set(document)
    assert all({"name", "value", "limit", "unit", "multiplier"} <= set(row) for row in document["constraints"])
    x, y = document["path"]["x_m"], document["path"]["y_m"]
    assert len(x) == len(y)
    assert x[1] == pytest.approx(0.1)
    assert abs(y[-1] - 3.7) <= 0.1
    inside = [abs(value - 3.7) <= 0.1 for value in y]
    first = len(inside) - inside[::-1].index(False)
    assert x[first] == pytest.approx(document["length_m"], abs=0.11)


def test_a_design_is_planned_with(tmp_path: Path) -> None:
    out = tmp_path / "gentle.toml"
    answer = RUN.invoke(app, ["tune", "--speed", "11.1", "--lateral-acceleration", "1.5", "--out", str(out)])
    assert answer.exit_code == 0
    shown = pixels(out.with_suffix(".png"))
    assert coloured(shown, style.ASPHALT).mean() > 0.1
    for colour in (style.CORRECTED, style.LITERAL, style.VERMILION):  # ours, the paper's dashed, the limits dotted
        assert coloured(shown, colour, 70).sum() > 200
    kept = tomllib.loads(out.read_text(encoding="utf-8"))
    found = tune(speed_mps=11.1, lateral_acceleration_mps2=1.5)
    assert kept["sigmoid"]["a_per_m"] == found.a_per_m
    situation, vehicle = situation_of("sandwich-60-40")
    sigmoid, _ = load_parameters(out)
    assert sigmoid is not None
    assert sigmoid.given == found.sigmoid
    for planner in ("closed-form-corrected", "mpc"):
        plain, tuned = Planner(vehicle, planner).plan(situation), planner_with(out, vehicle, planner).plan(situation)
        assert tuned.to_dict()["trajectory"] != plain.to_dict()["trajectory"]
    document = RUN.invoke(app, ["plan", "sandwich-60-40", "--planner", "closed-form-corrected", "--params", str(out), "--json"])
    assert document.exit_code == 0


def test_the_same_request_writes_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "two"):
        tune(out=tmp_path / f"{name}.png")
    assert (tmp_path / "one.toml").read_bytes() == (tmp_path / "two.toml").read_bytes()
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[sigmoid]\na_per_m = 0.2\nb = 50.0\ny_max_m = 3.7\n", "a_per_m = 0.2: must be less than 0"),
        ("[sigmoid]\na_per_m = -0.2\nb = 0.5\ny_max_m = 3.7\n", "b = 0.5: must be greater than 1"),
        ("[sigmoid]\na_per_m = -0.2\nb = 50.0\n", "y_max_m: missing key"),
        ("[sigmoid]\na_per_m = -0.2\nb = 50.0\ny_max = 3.7\ny_max_m = 3.7\n", "did you mean 'y_max_m'"),
        ("[sigmoid]\na_per_m = -0.2\nb = nan\ny_max_m = 3.7\n", "b"),
        ("[sigmoid\n", "is not TOML"),
    ],
)
def test_bad_files_are_told_key_value_and_rule(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as refused:
        load_parameters(file)
    assert words in str(refused.value)
    assert "bad.toml" in str(refused.value)


def test_the_paper_takes_no_parameters(tmp_path: Path) -> None:
    tune(out=tmp_path / "design.toml")
    _, vehicle = situation_of("sandwich-60-40")
    with pytest.raises(McdasError, match="takes no parameters"):
        planner_with(tmp_path / "design.toml", vehicle, "closed-form")
    with pytest.raises(McdasError, match="from models/tuned"):
        planner_with(tmp_path / "design.toml", vehicle, "closed-form-tuned")


@pytest.mark.parametrize("planner", ["acc", "aeb", "commonroad-reactive", "idm-mobil", "un-r157"])
@pytest.mark.parametrize("command", ["plan", "simulate"])
def test_who_steers_by_no_sigmoid_takes_none(tmp_path: Path, command: str, planner: str) -> None:
    tune(out=tmp_path / "design.toml")
    with pytest.raises(InputError, match=f"design.toml: sigmoid: is read by mpc and closed-form-corrected: '{planner}' does not take it"):
        RUN.invoke(
            app, [command, "sandwich-60-40", "--planner", planner, "--params", str(tmp_path / "design.toml")], catch_exceptions=False
        )


def test_nothing_is_written_where_nothing_is_found(tmp_path: Path) -> None:
    with pytest.raises(McdasError, match="the shortest is"):
        tune(length_max_m=5.0, out=tmp_path / "none.toml")
    with pytest.raises(InputError, match=r"must end in \.toml or \.png"):
        tune(out=tmp_path / "none.csv")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--scenes", "sandwich", "--storage", "s.db", "--train", "0"], "--train = 0: must be greater than 0"),
        (["--scenes", "sandwich", "--storage", "s.db", "--held-out", "0"], "--held-out = 0: must be greater than 0"),
        (["--scenes", "sandwch"], "sandwch: no such file, and no shipped suite"),
        (["--scenes", "sandwich"], "--scenes = 'sandwich': a study needs a file to live in: --storage FILE"),
        (["--speed", "27.8", "--length", "12"], "--length = 12.0 m: no sigmoid settles within 12 m"),
        (["--heading-jump", "0"], "--heading-jump = 0.0 rad: must be greater than 0"),
        (["--a-bounds", "0.1", "0.2"], "--a-bounds = (0.1, 0.2) 1/m: a is less than 0"),
        (["--front-gap", "5", "--front-speed", "30"], "--front-speed = 30.0 m/s: must lie in"),
        (
            ["--scenes", "sandwich", "--storage", "s.db", "--objective", "nonsense", "--side", "up", "--vehicle", "nobody"],
            "--objective, --side, --vehicle: not read by a study in traffic",
        ),
        (["--scenes", "sandwich", "--storage", "s.db", "--friction", "0.9"], "--friction: not read by a study"),
        (
            ["--scenes", "sandwich", "--a-bounds", "-3", "-2", "--speed-bounds", "9", "11"],
            "--a-bounds, --speed-bounds: not read by a study",
        ),
        (
            ["--trials", "5", "--storage", "x.db", "--search", "zzz"],
            "--trials, --storage, --search: not read by a design, only by a study in traffic: --scenes",
        ),
        (["--workers", "1"], "--workers: not read by a design"),
        (["--side", "up"], "--side = 'up': must be left or right"),
    ],
)
def test_a_refusal_names_the_option_that_was_written(arguments: list[str], words: str) -> None:
    answer = RUN.invoke(app, ["tune", *arguments])
    assert isinstance(answer.exception, McdasError)
    assert words in str(answer.exception)


@pytest.mark.parametrize("name", ["speed_mps", "offset_m", "length_max_m", "b_bounds", "y_max_bounds_m", "settling error", "lateral jerk"])
def test_every_name_of_a_design_leads_to_an_option(name: str) -> None:
    with pytest.raises(ParameterError, match=r"^--[a-z-]+ = 1\.0 m: rule$"), named_as_written():
        raise ParameterError(name, 1.0, "rule", "m")


def test_a_limit_that_follows_from_an_option_keeps_its_own_name() -> None:
    with pytest.raises(ParameterError, match=r"^friction = 8\.5 m/s"), named_as_written():
        raise ParameterError("friction", 8.5, "rule", "m/s^2")
