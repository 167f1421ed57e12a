"""The command line, called in this process."""

from __future__ import annotations

import sys

import pytest

from mcdas_opt.cli import main


def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of `mcdas-opt` with these arguments."""
    monkeypatch.setattr(sys, "argv", ["mcdas-opt", *arguments])
    code = 0
    try:
        main()
    except SystemExit as stop:
        code = int(stop.code or 0)
    out, err = capsys.readouterr()
    return code, out, err
