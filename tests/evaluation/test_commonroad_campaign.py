"""CommonRoad scenarios side by side: rows, a table, a picture of each loss; a stopped run goes on, another one's folder is left alone."""

from __future__ import annotations

import json
import tarfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mcdas_opt.cli.app import app
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.evaluation.commonroad_campaign import (
    NOT_SHOWN,
    OURS,
    REFUSED,
    SAFE,
    kind_of,
    lines,
    run,
    scenario_files,
    scenario_names,
    shown_by_others,
    summarise,
)
from mcdas_opt.evaluation.running.messages import Answer, Ended, Task
from tests.interop.test_commonroad import scenario

RUN = CliRunner()


def row(name: str, planner: str, end: str, **more: object) -> dict[str, object]:
    driven = {"kind": "urban", "blame": "" if end == SAFE else OURS, "goal": "reached", "cycles": 10, "fallback": 1, "unavoidable": 0}
    comfort = {"p50_ms": 1.0, "most_lateral_mps2": 1.0, "most_braking_mps2": 2.0}
    return {"scenario": name, "planner": planner, "end": end, **driven, **comfort, **more}


def test_the_summary_counts_by_kind_and_pairs_the_planners() -> None:
    rows = [
        row("a", "x", SAFE),
        row("b", "x", "struck in front"),
        row("c", "x", REFUSED),
        row("d", "x", SAFE, kind="highway", goal="ahead"),
    ]
    rows += [row("a", "y", "left_road"), row("b", "y", "struck in front"), row("c", "y", SAFE), row("d", "y", SAFE)]
    found = summarise(rows, ["x", "y"])
    ours = found["x"]
    assert [(ours[key]["k"], ours[key]["n"]) for key in ("refused", "lost_urban", "lost_elsewhere", "goal_reached")] == [
        (1, 4),
        (1, 2),
        (0, 1),
        (2, 3),
    ]
    assert (ours["fallback_or_unavoidable"]["k"], ours["fallback_or_unavoidable"]["n"]) == (3, 30)
    paired = found["y"]["paired_with_x"]
    assert (paired["n"], paired["only_first"], paired["only_second"]) == (3, 0, 1)


def test_the_summary_says_how_calmly_it_was_driven() -> None:
    rows = [
        row("a", "x", SAFE, evasions=2, warned=4, most_lateral_mps2=4.1),
        row("b", "x", SAFE, evasions=1, warned=0),
        row("c", "x", REFUSED, most_lateral_mps2=9.0),
    ]
    found = summarise(rows, ["x"])["x"]
    assert found["evasions"] == 3
    assert [(found[key]["k"], found[key]["n"]) for key in ("warned", "harsh")] == [(4, 20), (1, 2)]
    told = dict(lines({"x": found}))
    assert (told["evasions begun"], told["warned cycles"], told["drives with over 4 m/s^2 across"]) == (["3"], ["4/20"], ["1/2"])


def test_what_another_planner_drove_safely_could_be_driven() -> None:
    lost = {"blame": NOT_SHOWN, "chance_s": None, "duration_s": 4.1}
    rows = [row("a", "x", "left_road", **lost), row("a", "y", SAFE), row("b", "x", "left_road", **lost), row("b", "y", "left_road", **lost)]
    assert [(one["blame"], one.get("chance_s")) for one in shown_by_others(rows)] == [
        (OURS, 4.1),
        ("", None),
        (NOT_SHOWN, None),
        (NOT_SHOWN, None),
    ]


def test_the_kind_is_the_scenarios_own_tag() -> None:
    assert kind_of("<scenarioTags><urban/><speed_limit/></scenarioTags>") == "urban"
    assert kind_of('<commonRoad tags="highway lane_change">') == "highway"
    assert kind_of("<commonRoad>") == "other"


def test_archives_and_folders_are_read_and_an_empty_one_is_refused(tmp_path: Path) -> None:
    (tmp_path / "b.xml").write_text("<commonRoad/>")
    with tarfile.open(tmp_path / "more.tar.xz", "w:xz") as archive:
        archive.add(tmp_path / "b.xml", "deep/a.xml")
    with scenario_files(tmp_path) as found:
        assert [path.stem for path in found] == ["a", "b"]
    (tmp_path / "none").mkdir()
    with pytest.raises(InputError, match="no CommonRoad scenario"), scenario_files(tmp_path / "none"):
        pass
    (tmp_path / "bad.tar.xz").write_text("no archive")
    with pytest.raises(InputError, match="no archive"), scenario_files(tmp_path / "bad.tar.xz"):
        pass


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    for name in ("a/same.xml", "b/same.XML", "b/a/same.xml", "alone.Xml"):
        (tmp_path / "data" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "data" / name).write_text("<commonRoad/>")
    for one in ("one", "two"):
        with tarfile.open(tmp_path / "data" / f"{one}.tar.gz", "w:gz") as archive:
            archive.add(tmp_path / "data" / "a" / "same.xml", "same.xml")
    with scenario_files(tmp_path / "data") as found:
        names = scenario_names(found)
        rows = run(found, ["x"], tmp_path / "out", Named(), limit_s=1.0, resume=False, progress=lambda *_: None)
    kept = ["alone", "b/a/same.xml", "b/same.XML", "data/a/same.xml", "one.tar.gz/same.xml", "two.tar.gz/same.xml"]
    assert sorted(names) == kept
    assert [(row["scenario"], row["why"]) for row in rows] == [(name, name) for name in names]


