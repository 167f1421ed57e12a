"""A machine without memory, descriptors, processes or disk: one line that says which, exit code 1, no traceback."""

from __future__ import annotations

import errno
import subprocess
import sys
from pathlib import Path

import pytest

from mcdas_opt.cli.shortage import shortage


@pytest.mark.skipif(sys.platform != "linux", reason="operating system: limits as Linux has them")
def test_too_few_descriptors_are_one_line(tmp_path: Path) -> None:
    command = f"benchmark curved --scenes 1 --workers 2 --planners closed-form-corrected --out {tmp_path / 'out'}"
    asked = ["sh", "-c", 'ulimit -n 8; exec "$0" -m mcdas_opt "$@"', sys.executable, *command.split()]
    done = subprocess.run(asked, capture_output=True, text=True, timeout=300.0)
    assert (done.returncode, "Traceback" in done.stderr) == (1, False), done.stderr
    assert done.stderr.splitlines()[-1].startswith("mcdas-opt: the machine has too little left: too many open files")


def test_what_led_to_it_counts_and_nothing_else() -> None:
    def led(to: Exception, by: Exception) -> Exception:
        to.__cause__ = by
        return to

    full = OSError(errno.ENOSPC, "No space left on device")
    assert shortage(MemoryError()) == "out of memory"
    assert shortage(led(ValueError("x"), full)) == "no space left on device"
    assert shortage(RuntimeError("can't start new thread")) == "can't start new thread"
    for other in (None, ValueError("no space left"), FileNotFoundError(errno.ENOENT, "x"), led(KeyError("x"), ValueError("y"))):
        assert shortage(other) == ""
