"""Drives on the benchmark's executors: child processes of this one, or whatever else does tasks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.evaluation.running.executor import Executor
from mcdas_opt.evaluation.running.journal import StoppedError
from mcdas_opt.evaluation.running.messages import Ended, Task
from mcdas_opt.tuning.traffic import DriveFigures, Drives, drive, figures_of

_LIMIT_S = 600.0


def on_executor(executor: Executor) -> Drives:
    """Drives side by side; what comes out is in the order of the scenes, so that it does not depend on who was faster.

    Raises `StoppedError` with the reason where a drive itself fails: that is a fault of ours, not a bad set of values.
    """

    def drives(scenes: Sequence[Scene], values: Mapping[str, float]) -> Iterator[DriveFigures]:
        tasks = [Task(drive, (scene, dict(values)), _LIMIT_S) for scene in scenes]
        for number, answer in sorted(executor.run(tasks), key=lambda one: one[0]):
            if answer.ended is not Ended.RETURNED:
                raise StoppedError(f"scene {scenes[number].name}: {answer.reason or answer.ended.value}")
            yield figures_of(answer.value)

    return drives
