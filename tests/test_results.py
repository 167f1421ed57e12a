"""Results that can be held: three lines, a picture, a table, a document, a file; the same for every kind of answer."""

from __future__ import annotations

import csv
import json
import sys
from functools import cache
from pathlib import Path

import pytest

import mcdas_opt as mo
from mcdas_opt.domain.result import Result
from mcdas_opt.errors import MissingExtraError


@cache
def answers() -> dict[str, Result]:
    situation = mo.load_situation("sandwich-60-40")
    scene = mo.load_scene("sandwich-60-40")
    return {
        "plan": mo.plan(situation, planner="closed-form-corrected"),
        "drive": mo.simulate(scene.model_copy(update={"duration_s": 0.3}), "closed-form-corrected"),
        "escapes": mo.escapes(situation),
        "parking": mo.park("parallel", "two-arc"),
        "design": mo.tune(speed_mps=20.0),
        "replay": mo.replay("front_and_rear", plan=False),
    }


KINDS = ("plan", "drive", "escapes", "parking", "design", "replay")


@pytest.mark.parametrize("kind", KINDS)
def test_an_answer_is_read_in_three_lines(kind: str) -> None:
    lines = repr(answers()[kind]).splitlines()
    assert len(lines) == 3
    assert all(0 < len(line) <= 200 for line in lines)


@pytest.mark.parametrize("kind", KINDS)
def test_an_answer_is_drawn_and_shown(kind: str, tmp_path: Path) -> None:
    answer = answers()[kind]
    assert answer.plot(tmp_path / "a.png").axes
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert mo.plot(answer).axes
    html = answer._repr_html_()
    assert html.count("<img") == 1
    assert html.count("<table>") == 1


@pytest.mark.parametrize("kind", KINDS)
def test_the_table_the_document_and_the_file_say_the_same(kind: str, tmp_path: Path) -> None:
    answer = answers()[kind]
    columns = answer.columns()
    rows = list(csv.reader(answer.save(tmp_path / "a.csv").read_text().splitlines()))
    assert rows[0] == list(columns)
    assert len(rows) - 1 == len(next(iter(columns.values())))
    assert json.loads(answer.save(tmp_path / "a.json").read_text()) == json.loads(answer.to_json()) == answer.to_dict()


@pytest.mark.parametrize("library", ["pandas", "polars"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_table_is_a_data_frame(kind: str, library: str) -> None:
    pytest.importorskip(library)
    answer = answers()[kind]
    frame = answer.to_dataframe(library)
    assert list(frame.columns) == list(answer.columns())
    assert len(frame) == len(next(iter(answer.columns().values())))


def test_a_table_is_written_as_parquet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    answer = answers()["replay"]
    table = parquet.read_table(answer.save(tmp_path / "a.parquet"))
    assert table.column_names == list(answer.columns())
    assert table["track_s_m"].to_pylist() == answer.columns()["track_s_m"]
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'mcdas-opt\[parquet\]'"):
        answer.save(tmp_path / "b.parquet")


def test_what_moves_moves_and_what_does_not_says_so(tmp_path: Path) -> None:
    assert "<script" in answers()["plan"].save(tmp_path / "plan.html").read_text("utf-8")
    with pytest.raises(mo.InputError, match=r"must end in .png, .svg or .pdf"):
        answers()["escapes"].plot(tmp_path / "escapes.gif")
    with pytest.raises(mo.InputError, match=r"\.json \(the document\)"):
        answers()["plan"].save(tmp_path / "plan.txt")
    with pytest.raises(mo.ParameterError, match="must be a str or a Path"):
        answers()["plan"].plot(3)
    with pytest.raises(mo.InputError, match="no such folder"):
        answers()["plan"].save(tmp_path / "no" / "plan.csv")
    with pytest.raises(mo.ParameterError, match="no answer of this package"):
        mo.plot(3)


def test_a_design_is_saved_as_what_planners_take(tmp_path: Path) -> None:
    from mcdas_opt.planning.parameter_files import planner_with

    file = answers()["design"].save(tmp_path / "best.toml")
    assert planner_with(file, mo.load_vehicle("sedan"), "mpc").name == "mpc"


def test_a_data_frame_without_its_library_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'mcdas-opt\[dataframe\]'"):
        answers()["plan"].to_dataframe()
    with pytest.raises(mo.ParameterError, match="must be pandas or polars"):
        answers()["plan"].to_dataframe("numpy")


def test_a_benchmark_is_held_like_any_other_answer(tmp_path: Path) -> None:
    planners = ("closed-form-corrected", "aeb")
    found = mo.benchmark("euro-ncap-aeb", planners, scenes=2)
    assert len(found.rows) == 4
    assert {row["planner"] for row in found.rows} == set(planners)
    assert set(found.shares("lost")) == set(planners)
    assert all(0.0 <= one["low"] <= one["k"] / one["n"] <= one["high"] <= 1.0 for one in found.shares("lost").values())
    assert {(pair["first"], pair["second"]) for pair in found.pairs} == {planners}
    assert len(repr(found).splitlines()) == 3
    assert len(found.to_dataframe()) == 4
    assert found.plot(tmp_path / "b.png").axes
    with pytest.raises(mo.ParameterError, match="no share"):
        found.shares("luck")
    for wrong in ({"scenes": 0}, {"scenes": "3"}, {"scenes": 2, "seed": -1}, {"scenes": 2, "workers": True}):
        with pytest.raises(mo.ParameterError, match="must be a whole number"):
            mo.benchmark("euro-ncap-aeb", planners, **wrong)
    with pytest.raises(mo.ParameterError, match="not a known planner"):
        mo.benchmark("euro-ncap-aeb", ["nobody"], scenes=1)
