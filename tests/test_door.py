"""One door: every name at the top level, lazily, and old names that still work."""

from __future__ import annotations

import ast
import inspect
from pathlib import Path

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
