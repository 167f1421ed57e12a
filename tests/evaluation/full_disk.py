"""A disk that fills up under a journal."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest


def fill_up(monkeypatch: pytest.MonkeyPatch, pages: int) -> None:
    """From now on each journal that is opened finds room for so many pages."""
    connect = sqlite3.connect

    def small(path: Path, *, timeout: float, isolation_level: None) -> sqlite3.Connection:
        base = connect(path, timeout=timeout, isolation_level=isolation_level)
        base.execute(f"pragma max_page_count = {pages}")
        return base

    monkeypatch.setattr(sqlite3, "connect", small)
