"""A page's state: what it opens, what it answers, what it writes."""

from __future__ import annotations

import csv
import importlib.util
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcdas_opt.catalogue.data_files import models_folder, shipped
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.planning.method import known_methods
from mcdas_opt.plotting.outlook import Outlook
from mcdas_opt.plotting.web import PLANNERS
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.parking_tab import ParkingTab
from mcdas_opt.studio.planner_cache import PlannerCache, methods
from mcdas_opt.studio.sandwich_tab import SandwichTab, _scene

NASTY = "<script>alert(1)</script>"
LOGS = importlib.util.find_spec("cantools") is not None and importlib.util.find_spec("can") is not None


@pytest.fixture
def sandwich(tmp_path: Path) -> SandwichTab:
    return SandwichTab(Folder(root=tmp_path))


def turn(sandwich: SandwichTab, changes: dict[str, Any], stroke: str | None = None) -> None:
    sandwich.act({"do": "edit", "changes": changes, "stroke": stroke})


@pytest.mark.parametrize("name", shipped("scenes"))
def test_a_saved_scene_is_the_scene_that_was_seen(sandwich: SandwichTab, tmp_path: Path, name: str) -> None:
    sandwich.open("shipped", name)
    turnable = {k: v for k, v in sandwich.state()["positions"].items() if v is not None and k not in ("a_per_m", "b", "y_max_m")}
    values = {"friction": 0.55} | ({"rear_gap_m": turnable["rear_gap_m"] + 3.25} if "rear_gap_m" in turnable else {})
    turn(sandwich, values)
    file, text = sandwich.toml()
    (tmp_path / file).write_text(text, encoding="utf-8")
    again = load_scene(tmp_path / file)
    assert again.model_dump() == sandwich.at.scene.model_dump()
    assert again.road.friction == 0.55


def test_a_name_with_tags_is_only_a_name(sandwich: SandwichTab, tmp_path: Path) -> None:
    (tmp_path / "evil.toml").write_text(f'name = "{NASTY}"\n[host]\nspeed_mps = 11.1\n')
    assert sandwich.open("scene", "evil.toml")["name"] == NASTY
    file, text = sandwich.toml()
    assert "<" not in file
    assert "/" not in file
    (tmp_path / file).write_text(text)
    assert load_scene(tmp_path / file).name == NASTY


@pytest.mark.parametrize(
    ("kind", "name"), [("scene", "../x.toml"), ("log", "/etc/passwd"), ("results", "../rows.csv"), ("shipped", "../x")]
)
def test_what_lies_outside_stays_closed(sandwich: SandwichTab, kind: str, name: str) -> None:
    before = sandwich.opened()
    with pytest.raises(InputError):
        sandwich.open(kind, name)
    assert sandwich.opened() == before


def test_an_unknown_kind_and_a_row_without_a_table(sandwich: SandwichTab) -> None:
    for kind in ("exec", "row"):
        with pytest.raises(ParameterError, match="kind"):
            sandwich.open(kind, "0")


def test_a_received_file_is_told_by_the_name_it_had(sandwich: SandwichTab, tmp_path: Path) -> None:
    file = tmp_path / "sent.toml"
    file.write_text("[host]\nspeed_mps = -3\n")
    with pytest.raises(InputError, match=r"my scene\.toml: host\.speed_mps") as told:
        sandwich.read_sent(file, "my scene.toml")
    assert str(tmp_path) not in str(told.value)


def test_a_parking_case_belongs_to_the_other_tab(sandwich: SandwichTab, tmp_path: Path) -> None:
    (tmp_path / "slot.toml").write_text("[slot]\nlength_m = 6.0\n")
    with pytest.raises(InputError, match="parking tab"):
        sandwich.open("scene", "slot.toml")


def test_every_planner_answers_in_plain_json(sandwich: SandwichTab) -> None:
    turn(sandwich, {"rear_gap_m": 20.0, "b": 40.0})
    question = sandwich.question()
    assert question.sigmoid.b == 40.0
    cache, outlook = PlannerCache(), Outlook(question.situation, question.vehicle).document()
    assert set(PLANNERS) <= set(methods()) == set(known_methods())
    parts = [cache.plan(name, question) for name in PLANNERS]
    for part in (*parts, cache.escapes(question), outlook):
        json.dumps(part, allow_nan=False)
    for part in parts:
        assert part["poses"][0][:2] == pytest.approx([0.0, 0.0], abs=0.01)
        lengths = {len(part["t"]), len(part["poses"]), *(len(line) for line in part["lines"].values())}
        assert len(lengths) == 1
        assert part["passed"] == ("passed by the judge" in part["words"])
    rear = next(body for body in outlook["bodies"] if body["name"] == "rear")
    assert rear["poses"][0][0] == pytest.approx(-24.5, abs=0.01)  # 20 m from bumper to bumper
    assert {chart["key"] for chart in outlook["charts"]} == set(parts[0]["lines"])


def test_other_sigmoids_leave_the_solvers_as_they_are(sandwich: SandwichTab) -> None:
    cache, question = PlannerCache(), sandwich.question()
    cache.plan("mpc", question)
    turn(sandwich, {"b": 30.0})
    warm = cache.plan("mpc", sandwich.question())
    cold = PlannerCache().plan("mpc", sandwich.question())
    np.testing.assert_allclose(warm["poses"], cold["poses"], atol=0.02)


