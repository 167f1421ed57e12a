"""Ctrl-C as a terminal sends it, to the whole group of processes: exit 130, one line, and what was found stays usable."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from mcdas_opt.catalogue.data_files import find

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="operating system: signals as POSIX has them")
_PATIENCE_S = 120.0


def interrupted(ready: Callable[[], bool] | None, *arguments: str, by: int = signal.SIGINT) -> tuple[int, str, list[str]]:
    """Exit code, stdout and stderr's lines of a command that is stopped as soon as `ready` says so (None: it prints). The signal is not
    ignored, though these tests may have been begun by `nohup`."""
    command, heard = [sys.executable, "-m", "mcdas_opt", *arguments], partial(signal.signal, by, signal.SIG_DFL)
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, start_new_session=True, preexec_fn=heard, **pipes) as running:
        assert running.stdout is not None
        first = _line_of(running.stdout.fileno()) if ready is None else ""
        until = time.monotonic() + _PATIENCE_S
        while ready is not None and not ready() and running.poll() is None and time.monotonic() < until:
            time.sleep(0.05)
        assert running.poll() is None, running.communicate()
        os.killpg(running.pid, by)
        out, said = running.communicate(timeout=_PATIENCE_S)
    lines = [line for line in said.splitlines() if not line.startswith(("compiling", "labels", "drives"))]
    return running.returncode, first + out, lines


def _line_of(file: int) -> str:
    """One line and no more: what a buffer held beyond it, `communicate` would not read."""
    line = b""
    while (letter := os.read(file, 1)) not in (b"", b"\n"):
        line += letter
    return f"{line.decode()}\n"


def after(seconds: float) -> Callable[[], bool]:
    until = time.monotonic() + seconds
    return lambda: time.monotonic() > until


def test_a_benchmark_with_two_workers_says_how_it_goes_on(tmp_path: Path) -> None:
    folder = tmp_path / "results"
    labelled = folder / "labelling.journal"
    command = ("benchmark", "sandwich", "--scenes", "20", "--planners", "mpc", "--out", str(folder), "--workers", "2", "--json")
    code, out, said = interrupted(lambda: labelled.is_file() and labelled.stat().st_size > 0, *command)
    assert (code, out) == (130, "")
    assert said == [f"mcdas-opt: interrupted; rows so far are in {folder}: the same command with --resume goes on"]


def test_a_command_that_writes_only_at_its_end_says_that_nothing_is_left(tmp_path: Path) -> None:
    long = tmp_path / "long.toml"
    long.write_text(find("scenes", "curved-road").read_text("utf-8").replace("duration_s = 8.0", "duration_s = 600.0"), "utf-8")
    code, out, said = interrupted(after(6.0), "simulate", str(long), "--plant", "dynamic", "--json")
    assert (code, out) == (130, "")
    assert said == ["mcdas-opt: interrupted; what was not yet written is lost"]


DROPPED_WHILE_LOADING = """
import signal, sys

class Press:  # as a C extension does that clears whatever is raised while it is loaded
    def find_spec(self, name, path=None, target=None):
        if name == "mcdas_opt.cli.plan":
            try:
                signal.raise_signal(signal.SIGINT)
            except KeyboardInterrupt:
                pass

sys.meta_path.insert(0, Press())
from mcdas_opt.cli import main
main()
"""
INSIDE_A_TEXT = """
import mcdas_opt.cli.app as commands

def pressed(**ignored):
    exec("import signal; signal.raise_signal(signal.SIGINT)")

commands.app = pressed
from mcdas_opt.cli import main
main()
"""


DROPPED_IN_A_COMMAND = DROPPED_WHILE_LOADING.replace("mcdas_opt.cli.plan", "mcdas_opt.simulation.loop").replace(
    "import main\n", "import main\nsys.argv[1:] = ['simulate', 'benign-following', '--planner', 'closed-form', '--json']\n"
)
WHILE_C_TAKES_AN_ARRAY = """
import signal, sys
from mcdas_opt.native import binding

def pressed(array):  # while radar detections are handed over
    if "radar_fixes" in (sys._getframe(2).f_code.co_name, sys._getframe(3).f_code.co_name):
        signal.raise_signal(signal.SIGINT)
    return as_before(array)

as_before, binding._in_place = binding._in_place, pressed
from mcdas_opt.cli import main
sys.argv[1:] = ["simulate", "benign-following", "--planner", "closed-form", "--json"]
main()
"""
BEFORE_THE_COMMAND = """
import signal
import mcdas_opt.cli.app as commands

commands.prepare_streams = lambda: signal.raise_signal(signal.SIGINT)
from mcdas_opt.cli import main
main()
"""
HELD_AFTER_LOADING = DROPPED_WHILE_LOADING.replace("mcdas_opt.cli.plan", "colorsys").replace(
    "from mcdas_opt.cli import main\n",
    """
import time
import mcdas_opt.cli.app as commands
from mcdas_opt.cli import main
from mcdas_opt.solvers.held_interrupts import held_interrupts

def solved(**ignored):
    import colorsys

    with held_interrupts():
        try:
            time.sleep(0.3)
        except KeyboardInterrupt:  # as CasADi clears it
            pass

commands.app = solved
""",
)
BEFORE = [DROPPED_WHILE_LOADING, BEFORE_THE_COMMAND]
INSIDE = [DROPPED_IN_A_COMMAND, INSIDE_A_TEXT, WHILE_C_TAKES_AN_ARRAY, HELD_AFTER_LOADING]


@pytest.mark.parametrize("program", BEFORE + INSIDE)
def test_an_interrupt_that_is_easily_lost_is_one_line_too(program: str) -> None:
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=_PATIENCE_S)
    assert (ended.returncode, ended.stdout) == (130, "")
    assert ended.stderr == "mcdas-opt: interrupted; what was not yet written is lost\n"


@pytest.mark.parametrize(
    ("by", "cycles", "ends"),
    [(signal.SIGINT, ("--cycles", "100000"), 130), (signal.SIGTERM, ("--cycles", "100000"), 143), (signal.SIGTERM, (), 0)]
    + [(signal.SIGHUP, ("--cycles", "100000"), 129), (signal.SIGHUP, (), 0)],
)
def test_live_ends_with_its_counts(by: int, cycles: tuple[str, ...], ends: int) -> None:
    pytest.importorskip("can")
    code, out, said = interrupted(None, "live", "--play", "front_and_rear", "--rear", "can1", *cycles, by=by)
    assert code == ends
    counts = [json.loads(line) for line in said if line.startswith("{")]
    assert len(counts) == 1
    last = {130: "interrupted", 143: "terminated", 129: "hung up"}
    assert said[-1] == (f"mcdas-opt: {last[code]}; what was printed stands" if code else said[0])
    lines = [json.loads(line) for line in out.splitlines()]
    printed = sum(line["status"] != "late" for line in lines)
    assert 0 <= printed - counts[0]["cycles"] <= 1  # the one that was being printed may not have been counted yet
