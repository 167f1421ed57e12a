"""A benchmark's run without its report, as a process to be killed: `python -m tests.evaluation.run_only SUITE FOLDER [SCHEDULER]`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from mcdas_opt.evaluation import provenance
from mcdas_opt.evaluation.benchmark import run
from mcdas_opt.evaluation.running.executor import Executor, ProcessPool
from mcdas_opt.evaluation.suites import expand


def tell(stage: str, done: int, of: int) -> None:
    """On stderr, for who waits until so many rows are written."""
    sys.stderr.write(f"{stage} {done}\n")  # a text stream that is flushed at every line


def main() -> None:
    suite, folder, *scheduler = sys.argv[1:]
    provenance.commit = lambda: "as it was"  # a commit made while this runs is not its matter
    executor: Executor = ProcessPool(1)
    if scheduler:
        from mcdas_opt.evaluation.running.dask_cluster import DaskCluster

        executor = DaskCluster(scheduler[0])
    results = run(expand(suite, 6, seed=2), ("gentle", "aeb"), Path(folder), executor, resume=True, progress=tell)
    executor.close()
    sys.stdout.write(json.dumps({"rows_hash": results.rows_hash, "rows": results.rows}))


if __name__ == "__main__":
    main()