def rows_of(folder: Path, suite_hash: str | None = None) -> Path:
    suite = expand("sandwich", 3, 5)
    origin = {"suite": "sandwich", "seed": 5, "scenes": 3, "suite_hash": suite_hash or suite.hash}
    path = folder / "rows.csv"
    with path.open("w", newline="") as file:
        file.write(f"# {json.dumps(origin)}\n")
        table = csv.DictWriter(file, ["index", "scene", "planner", "outcome", "collided_with"])
        table.writeheader()
        for index in range(3):
            for planner, outcome in (("mpc", "safe"), ("closed-form", "collision")):
                name = suite.cases[index].scene.name
                table.writerow({"index": index, "scene": name, "planner": planner, "outcome": outcome, "collided_with": "rear"})
    return path


def test_rows_of_a_benchmark_are_their_scenes(sandwich: SandwichTab, tmp_path: Path) -> None:
    rows_of(tmp_path)
    opened: dict[str, Any] = sandwich.open("results", "rows.csv")
    assert [text.split(" · ")[2] for _, text in opened["rows"]] == ["collision with rear"] * 3 + ["safe with rear"] * 3
    assert (opened["row"], opened["planner"]) == (opened["rows"][0][0], "closed-form")
    for number, text in opened["rows"]:
        row = sandwich.open("row", number)
        assert text.startswith(f"{row['name']} · {row['planner']}")
        assert sandwich.at.scene.name == row["name"]
    for wrong in ("6", "-1", "x"):
        with pytest.raises(InputError, match="row"):
            sandwich.open("row", wrong)


def test_rows_of_another_suite_are_refused(sandwich: SandwichTab, tmp_path: Path) -> None:
    rows_of(tmp_path, suite_hash="0" * 8)
    with pytest.raises(InputError, match="suite_hash"):
        sandwich.open("results", "rows.csv")
    (tmp_path / "rows.csv").write_text("# {}\nindex\n0\n")
    with pytest.raises(InputError, match="not a table"):
        sandwich.open("results", "rows.csv")


@pytest.mark.skipif(not LOGS, reason="reading CAN logs needs the extra `can`")
def test_every_moment_of_a_log_is_a_situation(sandwich: SandwichTab) -> None:
    opened = sandwich.open("shipped-log", "front_and_rear")
    times = opened["moments"]
    assert times == sorted(times)
    assert times[0] == 0.0
    assert sandwich.state()["positions"]["front_gap_m"] is None
    for moment in (0, opened["moment"], len(times) - 1):
        question = sandwich.question(moment)
        host = question.situation.host
        assert all(abs(track.s_m - host.s_m) < 200.0 for track in question.situation.tracks)
    assert sandwich.question(opened["moment"]).situation.tracks
    with pytest.raises(InputError, match="moment"):
        sandwich.question(len(times))
    assert sandwich.question(None).sigmoid == SigmoidSettings()


def test_the_dragged_slot_is_the_slot_that_is_planned_in(tmp_path: Path) -> None:
    tab = ParkingTab(Folder(root=tmp_path))
    case = tab.case({"length_m": 7.2, "depth_m": 2.4, "street_m": 5.0, "clearance_m": 0.1})
    assert case.slot is not None
    assert (case.slot.length_m, case.slot.depth_m, case.slot.street_m, case.limits.clearance_m) == (7.2, 2.4, 5.0, 0.1)
    place = tab.place(case)
    handles = {handle["key"]: handle["at"] for handle in place["handles"]}
    assert handles["length"][0] == 7.2
    assert handles["depth"][1] == -2.4
    assert handles["street"][1] == 5.0
    moved = tab.case({"start_x_m": 9.0, "start_heading_rad": 0.1})
    np.testing.assert_allclose(moved.start[[0, 2]], [9.0, 0.1])
    with pytest.raises(InputError, match="overlaps"):
        tab.case({"length_m": 4.5, "depth_m": 1.8, "start_x_m": 0.0, "start_y_m": -1.0})
    with pytest.raises(ParameterError):
        tab.case({"length": 5.0})


@pytest.mark.parametrize("name", shipped("cases"))
def test_a_saved_case_is_the_case_that_was_seen(tmp_path: Path, name: str) -> None:
    tab = ParkingTab(Folder(root=tmp_path))
    tab.open("shipped", name)
    file, text = tab.toml({"clearance_m": 0.07})
    (tmp_path / file).write_text(text)
    again = ParkingTab(Folder(root=tmp_path))
    again.open("case", file)
    first, second = tab.case({"clearance_m": 0.07}), again.case({})
    np.testing.assert_array_equal(first.start, second.start)
    np.testing.assert_array_equal(first.goal, second.goal)
    assert first.limits == second.limits
    assert len(first.obstacles) == len(second.obstacles)


def test_a_shipped_scene_is_read_once_as_long_as_it_stays_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "own.toml"
    file.write_bytes((models_folder() / "scenes" / "benign-following.toml").read_bytes())
    first = _scene(file)
    assert _scene(file) is first
    os.utime(file, ns=(0, 0))
    assert _scene(file) is not first
    assert _scene(file) == first
