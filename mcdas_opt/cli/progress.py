"""Bars for what takes longer than a moment, on stderr where that is a terminal and nobody asked for quiet."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from mcdas_opt.cli.log import is_quiet, tell

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

Advance = Callable[[int, int], None]
_LINE_S = 30.0  # between two lines of one stage


@contextmanager
def progress_bar(title: str) -> Iterator[Advance]:
    """One bar: call what this yields with (done, of); as long as nobody does, it only shows that something is done."""
    with _shown() as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)


@contextmanager
def stages() -> Iterator[Callable[[str, int, int], None]]:
    """A bar for each stage: call what this yields with (stage, done, of). Where stderr is no terminal, a line now and then."""
    if not sys.stderr.isatty():
        yield _Lines()
        return
    with _shown() as bar:
        tasks: dict[str, TaskID] = {}

        def advance(stage: str, done: int, of: int) -> None:
            if stage not in tasks:
                tasks[stage] = bar.add_task(stage, total=of, completed=done)
            bar.update(tasks[stage], completed=done, total=of)

        yield advance


def _shown() -> Progress:
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        ProgressColumn,
        Task,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class Rate(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(f"{task.speed:.2f}/s" if task.speed else "", style="progress.data.speed")

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Rate(), TimeElapsedColumn(), TimeRemainingColumn())
    hidden = is_quiet() or not sys.stderr.isatty()
    console = Console(stderr=True, quiet=hidden)  # rich 13 and 14 end a hidden bar with a line of their own
    return Progress(*columns, console=console, transient=True, disable=hidden)


class _Lines:
    """Progress for a log: stage, how many of how many, rate and remaining time."""

    def __init__(self) -> None:
        self._stage, self._first, self._started, self._told = "", 0, 0.0, 0.0

    def __call__(self, stage: str, done: int, of: int) -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._first, self._started, self._told = stage, done, now, now
        if done < of and now - self._told < _LINE_S:
            return
        self._told = now
        rate = (done - self._first) / max(now - self._started, 1e-9)
        left = f", {(of - done) / rate:.0f} s left" if rate > 0.0 and done < of else ""
        tell(f"{stage}: {done} of {of}, {rate:.2f}/s{left}")
