"""Claims as data: files that name what can be run, goals that can be broken, values that are old when the planner has changed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from benchmarks.claims import __main__ as program
from benchmarks.claims import book, measuring
from benchmarks.claims.book import Claim, Entry, Goal, Record, claims, entry, records, value_at
from mcdas_opt.errors import InputError, ParameterError

CLAIM = """
[[claim]]
name = "one"
says = "of a drive"
size = "quick"
command = "mcdas-opt simulate sandwich-60-40 --json"
value = "plans"
goal = { at_most = 80 }
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(book, "FOLDER", tmp_path)
    monkeypatch.setattr(book, "RECORDS", tmp_path / "records.toml")
    monkeypatch.setattr(measuring, "RECORDS", tmp_path / "records.toml")
    (tmp_path / "own.toml").write_text(CLAIM)
    return tmp_path


def test_every_claim_is_measurable_and_every_record_is_a_claims() -> None:
    known = claims()
    assert len(known) >= 20
    assert all(str(claim.goal) for claim in known.values())
    assert set(records()) <= set(known)
    assert {name for name, claim in known.items() if claim.size == "quick"} <= set(records())
    for name, found in records().items():
        assert known[name].goal.kept_by(found.value), name


@pytest.mark.parametrize(
    ("goal", "kept", "broken"),
    [
        (Goal(at_most=3), (3, 2.5, -1), (3.1, "x", True, None)),
        (Goal(at_least=1, at_most=2), (1, 2), (0.9, 2.1)),
        (Goal(equals="safe"), ("safe",), ("collision", 1)),
        (Goal(equals=0), (0, 0.0), (1,)),
        (Goal(equals=True), (True,), (False,)),
    ],
)
def test_a_goal_can_be_broken(goal: Goal, kept: tuple[Any, ...], broken: tuple[Any, ...]) -> None:
    assert all(goal.kept_by(value) for value in kept)
    assert not any(goal.kept_by(value) for value in broken)


def test_a_run_says_what_holds_and_keeps_it_where_it_is_asked_to(
    own: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said: dict[str, Any] = {"plans": 80}
    monkeypatch.setattr(measuring, "_run", lambda claim: said)
    assert program.main(["run", "one", "--write"]) == 0
    assert records()["one"].value == 80
    assert not entry("one").record.is_old
    said["plans"] = 81
    assert program.main(["run", "quick"]) == 1
    assert "BROKEN" in capsys.readouterr().out
    assert records()["one"].value == 80
    del said["plans"]
    assert program.main(["run", "quick"]) == 1
    assert "there is no plans" in capsys.readouterr().out
    assert program.main(["run", "one", "--old"]) == 0
    assert "0 of 0 kept" in capsys.readouterr().out
    monkeypatch.setattr(book, "planner_digest", lambda: "another")
    assert program.main([]) == 0
    assert "old" in capsys.readouterr().out


def test_what_was_measured_before_a_run_is_stopped_is_kept(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (own / "own.toml").write_text(CLAIM + CLAIM.replace('name = "one"', 'name = "two"').replace("--json", "--json --seed 2"))

    def stopped_at_two(claim: Claim) -> dict[str, Any]:
        if claim.name == "two":
            raise KeyboardInterrupt
        return {"plans": 80}

    monkeypatch.setattr(measuring, "_run", stopped_at_two)
    assert program.main(["run", "quick", "--write"]) == 130
    assert entry("one").is_fresh
    assert not entry("two").is_fresh


def test_a_command_that_fails_is_not_measured(own: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (own / "own.toml").write_text(CLAIM.replace("sandwich-60-40", "nowhere"))
    assert program.main(["run", "one"]) == 1
    assert "exit 2" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (CLAIM.replace("mcdas-opt simulate", "mcdas-opt simulat"), "did you mean 'simulate'"),
        (CLAIM.replace("mcdas-opt simulate", "rm"), "must begin with mcdas-opt or python -m benchmarks.NAME"),
        (CLAIM.replace("mcdas-opt simulate", "python -m benchmarks.luck"), "no such benchmark"),
        (CLAIM.replace("value =", "valeu ="), "valeu"),
        (CLAIM + CLAIM, "stands twice"),
    ],
)
def test_a_claims_file_that_cannot_be_run_is_refused_in_one_line(own: Path, wrong: str, says: str) -> None:
    (own / "own.toml").write_text(wrong)
    with pytest.raises(InputError, match=says):
        claims()
    assert program.main([]) == 2


def test_values_are_found_and_shown() -> None:
    document = {"a": {"b": 2}, "rows": [{"item": "x", "n": 1}, {"item": "y", "n": 2}]}
    assert [value_at(document, path) for path in ("a.b", "rows[item=y].n", "rows[#]")] == [2, 2, 2]
    for path in ("a.c", "rows[item=z].n", "a.b.c"):
        with pytest.raises(LookupError, match=path.rpartition("[")[0] or path):
            value_at(document, path)
    claim = Claim(name="x", says="", size="quick", command="", value="k", unit="m", goal=Goal(at_most=1))
    stamp: dict[str, Any] = {"date": "2026-01-01", "commit": "", "planner": ""}
    assert Entry(claim=claim, record=None).shown == "not measured"
    assert Entry(claim=claim, record=Record(value=1.23456, **stamp)).shown == "1.235 m"
    share = Record(value=10, of=1380, low=0.00348, high=0.0133, **stamp)
    assert Entry(claim=claim.model_copy(update={"unit": ""}), record=share).shown == "10/1380 [0.3, 1.3 %]"
    with pytest.raises(ParameterError, match="did you mean"):
        entry("sandwich-los")
