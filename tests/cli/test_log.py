"""What is said besides results: on stderr, through `logging`, and not at all where nobody wants it."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest

from mcdas_opt.cli import log
from mcdas_opt.cli.progress import progress_bar, stages
from tests.cli.command_line import run


@pytest.fixture(autouse=True)
def heard() -> Iterator[None]:
    log.say()
    yield
    log.say()


def test_errors_stand_behind_the_commands_name_and_the_rest_as_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    log.complain("no\x1b[31m")
    log.hint("perhaps")
    log.tell("drives: 1 of 2")
    out, err = capsys.readouterr()
    assert out == ""
    assert err == "mcdas-opt: no\\x1b[31m\nmcdas-opt: perhaps\ndrives: 1 of 2\n"


def test_quiet_leaves_errors_alone(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    fast = ("tune", "--speed", "40", "--json")
    code, _, err = run(monkeypatch, capsys, *fast)
    assert code == 0
    assert "which is 144 km/h" in err
    code, out, err = run(monkeypatch, capsys, "--quiet", *fast)
    assert (code, err) == (0, "")
    assert out.startswith("{")
    code, _, err = run(monkeypatch, capsys, "--quiet", "tune", "--speed", "fast")
    assert code == 2
    assert err


def test_without_a_terminal_there_are_no_bars_and_stages_are_lines(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("drive") as advance:
        for k in range(3):
            advance(k, 2)
    assert capsys.readouterr() == ("", "")
    with stages() as told:
        for k in range(3):
            told("drives", k, 2)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("drives: 2 of 2, ")


def test_a_terminal_gets_a_bar_unless_it_asks_for_quiet(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(type(sys.stderr), "isatty", lambda self: True)
    monkeypatch.setenv("TERM", "xterm")
    for quiet in (False, True):
        log.say(quiet)
        with progress_bar("drive") as advance:
            advance(1, 2)
        assert ("drive" in capsys.readouterr().err) is not quiet
