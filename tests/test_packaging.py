"""The conda recipe and the Dockerfile ask for what pyproject.toml asks for."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).resolve().parent.parent
PACKAGING = ROOT / ".ci" / "packaging"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
OTHER_NAMES = {"matplotlib": "matplotlib-base"}  # conda's

pytestmark = pytest.mark.repository


def listed(section: str) -> dict[str, SpecifierSet]:
    """Name and bounds of every requirement below a heading of the recipe."""
    recipe = (PACKAGING / "recipe.yaml").read_text("utf-8")
    found = re.search(rf"^  {section}:\n((?:    - .*\n)+)", recipe, flags=re.MULTILINE)
    assert found is not None
    parts = [line.strip(" -").split(maxsplit=1) for line in found[1].splitlines()]
    return {part[0]: SpecifierSet(part[1] if len(part) > 1 else "") for part in parts}


def test_the_recipe_runs_with_what_the_project_declares() -> None:
    asked = [Requirement(text) for text in PROJECT["dependencies"]]
    wanted = {OTHER_NAMES.get(one.name, one.name): one.specifier for one in asked}
    assert listed("run") == {"python": SpecifierSet(PROJECT["requires-python"]), **wanted}
    assert listed("host")["python"] == SpecifierSet(PROJECT["requires-python"])


def test_the_recipe_builds_the_projects_version_and_program() -> None:
    recipe = (PACKAGING / "recipe.yaml").read_text("utf-8")
    assert f'version: "{PROJECT["version"]}"' in recipe
    assert f"- mcdas-opt = {PROJECT['scripts']['mcdas-opt']}\n" in recipe
    assert PROJECT["urls"]["Repository"] in recipe
    assert PROJECT["urls"]["Repository"] in (ROOT / "README.md").read_text("utf-8")


def test_the_image_copies_what_the_wheel_is_made_of() -> None:
    text = (PACKAGING / "Dockerfile").read_text("utf-8")
    versions = re.findall(r"^FROM python:([\d.]+)-slim", text, flags=re.MULTILINE)
    assert len(versions) == 2
    assert all(version in SpecifierSet(PROJECT["requires-python"]) for version in versions)
    copied = [part for line in re.findall(r"^COPY (?!--from)(.*) \S+$", text, flags=re.MULTILINE) for part in line.split()]
    assert {"mcdas_opt", "models", "benchmarks/suites", "pyproject.toml", PROJECT["readme"], *PROJECT["license-files"]} == set(copied)
    assert all((ROOT / name).exists() for name in copied)
    extras = re.search(r"^ARG EXTRAS=(.*)$", text, flags=re.MULTILINE)
    assert extras is not None
    assert set(extras[1].split(",")) <= set(PROJECT["optional-dependencies"])
