"""Files that are made to hurt: refused before they are parsed, by our own error, whoever reads them."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.catalogue.designs import load_parameters, load_schedule
from mcdas_opt.catalogue.motion import load_motion
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.catalogue.trajectories import COLUMNS, load_trajectory
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.parsing import DEEPEST, DIGITS, KEY_PARTS, LARGEST_JSON, LARGEST_TOML, parsed_json, parsed_toml
from mcdas_opt.domain.situation import Situation
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.evaluation.families import load_family
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.parking.case_file import load_parking_case
from mcdas_opt.parking.trajectory_file import load_parking_trajectory
from mcdas_opt.simulation.first_situation import situation_of

DOTS = "a." * 50_000 + "b = 1\n"  # 100 kB that cost `tomllib` gigabytes
HOSTILE_TOML = {
    "dotted key": (DOTS, f"line 1: a dotted key must have at most {KEY_PARTS} parts"),
    "dotted and quoted": ('"a" . ' * 50_000 + "b = 1\n", "line 1: a dotted key"),
    "table's name": (f"[{'a.' * 50_000}b]\n", "line 1: a dotted key"),
    "inline table": ("x = {" + "a." * 50_000 + "b = 1}\n", "line 1: a dotted key"),
    "behind a string of odd quotes": ('x = """a"""""\n' + DOTS, "line 2: a dotted key"),
    "behind a literal of odd quotes": ("x = '''a''''\n" + DOTS, "line 2: a dotted key"),
    "behind a quote in a comment": ("# it's\n" + DOTS, "line 2: a dotted key"),
    "lists": ("x = " + "[" * 100_000 + "]" * 100_000, f"more than {DEEPEST} deep"),
    "tables": ("x = " + "{a = " * 100_000 + "1" + "}" * 100_000, f"more than {DEEPEST} deep"),
    "400 digits": ("x = " + "9" * 400, f"more than {DIGITS} digits"),
    "5000 digits": ("x = " + "9" * 5000, f"more than {DIGITS} digits"),
    "20 digits": ("x = 99999999999999999999", "mine.toml: x: is too large: an integer of 67 bits, of at most 64"),
    "size": (" " * (LARGEST_TOML + 1), f"must be at most {LARGEST_TOML} characters"),
}
HOSTILE_JSON = {
    "lists": ("[" * 100_000 + "]" * 100_000, f"more than {DEEPEST} deep"),
    "lists that are never closed": ("[" * 100_000, f"more than {DEEPEST} deep"),
    "objects": ('{"a": ' * 100_000 + "1" + "}" * 100_000, f"more than {DEEPEST} deep"),
    "400 digits": ('{"x": ' + "9" * 400 + "}", "mine.json: x: is too large: an integer of 1329 bits"),
    "5000 digits": ('{"x": ' + "9" * 5000 + "}", f"more than {DIGITS} digits"),
    "size": (" " * (LARGEST_JSON + 1), f"must be at most {LARGEST_JSON} characters"),
}
TOML_DOORS: dict[str, Callable[[Path], Any]] = {
    "scene": load_scene,
    "vehicle": lambda path: load_vehicle(str(path)),
    "sensor": lambda path: load_sensor(str(path)),
    "motion": lambda path: load_motion(str(path)),
    "parking case": load_parking_case,
    "design": load_parameters,
    "schedule": load_schedule,
    "family": load_family,
    "suite": expand,
}
JSON_DOORS: dict[str, Callable[[Path], Any]] = {
    "trajectory": load_trajectory,
    "parking trajectory": load_parking_trajectory,
    "situation": lambda path: situation_of(str(path)),
}


def refuses(door: Callable[[Path], Any], path: Path, hostile: tuple[str, str]) -> None:
    """The door names the file and the rule, in few words."""
    text, said = hostile
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        door(path)
    assert str(refused.value).startswith(f"{path}: ")
    assert said in str(refused.value)
    assert len(str(refused.value)) < 400


@pytest.mark.parametrize("kind", HOSTILE_TOML)
@pytest.mark.parametrize("door", TOML_DOORS)
def test_hostile_toml_is_refused_at_every_door(door: str, kind: str, tmp_path: Path) -> None:
    refuses(TOML_DOORS[door], tmp_path / "mine.toml", HOSTILE_TOML[kind])


@pytest.mark.parametrize("kind", HOSTILE_JSON)
@pytest.mark.parametrize("door", JSON_DOORS)
def test_hostile_json_is_refused_at_every_door(door: str, kind: str, tmp_path: Path) -> None:
    refuses(JSON_DOORS[door], tmp_path / "mine.json", HOSTILE_JSON[kind])


def test_a_situation_that_is_no_file_is_limited_too() -> None:
    with pytest.raises(InputError, match=f"more than {DEEPEST} deep"):
        Situation.from_json("[" * 100_000)


def test_the_command_says_one_line_and_exits_with_2(tmp_path: Path) -> None:
    path = tmp_path / "dots.toml"
    path.write_text(DOTS)
    done = subprocess.run([sys.executable, "-m", "mcdas_opt", "plan", str(path)], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.strip().endswith(f"dots.toml: line 1: a dotted key must have at most {KEY_PARTS} parts")
    assert len(done.stderr.strip().splitlines()) == 1


values = st.recursive(
    st.booleans() | st.integers(-(2**63) + 1, 2**63 - 1) | st.floats(allow_nan=False) | st.text(alphabet=st.characters(codec="utf-8")),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(alphabet=st.characters(codec="utf-8")), inner, max_size=4),
    max_leaves=20,
)


@given(st.dictionaries(st.sampled_from(["a", "b-c", "d_1"]), st.floats(allow_nan=False) | st.integers(-5, 5) | st.text(), max_size=3))
def test_toml_within_the_limits_reads_as_it_did(document: dict[str, Any]) -> None:
    text = toml_text({"table": document, "rows": [document, document]})
    assert parsed_toml(text, "x") == tomllib.loads(text)


@given(values)
def test_json_within_the_limits_reads_as_it_did(document: Any) -> None:
    text = json.dumps(document)
    assert parsed_json(text, "x") == json.loads(text)


@pytest.mark.parametrize(
    "text",
    [
        "x = '" + "[" * 500 + "a." * 500 + "'",
        'x = """\n' + "[" * 500 + "\n" + "a." * 500 + '\\""" ""\n"""',
        "# " + "[" * 500 + "a." * 500 + "9" * 500,
        "x = [" + "1.5, " * 5000 + "]",
        "x = " + "[" * DEEPEST + "]" * DEEPEST,
        ".".join("a" * KEY_PARTS) + " = 1",
        "\n".join(f"a.b{k} = 1.25" for k in range(500)),
        f"x = {2**63 - 1}\ny = 1979-05-27T07:32:00.999999-07:00",
    ],
)
def test_what_only_looks_large_is_read(text: str) -> None:
    assert parsed_toml(text, "x") == tomllib.loads(text)


def test_brackets_in_a_json_string_are_text() -> None:
    assert parsed_json(json.dumps({"a": "[{" * 500}), "x") == {"a": "[{" * 500}


def test_every_shipped_file_is_within_the_limits() -> None:
    files = sorted(models_folder().rglob("*.toml"))
    assert len(files) > 20
    for path in files:
        assert parsed_toml(path.read_text("utf-8"), path) == tomllib.loads(path.read_text("utf-8"))


def test_a_cell_that_is_too_large_and_a_file_that_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text(",".join(COLUMNS) + '\n"' + "9" * 200_000 + '"\n')
    with pytest.raises(InputError, match=r"mine\.csv: line \d: is no CSV: field larger"):
        load_trajectory(path)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="cannot be read"):
        load_trajectory(path)


def test_a_long_value_is_cut_off_in_the_message_and_a_huge_integer_named() -> None:
    assert len(str(InputError("file", "key", "x" * 10_000, "must be short"))) < 300
    assert "int too large to be written: must be small" in str(ParameterError("n", 10**5000, "must be small"))
