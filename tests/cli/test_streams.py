"""Streams that are full, closed, no longer read or of a narrow encoding, and names that a terminal would obey: one line, no traceback."""

from __future__ import annotations

import io
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mcdas_opt.catalogue.data_files import find
from mcdas_opt.cli.app import app
from mcdas_opt.cli.plain_console import PlainConsole
from mcdas_opt.errors import InputError, ParameterError

posix = pytest.mark.skipif(sys.platform == "win32", reason="operating system: descriptors as POSIX has them")
HOSTILE = "a\x1b[31m\n\x07[/b]"


def ended(redirection: str, *arguments: str, **environment: str) -> tuple[int, str]:
    """Exit code and stderr of a command under a shell's redirection."""
    command = ["sh", "-c", f'exec "$0" -m mcdas_opt "$@" {redirection}', sys.executable, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120.0, env={**os.environ, **environment})
    return done.returncode, done.stderr


@posix
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="operating system: /dev/full")
@pytest.mark.parametrize("arguments", [("--version",), ("plan", "sandwich-60-40", "--json"), ("escapes", "sandwich-60-40")])
def test_a_full_disk_under_stdout_is_one_line(arguments: tuple[str, ...]) -> None:
    code, said = ended(">/dev/full", *arguments)
    assert code == 2
    assert said.splitlines()[-1] == "mcdas-opt: stdout: cannot be written: No space left on device"
    assert "Traceback" not in said


def unread(*arguments: str) -> tuple[int, str]:
    """Exit code and stderr of a command whose stdout is a pipe that nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [sys.executable, "-m", "mcdas_opt", *arguments], stdout=writer, stderr=subprocess.PIPE, text=True, timeout=120.0, check=False
    )
    os.close(writer)
    return done.returncode, done.stderr


@posix
@pytest.mark.parametrize(
    "arguments", [("plan", "sandwich-60-40", "--json"), ("escapes", "sandwich-60-40"), ("schema", "scene"), ("--version",)]
)
def test_where_nobody_reads_a_command_ends_as_by_sigpipe(arguments: tuple[str, ...]) -> None:
    assert unread(*arguments) == (141, "")


@posix
@pytest.mark.parametrize(
    ("arguments", "written"),
    [
        (("plan", "sandwich-60-40", "--out", "x.png"), ["x.png"]),
        (("plan", "sandwich-60-40", "--json", "--out", "x.png"), ["x.png"]),
        (("escapes", "sandwich-60-40", "--out", "x.png"), ["x.png"]),
        (("tune", "--speed", "16.7", "--out", "x.toml"), ["x.png", "x.toml"]),
    ],
)
def test_what_is_asked_for_is_written_where_nobody_reads(arguments: tuple[str, ...], written: list[str], tmp_path: Path) -> None:
    *rest, out = arguments
    assert unread(*rest, str(tmp_path / out)) == (141, "")
    assert sorted(path.name for path in tmp_path.iterdir()) == written


@posix
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="operating system: /dev/full")
def test_what_is_asked_for_is_written_where_stdout_is_full(tmp_path: Path) -> None:
    code, said = ended(">/dev/full", "plan", "sandwich-60-40", "--out", str(tmp_path / "x.png"))
    assert (code, said.splitlines()[-1]) == (2, "mcdas-opt: stdout: cannot be written: No space left on device")
    assert (tmp_path / "x.png").exists()


@posix
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="operating system: no /dev/full")
def test_a_hint_that_cannot_be_written_ends_nothing() -> None:
    assert ended("2>/dev/full", "tune", "--speed", "40") == (0, "")


def test_how_somebody_shows_figures_does_not_matter(tmp_path: Path) -> None:
    drawn = tmp_path / "drawn.png"
    assert ended("", "tune", "--out", str(drawn), MPLBACKEND="nonsense") == (0, "")
    assert drawn.is_file()


@posix
def test_nobody_to_answer_to() -> None:
    assert ended(">&-", "plan", "sandwich-60-40") == (2, "mcdas-opt: stdout: is closed\n")
    assert ended("<&- 2>&- >/dev/null", "escapes", "sandwich-60-40", "--json") == (0, "")
    assert ended("<&- 2>&- >/dev/null", "escapes", "no-such-scene")[0] == 2


@posix
def test_a_letter_that_the_encoding_lacks_is_written_as_its_number(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert ended(f">{out}", "escapes", "sandwich-60-40", PYTHONIOENCODING="ascii") == (0, "")
    assert rb"m/s\xb2" in out.read_bytes()


def test_names_of_files_and_scenes_are_printed_as_they_are_written(tmp_path: Path) -> None:
    missing = CliRunner().invoke(app, ["plan", HOSTILE + ".toml"])
    assert isinstance(missing.exception, InputError)
    assert str(missing.exception).startswith(r"a\x1b[31m\n\x07[/b].toml: no such file")
    named, drawn = tmp_path / f"{HOSTILE.replace('/', '')}.toml", tmp_path / f"{HOSTILE.replace('/', '')}.json"
    named.write_text(find("scenes", "sandwich-60-40").read_text("utf-8").replace('"front"', r'"\u001b[1m[/c]"'), "utf-8")
    done = CliRunner().invoke(app, ["plan", str(named), "--out", str(drawn)])
    assert done.exit_code == 0
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f]", done.stdout)
    assert r"\x1b[31m\x07[b].json" in done.stdout.replace("\n", "")


def test_text_on_the_screen_commands_no_terminal() -> None:
    shown = io.StringIO()
    PlainConsole(file=shown, force_terminal=True, markup=False, highlight=False, width=200).print(HOSTILE, style="bold")
    assert shown.getvalue() == "\x1b[1ma\\x1b[31m\x1b[0m\n\x1b[1m\\x07[/b]\x1b[0m\n"


def test_an_error_is_one_line_whatever_it_quotes() -> None:
    for error in (InputError("f\x1b", "k\n", "v\n", "rule\x07"), ParameterError("n\x1b", "v\n", "rule\r", "m")):
        assert str(error).isprintable()
