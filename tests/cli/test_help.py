"""What --help says is what the options' texts say, units in brackets included."""

from __future__ import annotations

import re

import pytest
import typer
from typer.testing import CliRunner

from mcdas_opt.cli.app import app

COMMANDS = typer.main.get_command(app).commands


def bare(text: str) -> str:
    """Without frames, spaces and marks of code."""
    return re.sub(r"[\s│╭╮╰╯─`]", "", text)


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_every_text_is_shown_whole(name: str) -> None:
    shown = bare(CliRunner().invoke(app, [name, "--help"], env={"COLUMNS": "400", "TERMINAL_WIDTH": "400"}).stdout)
    told = [parameter.help for parameter in COMMANDS[name].params if getattr(parameter, "help", None)]
    assert told
    for text in told:
        assert bare(text) in shown, text
