"""A claim measured: its command run once, its value found in what it prints."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from datetime import UTC, datetime
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.claims.book import RECORDS, ROOT, Claim, Record, planner_digest, values, words
from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.errors import writing
from mcdas_opt.evaluation.provenance import commit

_LIMIT_S = {"quick": 600.0, "full": 48 * 3600.0}
_USUAL_MS = 5.0  # of the machine that the first records come from


class NotMeasuredError(Exception):
    """The command failed, or said nothing of the value."""


class Measuring:
    """Runs every command once, however many claims stand on it."""

    def __init__(self) -> None:
        self._said: dict[str, tuple[Any, float]] = {}
        self._machine = machine()

    def record(self, claim: Claim) -> Record:
        document, took_s = self._document(claim)
        try:
            found = values(claim, document)
        except LookupError as error:
            raise NotMeasuredError(str(error)) from None
        value = found.get("value")
        if value is None or isinstance(value, (list, dict)):
            raise NotMeasuredError(f"{claim.value}: is {type(value).__name__}, not a value")
        now = datetime.now(UTC).strftime("%Y-%m-%d")
        origin = {"date": now, "commit": commit(), "planner": planner_digest()}
        return Record(**found, **origin, machine=round(self._machine, 2), took_s=round(took_s, 1))

    def _document(self, claim: Claim) -> tuple[Any, float]:
        """What the command printed, and how long it took [s]."""
        if claim.command not in self._said:
            began = time.perf_counter()
            document = _run(claim)
            self._said[claim.command] = document, time.perf_counter() - began
        return self._said[claim.command]


def _run(claim: Claim) -> Any:
    with TemporaryDirectory() as folder:
        first, *rest = [word.replace("{folder}", folder) for word in words(claim, claim.name)]
        command = [sys.executable, *(["-m", "mcdas_opt"] if first == "mcdas-opt" else []), *rest]
        try:
            done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=_LIMIT_S[claim.size], check=False)
        except subprocess.TimeoutExpired:
            raise NotMeasuredError(f"took longer than {_LIMIT_S[claim.size]:g} s") from None
    if done.returncode:
        said = done.stderr.strip().splitlines() or ["nothing said"]
        raise NotMeasuredError(f"exit {done.returncode}: {said[-1]}")
    if claim.pattern is not None:
        return done.stdout
    try:
        return json.loads(done.stdout)
    except ValueError:
        raise NotMeasuredError("what it printed is no JSON document") from None


def machine() -> float:
    """How many times as long as on the first records' machine a fixed piece of arithmetic takes here, now."""
    matrix = np.random.default_rng(0).normal(size=(160, 160)) + 160.0 * np.eye(160)
    took = []
    for _ in range(7):
        started = time.perf_counter()
        for _ in range(8):
            np.linalg.inv(matrix)
        took.append(1e3 * (time.perf_counter() - started))
    return median(took) / _USUAL_MS


def write(records: dict[str, Record]) -> None:
    """All records, by name."""
    with writing(RECORDS):
        RECORDS.write_text(toml_text({name: records[name].model_dump() for name in sorted(records)}), "utf-8")
