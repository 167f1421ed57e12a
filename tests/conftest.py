"""How hypothesis runs here: the same examples every time, no clock. `HYPOTHESIS_PROFILE=explore` draws fresh ones.

A shell that starts the tests in the background may have them ignore Ctrl-C, and so every process that they start: not here.

`MAY_BE_SKIPPED`, a regular expression, makes every skip whose reason it does not match a failure of the run: CI installs what tests need.
A checkout whose native library is not of its C texts builds it first.
Published data is not ours to ship: a test marked `published` is left out (deselected) where it is not, and another shows it on our own.
A test marked `repository` is of what lies in the repository alone (`.ci`, `models`), and left out elsewhere: the others also pass beside an
installed package (`.ci/wheel all`).
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import threading
from pathlib import Path

import pytest
from hypothesis import settings

from mcdas_opt.native import build, library

IS_REPOSITORY = (Path(__file__).parents[1] / ".ci").is_dir()

settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=500)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN and threading.current_thread() is threading.main_thread():
    signal.signal(signal.SIGINT, signal.default_int_handler)


class NothingSkipped:
    """Fails the run for tests that were skipped for any reason but the allowed ones, and names them at the end."""

    def __init__(self, allowed: str) -> None:
        self.allowed = re.compile(allowed)
        self.skipped: list[str] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._note(report)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        self._note(report)

    def _note(self, report: pytest.TestReport | pytest.CollectReport) -> None:
        reason = report.longrepr[2] if report.skipped and isinstance(report.longrepr, tuple) else ""
        if reason and not self.allowed.search(reason):
            self.skipped.append(f"{report.nodeid}: {reason}")

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if self.skipped and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if self.skipped:
            terminalreporter.section("skipped, but nothing may be", red=True)
            terminalreporter.write("".join(f"{line}\n" for line in self.skipped))


def _native_library() -> None:
    """Without a compiler there is none, and the tests that need it are skipped."""
    try:
        library.load()
    except library.NoLibraryError:
        if (build.TEXTS.parents[2] / "pyproject.toml").is_file():
            with contextlib.suppress(build.BuildError):
                build.build()


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "published(path): left out where that data is not; a test beside it has data of our own")
    config.addinivalue_line("markers", "repository: of what the repository alone holds (.ci, models); left out elsewhere")
    if not hasattr(config, "workerinput"):
        _native_library()
    allowed = os.environ.get("MAY_BE_SKIPPED")
    if allowed is not None and not hasattr(config, "workerinput"):
        config.pluginmanager.register(NothingSkipped(allowed), "nothing-skipped")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    absent = [
        item
        for item in items
        if any(not mark.args[0].exists() for mark in item.iter_markers("published"))
        or (not IS_REPOSITORY and item.get_closest_marker("repository") is not None)
    ]
    if absent:
        config.hook.pytest_deselected(items=absent)
        items[:] = [item for item in items if item not in absent]
