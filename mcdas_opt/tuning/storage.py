"""The file that a study lives in: whose it is, and taking over the trials whose worker died."""

from __future__ import annotations

import contextlib
import json
import os
import sqlite3
from functools import partial
from pathlib import Path
from typing import Any

from mcdas_opt.errors import InputError, reading
from mcdas_opt.tuning.searchers import optuna_module
from mcdas_opt.tuning.workers import Others

_MAGIC = b"SQLite format 3\x00"
_FINGERPRINT, _RETRIED = "mcdas_opt_fingerprint", "taken_over_from"
_LOCKED_S = 60  # a worker waits so long for the file while another writes


class _Connection(sqlite3.Connection):
    """Writes ahead to a log: a killed worker leaves a sound file, and a commit need not wait for the disk."""

    def __init__(self, *arguments: Any, **how: Any) -> None:
        super().__init__(*arguments, **how)
        self.execute("pragma journal_mode = wal")
        self.execute("pragma synchronous = normal")


def open_study(file: Path, name: str, fingerprint: dict[str, Any], directions: int) -> Any:
    """The study in `file`, made where there is none. Raises `InputError` for a file that holds anything else, and leaves it as it is."""
    _check(file, name, fingerprint)
    optuna = optuna_module()
    how = {"creator": partial(sqlite3.connect, file, timeout=_LOCKED_S, check_same_thread=False, factory=_Connection)}
    storage = optuna.storages.RDBStorage("sqlite:///study", engine_kwargs=how)  # by name: a URL takes "#", "%", "?", "{" in it for its own
    study = optuna.create_study(study_name=name, storage=storage, directions=["minimize"] * directions, load_if_exists=True)
    study.set_user_attr(_FINGERPRINT, fingerprint)
    return study


def _check(file: Path, name: str, fingerprint: dict[str, Any]) -> None:
    """Reads the file without opening it for writing."""
    if not os.path.exists(file):
        if not file.parent.is_dir():
            raise InputError(file, "", None, "its folder does not exist")
        return
    with reading(file):
        head = file.read_bytes()[:16]
    if not head:
        return
    if head != _MAGIC:
        raise InputError(file, "storage", None, "is not a study's storage (SQLite); nothing was changed")
    try:
        with contextlib.closing(sqlite3.connect(f"{file.absolute().as_uri()}?mode=ro", uri=True, timeout=_LOCKED_S)) as base:
            names = {row[0] for row in base.execute("select study_name from studies")}
            rows = base.execute("select value_json from study_user_attributes where key = ?", (_FINGERPRINT,)).fetchall()
    except sqlite3.Error as error:
        raise InputError(file, "storage", None, f"holds no study: {error}; nothing was changed") from None
    if names and names != {name}:
        raise InputError(
            file, "storage", ", ".join(sorted(names)), f"is the storage of another study, not of {name!r}; nothing was changed"
        )
    for (kept,) in rows:
        theirs = json.loads(kept)
        for key in sorted({*theirs, *fingerprint}):
            if theirs.get(key) != fingerprint.get(key):
                rule = f"is another study's: asked for is {fingerprint.get(key)!r}; nothing was changed"
                raise InputError(file, f"storage: {key}", theirs.get(key), rule)


def take_over(study: Any, numbers: int, others: Others) -> None:
    """Trials of workers that died end as failed, and their values, all `numbers` of them, are queued again, once."""
    state = optuna_module().trial.TrialState
    for trial in study.get_trials(deepcopy=False, states=(state.RUNNING,)):
        if not others.left(trial):
            continue
        try:
            study.tell(trial.number, state=state.FAIL)
        except (ValueError, RuntimeError):
            continue  # another worker was faster
        if len(trial.params) == numbers:
            study.enqueue_trial(trial.params, user_attrs={_RETRIED: trial.number})
