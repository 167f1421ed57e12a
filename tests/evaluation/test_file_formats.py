"""The reference of every file is what the models check: every key, its unit, and a schema by which every shipped file is valid."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.cli.app import app
from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.families import suites_folder
from mcdas_opt.evaluation.file_formats import MODELS, keys, schema

FOLDERS = {"scene": "scenes", "vehicle": "vehicles", "sensor": "sensors", "motion": "motion", "parking-case": "cases"}
FILES = [(kind, path) for kind, folder in FOLDERS.items() for path in sorted((models_folder() / folder).glob("*.toml"))]


def used(document: dict[str, Any], table: str = "") -> Iterator[tuple[str, str]]:
    for name, value in document.items():
        path = f"{table}.{name}".lstrip(".")
        if isinstance(value, dict):
            yield from used(value, path)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for one in value:
                yield from used(one, path)
        else:
            yield table, name


@pytest.mark.parametrize(("kind", "path"), FILES, ids=lambda value: value.stem if isinstance(value, Path) else value)
def test_every_key_of_a_shipped_file_is_in_the_reference_and_valid(kind: str, path: Path) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    document = tomllib.loads(path.read_text("utf-8"))
    jsonschema.Draft202012Validator(schema(kind)).validate(document)
    known = {(key.table.strip("[]"), key.name) for key in keys(kind)}
    free = {("", "sources")}  # tables with keys of the user's own
    assert {(table, name) for table, name in used(document) if ("", table) not in free} <= known


@pytest.mark.parametrize("kind", ["scene", "vehicle", "sensor", "parking-case", "suite", "family"])
def test_every_key_says_what_it_is(kind: str) -> None:
    silent = [key.name for key in keys(kind) if not key.about and not (kind == "parking-case" and key.table == "[vehicle]")]
    assert silent == []


@pytest.mark.parametrize("kind", sorted(MODELS))
def test_a_word_has_the_words_that_it_may_be(kind: str) -> None:
    assert [key.name for key in keys(kind) if key.kind == "word" and not key.allowed] == []


@pytest.mark.parametrize("kind", sorted(MODELS))
def test_a_quantity_has_its_unit_in_the_schema(kind: str) -> None:
    found = schema(kind)
    for part in (found, *found.get("$defs", {}).values()):
        for name, entry in part.get("properties", {}).items():
            if name.endswith("_mps"):
                assert entry["description"].endswith("[m/s]"), name


def test_ranges_and_defaults_are_the_models() -> None:
    friction = next(key for key in keys("scene") if (key.table, key.name) == ("[road]", "friction"))
    assert (friction.default, friction.allowed, friction.unit) == ("0.9", "> 0 and <= 1.5", "")
    speed = next(key for key in keys("scene") if (key.table, key.name) == ("[[neighbour]]", "speed_mps"))
    assert (speed.unit, speed.allowed) == ("m/s", ">= 0 and <= 10000")
    assert next(key for key in keys("scene") if key.name == "request").allowed == "drive, park"
    assert next(key for key in keys("vehicle") if key.name == "width_m").default == "required"
    assert next(key for key in keys("scene") if key.name == "start_s").table == "[[neighbour.motion]]"


def test_the_command_prints_a_table_or_the_schema() -> None:
    assert "friction" in CliRunner().invoke(app, ["schema", "scene"]).stdout
    assert json.loads(CliRunner().invoke(app, ["schema", "suite", "--json"]).stdout) == schema("suite")
    wrong = CliRunner().invoke(app, ["schema", "scenery"])
    assert isinstance(wrong.exception, ParameterError)
    assert "did you mean 'scene'" in str(wrong.exception)


def test_every_shipped_suite_is_valid() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    for path in suites_folder().glob("*.toml"):
        document = tomllib.loads(path.read_text("utf-8"))
        several = any(key in document for key in ("family", "manoeuvre", "recorded", "part"))
        jsonschema.Draft202012Validator(schema("suite" if several else "family")).validate(document)
