"""The guide to extending: its planner runs, and each of its three changes, made to a copy of the package, does what the guide shows."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import mcdas_opt
from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.native.form import SWITCH
from mcdas_opt.native.library import library

ROOT = Path(__file__).parents[2]
PACKAGE = Path(mcdas_opt.__file__).parent
PAGES = [page.read_text("utf-8") for page in sorted((ROOT / "docs" / "extend").glob("*.md"))]
SECTIONS = {text.removeprefix("# ").split("\n", 1)[0]: text for text in PAGES}
CHANGES = ("A candidate", "A cost term", "A constraint")
MOST_LINES = 30


def block(section: str, language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", SECTIONS[section], re.S)
    assert found is not None, f"{section!r} has no {language} block"
    return found.group(1)


def apply(change: str, root: Path) -> int:
    """Makes a change to the files below `root`; how many lines it adds or takes away. Each of its places has to be found just once."""
    path, lines = root, 0
    for hunk in re.split(r"^(?=@@ |--- )", change, flags=re.M)[1:]:
        head, *body = hunk.splitlines()
        if head.startswith("--- "):
            path = root / body[0].removeprefix("+++ b/")
            continue
        old = "\n".join(line[1:] for line in body if not line.startswith("+"))
        new = "\n".join(line[1:] for line in body if not line.startswith("-"))
        text = path.read_text("utf-8")
        assert text.count(old) == 1, f"{path.name} does not hold, once:\n{old}"
        path.write_text(text.replace(old, new), encoding="utf-8")
        lines += sum(line[:1] in "+-" for line in body)
    return lines


def run(script: str, root: Path, form: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(root), SWITCH: form}
    done = subprocess.run([sys.executable, "-c", script], cwd=root, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done


def printed(script: str, root: Path) -> str:
    return run(script, root, "0").stdout


def copied(root: Path) -> None:
    shutil.copytree(PACKAGE, root / "mcdas_opt", ignore=shutil.ignore_patterns("__pycache__"))
    if PACKAGE not in models_folder().parents:
        shutil.copytree(models_folder(), root / "models")


@pytest.mark.parametrize("section", CHANGES)
def test_change_is_short_and_does_what_the_guide_shows(section: str, tmp_path: Path) -> None:
    """In the compiled form too, which says that it does not know a changed lane problem."""
    copied(tmp_path)
    assert apply(block(section, "diff"), tmp_path) < MOST_LINES
    for form in ("0", "1"):
        done = run(block(section, "python"), tmp_path, form)
        assert [line.rstrip() for line in done.stdout.splitlines()] == block(section, "text").splitlines()
        if library() is not None:
            assert ("InterpretedFormWarning" in done.stderr) == (form == "1" and section == "A constraint")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (r'(            Comfort\(\),\n|        "comfort": SlackPenalty.*\n)', ""),
        (r'        "headway": SlackPenalty.*\n|(?<=HORIZON_S)(?=\))', lambda found: "" if found.group() else ', slack="comfort"'),
    ],
    ids=["comfort removed", "headway's slack merged"],
)
def test_constraint_or_slack_taken_away_is_planned_without(old: str, new: str | Callable[[re.Match[str]], str], tmp_path: Path) -> None:
    copied(tmp_path)
    path = tmp_path / "mcdas_opt" / "ocp" / "lane_mpc.py"
    text, count = re.subn(old, new, path.read_text("utf-8"))
    assert count == 2
    path.write_text(text, encoding="utf-8")
    script = "import mcdas_opt as mo; p = mo.plan(mo.Situation(host=mo.HostState(speed_mps=10.0))); print(p.status.value, p.solver)"
    assert run(script, tmp_path, "1").stdout.strip() == "planned interior-point (interpreted)"


def test_planner_drives() -> None:
    assert printed(block("A planner", "python"), ROOT).strip() == "safe"


def test_plant_is_driven() -> None:
    lines = printed(block("A plant", "python"), ROOT).splitlines()
    assert [line.rstrip() for line in lines] == block("A plant", "text").splitlines()


def test_a_scene_of_another_format_is_driven(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    script = block("My own scene and road", "python")
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == (block("My own scene and road", "text"), "")


def test_the_scene_of_changing_lanes_comes_to_its_destination(tmp_path: Path) -> None:
    path = tmp_path / "lanes.toml"
    path.write_text(block("My own scene and road", "toml"), encoding="utf-8")
    drive = mcdas_opt.simulate(path)
    assert (drive.outcome, drive.fallbacks, drive.unverified_plans) == (mcdas_opt.Outcome.SAFE, 0, 0)
    destination = load_scene(path).destination
    assert destination is not None
    assert destination.s_m is not None
    first, last = destination.s_m
    there = (drive.trajectory.s_m >= first) & (drive.trajectory.s_m <= last)
    assert there.any()
    assert (abs(drive.trajectory.d_m[there] - 3.7) < 0.5).all()


def test_the_suite_is_drawn(tmp_path: Path) -> None:
    path = tmp_path / "van.toml"
    path.write_text(block("My own suite", "toml"), encoding="utf-8")
    suite = expand(path)
    assert len(suite.cases) == 20
    assert {case.scene.vehicle.name for case in suite.cases} == {"lincoln_mkz"}
    assert all(30.0 / 3.6 <= case.scene.host.speed_mps <= 60.0 / 3.6 for case in suite.cases)
