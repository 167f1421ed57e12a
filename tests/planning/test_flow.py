"""The flow of one plan: a situation goes down through the layers, and few calls hand it up again."""

from __future__ import annotations

import ast
import itertools
import sys
import tomllib
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

import mcdas_opt
from benchmarks.random_traffic import episode
from mcdas_opt import Planner
from mcdas_opt.domain.situation import Situation
from mcdas_opt.planning.cycle import Cycle

PACKAGE = Path(mcdas_opt.__file__).parent
CONTRACTS = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
LAYERS = next(each["layers"] for each in CONTRACTS if each["name"] == "the layers of the house")
FLOOR = {name.split(".")[1]: -floor for floor, layer in enumerate(LAYERS) for name in layer.replace(" ", "").split("|")}
MOST_CLIMBS, MOST_ATTRIBUTES = 5, 6


def flow(planner: Planner, situation: Situation) -> list[tuple[int, str]]:
    """(floor, function) of everything in the package that is handed a situation or a cycle while a plan is made, once each, in the order in
    which it is first entered."""
    found: dict[str, int] = {}

    def enter(frame: FrameType, event: str, _: Any) -> None:
        code = frame.f_code
        path = Path(code.co_filename)
        if event != "call" or PACKAGE not in path.parents or path.parent == PACKAGE:
            return
        handed = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
        if any(isinstance(frame.f_locals.get(name), (Situation, Cycle)) for name in handed if name not in ("self", "cls")):
            file = path.relative_to(PACKAGE)
            found.setdefault(f"{file}:{code.co_qualname}", FLOOR[file.parts[0]])

    sys.setprofile(enter)
    try:
        planner.plan(situation)
    finally:
        sys.setprofile(None)
    return [(floor, name) for name, floor in found.items()]


def attributes(kind: ast.ClassDef) -> set[str]:
    """What a class's own methods set on `self`."""
    targets = (node for node in ast.walk(kind) if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store))
    return {node.attr for node in targets if isinstance(node.value, ast.Name) and node.value.id == "self"}


def test_no_class_of_planning_keeps_more_than_six_things() -> None:
    trees = [ast.parse(path.read_text("utf-8")) for path in (PACKAGE / "planning").rglob("*.py")]
    kept = {node.name: attributes(node) for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
    assert {"Planner", "MpcMethod", "Sensing"} <= kept.keys()
    assert {name: names for name, names in kept.items() if len(names) > MOST_ATTRIBUTES} == {}


@pytest.mark.parametrize(
    ("family", "number"), [("sandwich", 3), ("dense", 2), ("curved", 9), ("quiet", 1), ("contradictory", 20), ("slippery", 24)]
)
def test_a_situation_is_handed_up_at_most_five_times(family: str, number: int) -> None:
    one = episode(family, number)
    entered = flow(Planner(vehicle=one.vehicle), one.first)
    assert entered[0][1] == "planning/planner.py:Planner.plan"
    assert len(entered) > 40  # the stages were reached
    climbs = [f"{before} -> {after}" for (low, before), (high, after) in itertools.pairwise(entered) if high > low]
    assert len(climbs) <= MOST_CLIMBS, "\n".join(climbs)
