"""Every extra that is declared is one that the tests run with: `dev` brings it, or CI installs it besides and says so by EVERY_EXTRA=1."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from mcdas_opt.interop.reactive_planner import PACKAGES

ROOT = Path(__file__).resolve().parent.parent
DECLARED = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
EXTRAS = {name: tuple(Requirement(text) for text in required) for name, required in DECLARED["project"]["optional-dependencies"].items()}
CI = (ROOT / ".ci" / "run").read_text("utf-8") if (ROOT / ".ci" / "run").is_file() else ""
BESIDES = {"commonroad-planner"}  # what `dev` leaves out, for its licence


def within(extra: str) -> set[str]:
    """The extra and those of ours that it brings."""
    own = [part for requirement in EXTRAS[extra] if requirement.name == "mcdas-opt" for part in requirement.extras]
    return {extra}.union(*(within(part) for part in own))


def brought(extra: str) -> Iterator[Requirement]:
    """What the extra brings from elsewhere."""
    for name in sorted(within(extra)):
        yield from (requirement for requirement in EXTRAS[name] if requirement.name != "mcdas-opt")


def test_dev_brings_every_extra_but_those_that_ci_installs_besides() -> None:
    assert within("dev") == set(EXTRAS) - BESIDES
    assert {name for name in EXTRAS if f"'.[{name}]'" in CI} == (BESIDES if CI else set())


@pytest.mark.parametrize("extra", sorted(EXTRAS if os.environ.get("EVERY_EXTRA") else set(EXTRAS) - BESIDES))
def test_what_an_extra_declares_is_installed(extra: str) -> None:
    """Each with a version that its declaration allows."""
    found = {str(requirement): version(requirement.name) for requirement in brought(extra)}
    assert found
    assert [text for text, installed in found.items() if installed not in Requirement(text).specifier] == []


def test_what_users_install_has_bounds_on_both_sides() -> None:
    """Or one version; what `dev` adds of tools is for whoever changes the project."""
    needed = [Requirement(text) for text in DECLARED["project"]["dependencies"] + DECLARED["build-system"]["requires"]]
    needed += [requirement for name in set(EXTRAS) - {"dev"} for requirement in EXTRAS[name] if requirement.name != "mcdas-opt"]
    bounds = {str(requirement): {one.operator for one in requirement.specifier} for requirement in needed}
    assert [text for text, operators in bounds.items() if operators not in ({">=", "<"}, {"=="})] == []


def test_the_reactive_planners_own_packages_are_pinned_once_and_told_everywhere() -> None:
    assert f"pip install --no-deps {' '.join(PACKAGES)}\n" in (ROOT / "docs" / "doors" / "commonroad.md").read_text("utf-8")
    assert all(re.fullmatch(r"commonroad-[a-z-]+==[0-9.]+", package) for package in PACKAGES)
    if os.environ.get("EVERY_EXTRA"):
        assert [f"{name}=={version(name)}" for name in (package.split("==")[0] for package in PACKAGES)] == list(PACKAGES)
