"""Where a result comes from: hashes, versions, commit."""

from __future__ import annotations

import hashlib
import json
import platform
import subprocess
from collections.abc import Iterable
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import mcdas_opt

_PACKAGES = ("numpy", "scipy", "casadi", "osqp", "filterpy", "control")


def digest(documents: Iterable[Any]) -> str:
    """SHA-256 over JSON documents in their order, keys sorted."""
    found = hashlib.sha256()
    for document in documents:
        found.update(json.dumps(document, sort_keys=True, allow_nan=False, separators=(",", ":")).encode() + b"\n")
    return found.hexdigest()


def versions() -> dict[str, str]:
    """Of Python, of this package and of what it computes with."""
    found = {"python": platform.python_version(), "mcdas-opt": mcdas_opt.__version__}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


@lru_cache(maxsize=1)
def commit() -> str:
    """The checkout's commit, with `+changed` where the package or its data differ from it; empty where there is no checkout."""
    folder = Path(mcdas_opt.__file__).resolve().parent.parent
    if not (folder / ".git").exists():
        return ""
    try:
        head = _git(folder, "rev-parse", "--short=12", "HEAD")
        changed = _git(folder, "status", "--porcelain", "--", "mcdas_opt", "models", "benchmarks/suites")
    except (OSError, subprocess.SubprocessError):
        return ""
    return f"{head}+changed" if changed else head


def _git(folder: Path, *arguments: str) -> str:
    done = subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, text=True, check=True, timeout=20)
    return done.stdout.strip()
