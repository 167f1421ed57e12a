"""Parsers of files, attacked by what their own branches show: coverage-guided, by atheris (`pip install atheris`, of no extra).

    python -m benchmarks.attack.guided scene|candump|commonroad|journal [--minutes 10] [--corpus DIR]

Begins with shipped files, and with those in DIR: of CommonRoad none are shipped. An exception that is not ours, or a call of over 2 s of
the processor's time, ends it with the input that showed it (`crash-...` in the working folder): minimise it, and make it a test.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import logging
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

KINDS = ("scene", "candump", "commonroad", "journal")
_LONGEST = 20_000  # bytes of an input
_HANG_S = 2.0  # as in `tally`, which would import the package before it is instrumented


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--corpus", type=Path, help="where inputs are kept that reach something new; else nowhere")
    asked = parser.parse_args()
    try:
        import atheris
    except ImportError:
        raise SystemExit("this needs the package 'atheris': pip install atheris") from None
    with atheris.instrument_imports(include=["mcdas_opt", "tomllib", "commonroad"]):
        read, sound = reader(asked.kind)
    logging.disable()
    with tempfile.TemporaryDirectory() as name:
        corpus = asked.corpus or Path(name) / "corpus"
        corpus.mkdir(parents=True, exist_ok=True)
        for k, data in enumerate(sound):
            (corpus / f"sound-{k}").write_bytes(data[:_LONGEST])
        file = Path(name) / "input"
        limits = [f"-max_total_time={round(60.0 * asked.minutes)}", f"-max_len={_LONGEST}", "-timeout=60", "-rss_limit_mb=4096"]
        atheris.Setup([sys.argv[0], *limits, str(corpus)], lambda data: _one(read, file, data))
        atheris.Fuzz()


def _one(read: Callable[[Path], object], file: Path, data: bytes) -> None:
    from mcdas_opt.errors import McdasError

    file.write_bytes(data)
    began = time.process_time()
    with contextlib.suppress(McdasError), contextlib.redirect_stderr(io.StringIO()):
        read(file)
    took = time.process_time() - began
    if took > _HANG_S:
        raise RuntimeError(f"{took:.1f} s")


def reader(kind: str) -> tuple[Callable[[Path], object], list[bytes]]:
    """What reads such a file, and sound ones."""
    from mcdas_opt.catalogue.data_files import models_folder

    def shipped(folder: str, suffix: str) -> list[bytes]:
        return [path.read_bytes() for path in sorted((models_folder() / folder).glob(f"*{suffix}"))]

    if kind == "scene":
        from mcdas_opt.catalogue.scenes import load_scene

        return lambda file: load_scene(file.rename(file.with_suffix(".toml"))), shipped("scenes", ".toml")
    if kind == "candump":
        from mcdas_opt.interop.recordings.candump import read_candump

        return read_candump, shipped("logs", ".log")
    if kind == "commonroad":
        from mcdas_opt.interop.commonroad.scenario import read_scenario

        return lambda file: read_scenario(file.rename(file.with_suffix(".xml"))), []
    from mcdas_opt.evaluation.running.journal import Journal

    def records(file: Path) -> list[dict[str, Any]]:
        for beside in ("-wal", "-shm"):
            Path(f"{file}{beside}").unlink(missing_ok=True)
        with Journal(file) as journal:
            return journal.records

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "journal"
        with Journal(path) as journal:
            for k in range(5):
                journal.append({"index": k, "text": "x" * k})
        return records, [path.read_bytes()]


if __name__ == "__main__":
    main()
