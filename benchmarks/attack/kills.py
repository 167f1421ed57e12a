"""A process that writes a journal, killed (SIGKILL) at any moment: every record that it had said was written is there."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.attack.tally import Tally
from mcdas_opt.evaluation.running.journal import Journal

_LATEST_S = 0.05
_WRITER = """
import sys
from pathlib import Path
from mcdas_opt.evaluation.running.journal import Journal
with Journal(Path(sys.argv[1])) as journal:
    k = len(journal.records)
    print("open", flush=True)
    while True:
        journal.append({"index": k, "text": "x" * (k % 700)})
        k += 1
        print(k, flush=True)
"""


def attack(tally: Tally, count: int, seed: int) -> None:
    """Twenty kills of the writers of one journal, then a new one."""
    r = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as name:
        for k in range(count):
            path = Path(name) / f"{k // 20}"
            said = _killed(path, float(r.uniform(0.0, _LATEST_S)))
            found = tally.ask(lambda path=path: _read(path), lambda said=said: f"killed after {said}")
            if found is None or len(found) < said or [record["index"] for record in found] != list(range(len(found))):
                tally.lost += 1
                tally.note("rows lost", f"{said} said, {None if found is None else len(found)} found")


def _killed(path: Path, after_s: float) -> int:
    """How many records it said were written, this time and before."""
    with subprocess.Popen([sys.executable, "-c", _WRITER, str(path)], stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        writer.stdout.readline()
        time.sleep(after_s)
        writer.kill()
        said = [line for line in writer.stdout.read().split("\n")[:-1] if line]  # the last may be cut off
    return int(said[-1]) if said else 0


def _read(path: Path) -> list[dict[str, object]]:
    with Journal(path) as journal:
        return journal.records
