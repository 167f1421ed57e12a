"""Parts of installed packages: what cannot be had of them is one sentence that names the part, and comes before anybody drives."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.errors import InputError, ParameterError, PlannerFaultError
from mcdas_opt.evaluation.benchmark import check_planners
from mcdas_opt.interop.recordings.recording import format_of
from mcdas_opt.planning.method import METHODS
from mcdas_opt.simulation.loop import simulate

_MODULE = """
from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.errors import InputError

def backwards(path):
    return Scene.model_validate({"host": {"speed_mps": -3.0}, "road": {"lanes_left": 0}})

def misspelt(path):
    return Scene.model_validate({"host": {"speed_mps": 3.0, "sped_mps": 3.0}})

def scene_of(path):
    return load_scene("benign-following")

def nothing(path):
    return None

def raises(path):
    return 1 / 0

def refuses(path):
    raise InputError(path, "line 3", "x", "must be a number")

class BadSignature:
    def __init__(self):
        pass

class BadStart:
    def __init__(self, vehicle, settings):
        raise RuntimeError("no licence")

class NoPlan:
    def __init__(self, vehicle, settings):
        self.vehicle = vehicle

class BadPlan(NoPlan):
    def plan(self, situation):
        return None

class Alone(NoPlan):
    has_ladder = False

    def plan(self, situation, previous):
        return 1 / 0

number = 3
"""
_POINTS = """
[mcdas_opt.methods]
no-class = their_parts:Nope
no-module = their_missing_parts:Nope
raises-on-import = their_broken_parts:Nope
bad-signature = their_parts:BadSignature
bad-start = their_parts:BadStart
no-plan = their_parts:NoPlan
bad-plan = their_parts:BadPlan
no-class-at-all = their_parts:number
alone = their_parts:Alone
[mcdas_opt.scenes]
osc = their_parts:scene_of
none = their_parts:nothing
boom = their_parts:raises
back = their_parts:backwards
misspelt = their_parts:misspelt
strict = their_parts:refuses
"""


@pytest.fixture(autouse=True)
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    facts = tmp_path / "their_parts-0.1.dist-info"
    facts.mkdir()
    (tmp_path / "their_parts.py").write_text(_MODULE, "utf-8")
    (tmp_path / "their_broken_parts.py").write_text("1 / 0\n", "utf-8")
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: their-parts\nVersion: 0.1\n", "utf-8")
    (facts / "entry_points.txt").write_text(_POINTS, "utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("no-class", "is registered as 'their_parts:Nope', which cannot be imported: module 'their_parts' has no attribute 'Nope'"),
        ("no-module", "is registered as 'their_missing_parts:Nope', which cannot be imported: No module named 'their_missing_parts'"),
        ("raises-on-import", "which cannot be imported: it raised ZeroDivisionError: division by zero"),
        ("their_broken_parts:Nope", "of a module that can be imported: it raised ZeroDivisionError: division by zero"),
    ],
)
def test_a_part_that_cannot_be_imported_is_refused_by_name_before_anybody_drives(name: str, said: str) -> None:
    assert name in METHODS.known() or ":" in name
    for asked in (lambda: METHODS.load(name), lambda: check_planners(["mpc", name])):
        with pytest.raises(ParameterError) as told:
            asked()
        assert said in str(told.value)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("bad-signature", "planner = 'bad-signature': raised TypeError when called with vehicle and settings: "),
        ("bad-start", "planner = 'bad-start': raised RuntimeError when called with vehicle and settings: no licence"),
        ("no-plan", "planner = 'no-plan': gives a NoPlan, which has no method plan(situation, previous)"),
        ("bad-plan", "planner = 'bad-plan': gives a BadPlan, which has no method plan(situation, previous)"),
        ("no-class-at-all", "planner = 'no-class-at-all': is registered as 3, must be a class"),
        ("their_parts:BadStart", "planner = 'their_parts:BadStart': raised RuntimeError"),
    ],
)
def test_a_method_that_cannot_be_built_is_refused_by_name_before_anybody_drives(name: str, said: str) -> None:
    for asked in (lambda: simulate("benign-following", planner=name), lambda: check_planners(["closed-form", name])):
        with pytest.raises(ParameterError) as told:
            asked()
        assert str(told.value).startswith(said)


def test_what_a_method_without_a_ladder_raises_is_one_sentence() -> None:
    with pytest.raises(PlannerFaultError) as told:
        simulate("benign-following", planner="alone")
    assert str(told.value) == "planner 'alone' at t = 0.00 s: raised ZeroDivisionError: division by zero"


def test_a_file_of_a_registered_format_is_a_scene(installed: Path) -> None:
    file = installed / "drive.osc"
    file.touch()
    assert isinstance(load_scene(file), Scene)


@pytest.mark.parametrize(
    ("ending", "said"),
    [
        ("none", "the scene format 'none' gave NoneType, which must be a Scene"),
        ("boom", "the scene format 'boom' raised ZeroDivisionError: division by zero"),
        ("back", "drive.back: the scene format 'back' gave host.speed_mps = -3.0: input should be greater than or equal to 0"),
        ("misspelt", "drive.misspelt: the scene format 'misspelt' gave host.sped_mps: unknown key; did you mean 'speed_mps'?"),
        ("strict", "line 3 = 'x': must be a number"),
    ],
)
def test_a_format_that_raises_or_gives_no_scene_is_named_with_the_file(ending: str, said: str, installed: Path) -> None:
    file = installed / f"drive.{ending}"
    file.touch()
    with pytest.raises(InputError) as told:
        load_scene(file)
    assert str(file) in str(told.value)
    assert said in str(told.value)
    assert "pydantic" not in str(told.value)


def test_a_log_of_ours_is_known_without_asking_the_installed_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which takes as long as to read a short log."""
    asked: list[str] = []
    monkeypatch.setattr("mcdas_opt.domain.registry.entry_points", lambda group: asked.append(group) or ())
    assert format_of(Path("drive.log")) == "esr-candump"
    assert not asked
    with pytest.raises(InputError, match=r"drive\.xyz: is of no known format by its name; say --format, one of esr-candump, "):
        format_of(Path("drive.xyz"))
    assert asked == ["mcdas_opt.recordings"]
