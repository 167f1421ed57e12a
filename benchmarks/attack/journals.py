"""Journals torn and damaged anywhere: whole records, a refusal that leaves the file as it is, and never a record that was not written."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.attack.tally import Tally
from mcdas_opt.evaluation.running.journal import Journal

_RECORDS = 12


def attack(tally: Tally, count: int, seed: int) -> None:
    r = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        records = _written(folder / "sound")
        for _ in range(count):
            path = folder / "journal"
            log = Path(f"{path}-wal")
            for file in (log, Path(f"{path}-shm")):
                file.unlink(missing_ok=True)
            closed = r.random() < 0.5
            shutil.copy(folder / ("sound" if closed else "killed"), path)
            if not closed:
                shutil.copy(folder / "killed-wal", log)
            what = _damage(path if closed else log, r)
            found = tally.ask(lambda path=path: _read(path), lambda what=what: what)
            if found is not None and found != records[: len(found)]:
                tally.lost += 1
                tally.note("records that were not written", what)
            if "cut" in what and "-wal" in what and found is None:
                tally.lost += 1
                tally.note("a log that was cut off lost what came before", what)


def _written(path: Path) -> list[dict[str, Any]]:
    """Writes a journal, and keeps beside it what a kill would have left."""
    records = [{"index": k, "text": "x" * (150 * k), "value": 0.1 * k} for k in range(_RECORDS)]
    with Journal(path) as journal:
        for record in records:
            journal.append(record)
        for suffix in ("", "-wal"):
            shutil.copy(Path(f"{path}{suffix}"), path.with_name(f"killed{suffix}"))
    return records


def _damage(path: Path, r: np.random.Generator) -> str:
    data = bytearray(path.read_bytes())
    if r.random() < 0.5:
        size = int(r.integers(len(data) + 1))
        path.write_bytes(data[:size])
        return f"{path.name} cut to {size} of {len(data)} bytes"
    places = [int(r.integers(len(data))) for _ in range(int(r.integers(1, 4)))]
    for place in places:
        data[place] ^= 1 << int(r.integers(8))
    path.write_bytes(data)
    return f"{path.name} with flipped bits in bytes {places}"


def _read(path: Path) -> list[dict[str, Any]]:
    with Journal(path) as journal:
        return journal.records
