"""The commands `park` and `judge` on parking cases."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mcdas_opt.cli.app import app

runner = CliRunner()


def run(*arguments: object) -> dict:
    result = runner.invoke(app, [str(a) for a in arguments], catch_exceptions=False)
    assert result.exit_code == 0
    return json.loads(result.stdout)


def test_a_plan_is_judged_again_from_its_file(tmp_path: Path):
    case = tmp_path / "wide.toml"
    case.write_text("[slot]\nlength_m = 8.5\n")
    answer = run("park", case, "--planner", "two-arc", "--json")
    assert answer["status"] == "planned"
    assert answer["verdict"]["passed"]
    assert len(answer["obstacles"]) == 4
    lengths = {len(column) for column in answer["trajectory"].values()}
    assert len(lengths) == 1
    saved = tmp_path / "plan.json"
    saved.write_text(json.dumps(answer))
    again = run("judge", case, saved, "--json")
    assert again["verdict"]["passed"]
    assert again["min_clearance_m"] == pytest.approx(answer["min_clearance_m"], abs=1e-9)
    columns = answer["trajectory"]
    table = tmp_path / "plan.csv"
    rows = zip(*columns.values(), strict=True)
    table.write_text(",".join(columns) + "\n" + "\n".join(",".join(repr(v) for v in row) for row in rows) + "\n")
    assert run("judge", case, table, "--json")["verdict"]["passed"]
    columns["x_m"] = [x + 0.1 for x in columns["x_m"]]
    saved.write_text(json.dumps({"trajectory": columns}))
    assert not run("judge", case, saved, "--json")["verdict"]["passed"]


def test_a_refusal_is_a_result(tmp_path: Path):
    case = tmp_path / "short.toml"
    case.write_text("[slot]\nlength_m = 4.55\n")
    answer = run("park", case, "--json")
    assert answer["status"] == "refused"
    assert answer["trajectory"] is None
    assert "more length" in answer["reason"]
    shown = runner.invoke(app, ["park", str(case)], catch_exceptions=False)
    assert shown.exit_code == 0
    assert "refused" in shown.stdout


def test_the_clearance_on_the_command_line_counts(tmp_path: Path):
    case = tmp_path / "slot.toml"
    case.write_text("[slot]\nlength_m = 8.5\n")
    assert not run("park", case, "--planner", "two-arc", "--clearance", "0.5", "--json")["verdict"]["passed"]


def test_the_clearance_that_was_asked_stands_beside_the_least_one(tmp_path: Path):
    slot = tmp_path / "slot.toml"
    slot.write_text("[slot]\nlength_m = 8.5\n")
    competition = tmp_path / "Case1.csv"
    competition.write_text("100,200,0,106,200,0,1,4,100,203,106,203,106,204,100,204\n")
    asked_of = [
        (slot, (), 0.05),
        (slot, ("--clearance", "0.02"), 0.02),
        (competition, (), 0.0),
        (competition, ("--clearance", "0.05"), 0.05),
    ]
    for case, more, asked in asked_of:
        command = ("park", case, "--planner", "two-arc" if case is slot else "search", *more)
        answer = run(*command, "--json")
        assert answer["asked_clearance_m"] == asked
        shown = runner.invoke(app, [str(a) for a in command], catch_exceptions=False)
        assert f"{answer['min_clearance_m']:.3f} m, {asked:g} m asked" in shown.stdout
