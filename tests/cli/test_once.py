"""An option that is given twice is refused: only its last value would count."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.command_line import run


@pytest.mark.parametrize("arguments", [("--out", "a.html", "--out", "a.png"), ("--planner", "mpc", "--planner=mpc")])
@pytest.mark.parametrize("command", [("plan", "sandwich-60-40"), ("simulate", "sandwich-60-40"), ("park", "parallel")])
def test_an_option_that_is_given_twice_is_refused(
    command: tuple[str, ...],
    arguments: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = run(monkeypatch, capsys, *command, *arguments)
    option = arguments[0]
    assert (code, out, err) == (2, "", f"mcdas-opt: {option}: is given 2 times, and takes one value\n")
    assert not list(tmp_path.iterdir())
