"""Who works on a trial: the signature in the study's file, the sign of life beside it, and how long others are waited for."""

from __future__ import annotations

import contextlib
import logging
import os
import platform
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from mcdas_opt.tuning.searchers import optuna_module

BEAT_S = 15.0  # between two signs of life
SILENT_S = 180.0  # who gave none for so long has died; one may wait for the file, too
_OWNER, _SEEN = "worker", "seen_s"
_LOOKS = 10  # at a trial that its worker has not yet signed
_PATIENT_S = 5.0  # before it is said whom one waits for
_LOG = logging.getLogger("mcdas_opt")


def sign(trial: Any) -> None:
    """Writes who works on a trial, and since when."""
    trial.set_user_attr(_OWNER, owner())
    trial.set_user_attr(_SEEN, time.time())


@contextlib.contextmanager
def heard_of(trial: Any) -> Iterator[None]:
    """Meanwhile the file says every `BEAT_S` that the trial's worker lives."""
    done, refused = threading.Event(), optuna_module().exceptions.OptunaError

    def beat() -> None:
        while not done.wait(BEAT_S):
            with contextlib.suppress(refused):  # a full disk, or taken over: who drives the trial meets it too
                trial.set_user_attr(_SEEN, time.time())
        trial.storage.remove_session()

    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def owner() -> str:
    """This process, so that nobody with its number but another start is taken for it."""
    return f"{platform.node()}:{os.getpid()}:{_started(os.getpid())}"


def _started(pid: int) -> str:
    """A process's start in ticks since boot, '' where there is no such process; without /proc only whether it is there."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[19]
    except (OSError, IndexError):
        pass
    if Path("/proc/self/stat").exists():
        return ""
    try:
        os.kill(pid, 0)
    except OSError:
        return ""
    return "running"


class Others:
    """Those who work on the same study, as one worker sees them."""

    def __init__(self) -> None:
        self._looks: dict[int, int] = {}
        self._heard: dict[int, tuple[float, float]] = {}  # by trial: its last sign of life, and since when it is the last
        self._waiting: dict[str, float] = {}  # by worker: since when
        self._told: set[str] = set()

    def left(self, trial: Any) -> bool:
        """Whether a running trial's worker has died: here its process is gone, of another computer nothing was heard for `SILENT_S`.

        A trial that is not yet signed is left alone for a few looks.
        """
        name: str | None = trial.user_attrs.get(_OWNER)
        if name is None:
            self._looks[trial.number] = self._looks.get(trial.number, 0) + 1
            return self._looks[trial.number] > _LOOKS
        node, pid, started = name.rsplit(":", 2)
        if node == platform.node():
            return _started(int(pid)) != started
        silent = self._silent_s(trial)
        if silent <= SILENT_S:
            return False
        _LOG.warning("trial %d counts as failed: nothing was heard of process %s on %s for %.0f s", trial.number, pid, node, silent)
        return True

    def are_waited_for(self, trials: Sequence[Any]) -> None:
        """Says of each of their workers, once, that it is waited for, where that takes a while."""
        now = time.monotonic()
        for trial in trials:
            name = trial.user_attrs.get(_OWNER)
            if name is None or name in self._told or now - self._waiting.setdefault(name, now) < _PATIENT_S:
                continue
            self._told.add(name)
            node, pid, _ = name.rsplit(":", 2)
            limit = "" if node == platform.node() else f"; it counts as failed when nothing was heard for {SILENT_S:.0f} s"
            _LOG.info("waiting for trial %d, in hand of process %s on %s%s", trial.number, pid, node, limit)

    def _silent_s(self, trial: Any) -> float:
        """By the clock that wrote, or as long as we have looked, whichever is more. An older file tells the trial's start alone."""
        last, now = float(trial.user_attrs.get(_SEEN, trial.datetime_start.timestamp())), time.monotonic()
        if trial.number not in self._heard or self._heard[trial.number][0] != last:
            self._heard[trial.number] = (last, now)
        return max(time.time() - last, now - self._heard[trial.number][1])
