"""Every command, with wrong words, under streams that are full, closed or no longer read, in every locale, on a machine that gives too
little memory, too few descriptors, no file: an answer or one line."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np

from benchmarks.attack.tally import HANG_S, Tally
from mcdas_opt.errors import McdasError

_COMMANDS = (
    "plan SCENE", "plan SCENE --json", "simulate benign-following --planner closed-form-corrected --json", "escapes SCENE",
    "escapes SCENE --json",
    "park parallel --planner closed-form-corrected", "tune --json", "doctor --json", "--version", "--help", "verify --help",
    "live --play front_and_rear --rear can1 --cycles 3", "replay front_and_rear --format esr-candump --rear front_and_rear --json",
    "plan SCENE --planner WORD", "plan WORD", "simulate WORD", "park WORD", "verify WORD WORD", "live --play WORD",
    "replay WORD --format WORD",
    "tune --speed WORD", "benchmark WORD --out /nonexistent/WORD", "benchmark WORD", "escapes WORD", "export-c /nonexistent/WORD", "WORD",
    "plan SCENE --out /nonexistent/WORD.png", "plan SCENE --out WORD", "plan SCENE --params WORD", "live --speed 1e308", "live --rate nan",
)  # fmt: skip
_WORDS = ("nan", "-1", "1e308", "a\x1b[31m", "[/b]", "", "é\u202e", "/dev/null", "/", ".", "a" * 5000, "\udcff", "x\ny", "/etc/passwd")
_STREAMS = ("", "", ">/dev/full", ">&-", "<&-", "2>&-", "<&- 2>&-", "| true", "| head -c 10")
_LIMITS = ("", "", "", "ulimit -v 60000;", "ulimit -v 330000;", "ulimit -n 5;", "ulimit -n 8;", "ulimit -f 0;")  # KiB, descriptors, blocks
_BARE = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
_LOCALES: tuple[dict[str, str], ...] = ({}, {"PYTHONIOENCODING": "ascii"}, _BARE, {"TERM": "dumb"})
_PATIENCE_S = 120.0  # a command loads its modules first, and a machine is loaded
_OURS = (0, 1, 2)  # 1 alone where nobody reads


def attack(tally: Tally, count: int, seed: int) -> None:
    r = np.random.default_rng(seed)
    for _ in range(count):
        command, stream, locale, limit = (pool[int(r.integers(len(pool)))] for pool in (_COMMANDS, _STREAMS, _LOCALES, _LIMITS))
        words = [_worded(word, r) for word in command.split()]
        _one(tally, words, stream, locale, limit)


def _worded(word: str, r: np.random.Generator) -> str:
    return word.replace("SCENE", "sandwich-60-40").replace("WORD", _WORDS[int(r.integers(len(_WORDS)))])


def _one(tally: Tally, words: list[str], stream: str, locale: dict[str, str], limit: str) -> None:
    shown = f"{limit} {words} {stream} {locale}"
    script = f'{limit} "$0" -m mcdas_opt "$@" {stream}'
    try:
        done = subprocess.run(
            ["sh", "-c", script, sys.executable, *words], capture_output=True, timeout=_PATIENCE_S, env={**os.environ, **locale}, cwd="/"
        )
    except subprocess.TimeoutExpired:
        tally.tried += 1
        tally.hangs += 1
        tally.worst_s = max(tally.worst_s, _PATIENCE_S, HANG_S)
        tally.note(f"longer than {_PATIENCE_S:g} s", shown)
        return

    def judged() -> bool:
        if b"Traceback" in done.stderr or b"Exception ignored" in done.stderr:
            raise RuntimeError(done.stderr.decode(errors="replace").strip().splitlines()[-1])
        if done.returncode not in _OURS:
            raise RuntimeError(f"exit code {done.returncode}")
        if any(byte < 32 and byte != 10 for byte in done.stderr):
            raise RuntimeError("control characters on stderr")
        if done.returncode == 2:
            raise McdasError("refused")
        return True

    tally.ask(judged, lambda: shown)
