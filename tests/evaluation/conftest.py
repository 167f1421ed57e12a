"""What the benchmark's tests share: planners of a user, and suites that are driven in no time."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.evaluation.planners_of_a_user import install

SHORT = """
name = "short"
labels = false
duration_s = 0.4
host = { speed_mps = { low = 8.0, high = 20.0 } }
front = { gap_m = { low = 1.0, high = 30.0 }, slower_mps = { low = 0.0, high = 8.0 } }
rear = { gap_m = { low = 1.0, high = 20.0 }, faster_mps = { low = 0.0, high = 8.0 } }
"""


@pytest.fixture(scope="session")
def users_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    install(folder)
    return folder


@pytest.fixture
def users_planners(users_folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Planners `gentle`, `raises`, `hangs`, `dies` and `prints`, here and in child processes."""
    monkeypatch.syspath_prepend(str(users_folder))
    old = os.environ.get("PYTHONPATH")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(users_folder), *([old] if old else [])]))
    return users_folder


@pytest.fixture
def short_suite(tmp_path: Path) -> Path:
    """A family whose drives last 0.4 s; the oracle is not asked."""
    path = tmp_path / "short.toml"
    path.write_text(SHORT, encoding="utf-8")
    return path


@pytest.fixture
def labelled_suite(short_suite: Path, tmp_path: Path) -> Path:
    """The same, labelled."""
    path = tmp_path / "labelled.toml"
    path.write_text(short_suite.read_text(encoding="utf-8").replace("labels = false", "labels = true"), encoding="utf-8")
    return path
