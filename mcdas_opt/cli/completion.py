"""What a shell offers behind a command: shipped names, registered planners, and files. An empty list offers nothing; nothing raises."""

from __future__ import annotations

from glob import escape, glob
from pathlib import Path


def scenes(incomplete: str) -> list[str]:
    return _shipped("scenes", incomplete, ".toml", ".xml")


def cases(incomplete: str) -> list[str]:
    return _shipped("cases", incomplete, ".toml", ".csv")


def vehicles(incomplete: str) -> list[str]:
    return _shipped("vehicles", incomplete, ".toml")


def suites(incomplete: str) -> list[str]:
    from mcdas_opt.evaluation.families import shipped_suites

    return _beginning(shipped_suites(), incomplete) + _files(incomplete, ".toml")


def planners(incomplete: str) -> list[str]:
    from mcdas_opt.planning.method import known_methods

    return _beginning(known_methods(), incomplete)


def formats(incomplete: str) -> list[str]:
    from mcdas_opt.interop.recordings.recording import READERS

    return _beginning(READERS.known(), incomplete)


def planner_lists(incomplete: str) -> list[str]:
    """Of names with commas between, the last is completed."""
    before, comma, last = incomplete.rpartition(",")
    return [f"{before}{comma}{name}" for name in planners(last)]


def _shipped(kind: str, incomplete: str, *suffixes: str) -> list[str]:
    from mcdas_opt.catalogue.data_files import shipped

    return _beginning(shipped(kind), incomplete) + _files(incomplete, *suffixes)


def _beginning(names: tuple[str, ...], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def _files(incomplete: str, *suffixes: str) -> list[str]:
    """Files of these kinds, and folders on the way to them."""
    found = (Path(path) for path in glob(f"{escape(incomplete)}*"))
    return sorted(f"{path}/" if path.is_dir() else str(path) for path in found if path.is_dir() or path.suffix in suffixes)
