"""One door: every name at the top level, lazily, and old names that still work."""

from __future__ import annotations

import ast
import builtins
import dataclasses
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest

import mcdas_opt as mo
from mcdas_opt.planning.method import PlannerName, known_methods

SOURCE = Path(mo.__file__)


def test_the_table_of_contents_is_what_a_type_checker_sees() -> None:
    tree = ast.parse(SOURCE.read_text("utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    typed = {name.name: node.module for node in block.body if isinstance(node, ast.ImportFrom) for name in node.names}
    assert typed == mo._HOME
    assert dir(mo) == sorted([*typed, "__version__"])


@pytest.mark.parametrize("name", [name for name in mo.__all__ if name != "__version__"])
def test_every_name_says_what_it_is(name: str) -> None:
    found = getattr(mo, name)
    assert found.__name__ == name
    assert inspect.getdoc(found)


class _Names(dict[str, object]):
    """The names of a module, and `object` for those that it imports for type checkers alone."""

    def __missing__(self, name: str) -> object:
        return getattr(mo, name, None) if name in dir(mo) else getattr(builtins, name, object)


def _kinds(hint: object) -> Iterator[str]:
    if isinstance(hint, type) and hint.__module__.startswith("mcdas_opt"):
        yield hint.__name__
    for part in get_args(hint):
        yield from _kinds(part)


FUNCTIONS = [name for name in mo.__all__ if inspect.isfunction(getattr(mo, name))]
RECORDS = ["HostState", "Road", "Scan", "Settings", "Situation", "Track", "Vehicle", "Plan", "Refusal", "Escapes", "Verdict", "Violation"]


@pytest.mark.parametrize("name", [*FUNCTIONS, *RECORDS])
def test_what_a_public_name_takes_and_gives_is_public(name: str) -> None:
    found = getattr(mo, name)
    hints = dict(found.__annotations__)
    if dataclasses.is_dataclass(found):
        hints = {field.name: hints[field.name] for field in dataclasses.fields(found) if field.init and field.name in hints}
    names = _Names(vars(sys.modules[found.__module__]))
    hidden = {kind for hint in hints.values() for kind in _kinds(eval(hint, {}, names))} - set(dir(mo))
    assert not hidden


def test_the_page_of_the_python_surface_has_every_name() -> None:
    page = (Path(__file__).parents[1] / "docs" / "api.md").read_text("utf-8")
    documented = set(re.findall(r":: mcdas_opt\.(?:[a-z_]+\.)*(\w+)", page)) | set(re.findall(r"(\w+Error)\b", page))
    assert set(mo.__all__) - {"__version__"} <= documented


def test_importing_the_package_loads_none_of_them() -> None:
    asked = "import sys, mcdas_opt; print(sorted(name for name in sys.modules if name.startswith(('mcdas_opt.', 'numpy'))))"
    assert subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True).stdout.strip() == "[]"


def test_a_wrong_name_is_told_the_nearest() -> None:
    with pytest.raises(AttributeError, match="did you mean 'simulate'"):
        assert mo.simulat


def test_the_names_of_planners_that_editors_complete_are_the_registered_ones() -> None:
    assert set(PlannerName.__args__) <= set(known_methods())


def test_the_old_name_of_an_argument_works_and_says_so() -> None:
    situation = mo.load_situation("benign-following")
    with pytest.warns(DeprecationWarning, match="planner"):
        old = mo.plan(situation, method="closed-form-corrected")
    assert old.planner == mo.plan(situation, planner="closed-form-corrected").planner == "closed-form-corrected"
    with pytest.raises(mo.ParameterError, match="old name"):
        mo.plan(situation, planner="mpc", method="aeb")


def test_a_step_without_memory_is_a_new_planners_step() -> None:
    radar = mo.RadarDetection(range_m=30.0, azimuth_rad=0.0, range_rate_mps=-5.0)
    scans = [mo.Scan(sensor="front", sector=mo.Sector.FRONT, t_s=0.1 * k, mounting=mo.Mounting(x_m=2.25), radar=(radar,)) for k in range(5)]
    host, road = mo.HostState(speed_mps=15.0), mo.Road(lanes_left=1)
    plan = mo.step(scans, host, 0.4, road=road, planner="closed-form-corrected")
    planner = mo.Planner(method="closed-form-corrected", road=road)
    assert plan.trajectory.table.tobytes() == planner.step(scans, host, 0.4).trajectory.table.tobytes()
    assert planner.situation is not None
    assert planner.situation.tracks
    assert not planner.situation.coverage.rear


def test_a_saved_situation_is_loaded_by_the_door(tmp_path: Path) -> None:
    situation = mo.load_situation("sandwich-60-40")
    file = tmp_path / "saved.json"
    file.write_text(situation.to_json())
    assert mo.load_situation(file) == situation
