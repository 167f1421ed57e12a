"""Commands that are interrupted, terminated or hung up at any moment from their first line on: they end by it, with one line that says so,
or were done. What they print is a whole document or nothing."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial

import numpy as np

from benchmarks.attack.tally import Tally

_COMMANDS = (
    "plan sandwich-60-40 --json",
    "escapes sandwich-60-40 --json",
    "simulate sandwich-60-40 --json",
    "simulate sandwich-60-40 --plant dynamic --json",
    "simulate benign-following --planner closed-form --json",
    "park parallel --json",
    "park parallel --planner closed-form-corrected --json",
    "tune --json",
    "doctor --json",
)
_BEGUN = "import os, sys; from mcdas_opt.cli import main; os.write(2, b'.'); main()"
_SOONEST_S = 0.002  # the program is in `main` by then
_PATIENCE_S = 120.0
_SAID = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"} | ({} if sys.platform == "win32" else {signal.SIGHUP: "hung up"})


def attack(tally: Tally, count: int, seed: int) -> None:
    """Most are interrupted. How long each takes is seen first, when nobody stops it; that counts as a case."""
    r = np.random.default_rng(seed)
    lasts_s: dict[str, float] = {}
    for _ in range(count):
        command = _COMMANDS[int(r.integers(len(_COMMANDS)))]
        by, share = list(_SAID)[max(0, int(r.integers(-3, len(_SAID))))], float(r.uniform(0.0, 1.1))
        after_s = max(_SOONEST_S, share * lasts_s[command]) if command in lasts_s else _PATIENCE_S
        took_s = tally.ask(partial(_stopped, command, by, after_s), lambda said=(command, by.name, after_s): repr(said), may_refuse=False)
        if command not in lasts_s and took_s is not None:
            lasts_s[command] = took_s


def _stopped(command: str, by: signal.Signals, after_s: float) -> float:
    """How long it took [s]; raises `RuntimeError` where it did not end as it should."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", _BEGUN, *command.split()], cwd="/", preexec_fn=partial(_heard, by), **pipes) as running:
        assert running.stderr is not None
        os.read(running.stderr.fileno(), 1)
        began = time.monotonic()
        try:
            out, said = running.communicate(timeout=after_s)
        except subprocess.TimeoutExpired:
            running.send_signal(by)
            try:
                out, said = running.communicate(timeout=_PATIENCE_S)
            except subprocess.TimeoutExpired:
                running.kill()
                raise RuntimeError("goes on") from None
    _judged(running.returncode, out.decode(), said.decode(), by)
    return time.monotonic() - began


def _heard(by: signal.Signals) -> None:
    """Though the attack may have been begun by `nohup`, or in the background of a shell."""
    signal.signal(by, signal.default_int_handler if by is signal.SIGINT else signal.SIG_DFL)


def _judged(code: int, out: str, said: str, by: signal.Signals) -> None:
    if "Traceback" in said or "Exception ignored" in said:
        raise RuntimeError(said.strip().splitlines()[-1])
    if out:
        json.loads(out)
    told = said.count(f"mcdas-opt: {_SAID[by]}; ")
    # before the command begins, and when it is done, a signal other than Ctrl-C ends the process itself
    if (code, told) not in ((0, 0), (128 + by, 1)) and (code != -by or by is signal.SIGINT or said):
        raise RuntimeError(f"exit code {code}, {told} times told, after {len(out)} letters of stdout: {said}")