def test_a_file_in_the_folder_that_one_is_in_has_no_more_than_its_name() -> None:
    assert scenario_names([Path("x.xml"), Path("a/x.xml"), Path("y.xml")]) == ["x.xml", "a/x.xml", "y"]


class Named:
    """Drives nothing: a row is called as it was asked for."""

    def run(self, tasks: list[Task]) -> Iterator[tuple[int, Answer]]:
        for k, task in enumerate(tasks):
            yield k, Answer(Ended.RETURNED, row(task.arguments[0], "x", SAFE, why=task.arguments[0]))


def test_the_command_drives_a_folder_and_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
    pytest.importorskip("commonroad")
    data, out = tmp_path / "data", tmp_path / "out"
    data.mkdir()
    (data / "own.xml").write_text(scenario(), "utf-8")
    (data / "without.xml").write_text(scenario(lanes=False), "utf-8")
    command = ["benchmark", "commonroad", "--data", str(data), "--planners", "closed-form-corrected", "--out", str(out), "--workers", "1"]
    first = RUN.invoke(app, [*command, "--json"])
    assert first.exit_code == 0, first.output
    summary = json.loads(first.stdout)["summary"]["closed-form-corrected"]
    assert (summary["refused"]["k"], summary["refused"]["n"], summary["lost"]["n"]) == (1, 2, 1)
    rows = (out / "rows.csv").read_text()
    assert len(rows.splitlines()) == 3
    lost = summary["lost"]["k"]
    assert len(list((out / "pictures").glob("*.png")) if lost else []) == lost
    assert isinstance(RUN.invoke(app, command).exception, InputError)  # holds rows of this very run
    again = RUN.invoke(app, [*command, "--resume"])
    assert again.exit_code == 0
    assert "without: refused: lanelet: the scenario has no lane" in again.stdout
    assert (out / "rows.csv").read_text() == rows
    other = RUN.invoke(app, [*command[:-6], "--planners", "acc", "--out", str(out)])
    assert isinstance(other.exception, InputError)


def test_a_run_of_which_every_scenario_is_refused_is_bad_input(tmp_path: Path) -> None:
    pytest.importorskip("commonroad")
    data, out = tmp_path / "data", tmp_path / "out"
    data.mkdir()
    (data / "without.xml").write_text(scenario(lanes=False), "utf-8")
    command = ["benchmark", "commonroad", "--data", str(data), "--planners", "acc", "--out", str(out), "--workers", "1"]
    answer = RUN.invoke(app, command)
    assert answer.exit_code == 2
    assert "without: refused" in answer.stdout
    again = RUN.invoke(app, [*command, "--resume", "--json"])
    assert again.exit_code == 2
    assert json.loads(again.stdout)["summary"]["acc"]["refused"]["k"] == 1


def test_a_run_without_data_is_told_what_it_lacks() -> None:
    pytest.importorskip("commonroad")
    answer = RUN.invoke(app, ["benchmark", "commonroad"])
    assert isinstance(answer.exception, InputError)
    assert "--data" in str(answer.exception)


def test_the_plant_that_is_named_drives_and_one_that_is_none_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("commonroad")
    data = tmp_path / "data"
    data.mkdir()
    (data / "own.xml").write_text(scenario(), "utf-8")
    command = ["benchmark", "commonroad", "--data", str(data), "--planners", "acc", "--workers", "1", "--out"]
    with pytest.raises(ParameterError, match="plant = 'no-such-plant'"):
        RUN.invoke(app, [*command, str(tmp_path / "none"), "--plant", "no-such-plant"], catch_exceptions=False)
    assert not (tmp_path / "none").exists()
    rows = []
    for plant in ("kinematic", "dynamic"):
        answer = RUN.invoke(app, [*command, str(tmp_path / plant), "--plant", plant, "--json"])
        assert answer.exit_code == 0, answer.output
        assert json.loads(answer.stdout)["plant"] == plant
        assert json.loads((tmp_path / plant / "run.json").read_text("utf-8"))["plant"] == plant
        rows.append((tmp_path / plant / "rows.csv").read_text("utf-8"))
    timed = [one.splitlines()[1].split(",")[:-3] for one in rows]
    assert timed[0] != timed[1]
    with pytest.raises(InputError, match="plant = 'kinematic': is of another run"):
        RUN.invoke(app, [*command, str(tmp_path / "kinematic"), "--plant", "dynamic", "--resume"], catch_exceptions=False)
    with pytest.raises(InputError, match="--seed: not read by commonroad"):
        RUN.invoke(app, [*command, str(tmp_path / "none"), "--seed", "7"], catch_exceptions=False)
