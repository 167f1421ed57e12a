"""A machine without memory, descriptors, processes or disk: one line that says which, exit code 1, no traceback."""

from __future__ import annotations

import errno
import re
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from mcdas_opt.cli.shortage import lacking_at_start, shortage


@pytest.mark.skipif(sys.platform != "linux", reason="operating system: limits as Linux has them")
def test_too_few_descriptors_are_one_line(tmp_path: Path) -> None:
    command = f"benchmark curved --scenes 1 --workers 2 --planners closed-form-corrected --out {tmp_path / 'out'}"
    asked = ["sh", "-c", 'ulimit -n 8; exec "$0" -m mcdas_opt "$@"', sys.executable, *command.split()]
    done = subprocess.run(asked, capture_output=True, text=True, timeout=300.0)
    assert (done.returncode, "Traceback" in done.stderr) == (1, False), done.stderr
    assert done.stderr.splitlines()[-1].startswith("mcdas-opt: the machine has too little left: too many open files")


@pytest.mark.skipif(sys.platform != "linux", reason="operating system: limits as Linux has them")
@pytest.mark.parametrize("kib", [60_000, 150_000, 200_000, 330_000])
def test_too_little_memory_is_one_line_and_nobody_waits_for_more(kib: int) -> None:
    asked = ["sh", "-c", f'ulimit -v {kib}; exec "$0" -m mcdas_opt plan sandwich-60-40', sys.executable]
    done = subprocess.run(asked, capture_output=True, text=True, timeout=60.0)
    said = f"mcdas-opt: the machine has too little left: {kib >> 10} MiB of memory are allowed (ulimit -v), and 1024 are needed\n"
    assert (done.returncode, done.stdout, done.stderr) == (1, "", said)


def test_too_few_threads_are_one_line_before_a_library_ends_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    started, start = [], threading.Thread.start

    def at_most(few: int) -> Callable[[threading.Thread], None]:
        def begin(thread: threading.Thread) -> None:
            if len(started) >= few:
                raise RuntimeError("can't start new thread")
            started.append(thread)
            start(thread)

        return begin

    assert lacking_at_start() == ""
    for few in (0, 1, 9):
        started.clear()
        monkeypatch.setattr(threading.Thread, "start", at_most(few))
        assert re.fullmatch(r"can't start new thread, and \d+ are needed \(ulimit -u\)", lacking_at_start())
        for thread in started:
            thread.join(timeout=60.0)
            assert not thread.is_alive()


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
