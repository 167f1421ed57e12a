"""Rows of a benchmark: each is a scene that can be looked at again, with the planner that drove it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mcdas_opt.catalogue.data_files import read_text
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.suites import Suite, expand
from mcdas_opt.evaluation.table import CSV, read_table

_MOST_ROWS = 4000  # that are offered, the unsafe ones first


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """A table of rows, and the suite that its scenes come from, expanded anew."""

    name: str
    suite: Suite
    rows: tuple[dict[str, str], ...]

    def offered(self) -> list[list[str]]:
        """(number in the table, words) of the rows, those that did not end safely first."""
        order = sorted(range(len(self.rows)), key=lambda k: (self.rows[k].get("outcome") == "safe", k))
        return [[str(k), _words(self.rows[k])] for k in order[:_MOST_ROWS]]

    def row(self, name: str) -> tuple[int, Scene, str]:
        """Number, scene and planner of a row. Raises `InputError` for one that is not there."""
        number = int(name) if name.isdigit() else -1
        if not 0 <= number < len(self.rows):
            raise InputError(self.name, "row", name, f"must be in 0 .. {len(self.rows) - 1}")
        row = self.rows[number]
        index = int(row["index"]) if row.get("index", "").isdigit() else -1
        if not 0 <= index < len(self.suite.cases):
            raise InputError(self.name, f"row {number}: index", row.get("index"), "is no scene of the suite")
        return number, self.suite.cases[index].scene, row.get("planner", "")


def is_results(path: Path) -> bool:
    """True for a table as `benchmark` writes it: its first line tells where it comes from."""
    with path.open("rb") as file:
        return path.suffix.lower() == ".csv" and file.read(3) == b"# {"


def read(path: Path, name: str) -> Results:
    """The table, its scenes made again from suite and seed. Raises `InputError` where it is none, or the suite is another by now."""
    try:
        read_text(path)
        origin, rows = read_table(path)
        suite, scenes, seed = str(origin["suite"]), int(origin["scenes"]), int(origin["seed"])
    except (ValueError, KeyError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(name, "", None, f"is not a table of benchmark rows ({CSV})") from None
    if not rows:
        raise InputError(name, "", None, "holds no row")
    again = expand(suite, scenes, seed)
    if "suite_hash" in origin and again.hash != origin["suite_hash"]:
        raise InputError(name, "suite_hash", origin["suite_hash"], f"the suite {suite!r} of this version makes other scenes: {again.hash}")
    return Results(name=name, suite=again, rows=tuple(rows))


def _words(row: dict[str, str]) -> str:
    outcome = row.get("outcome") or row.get("ended", "")
    struck = f" with {row['collided_with']}" if row.get("collided_with") else ""
    return f"{row.get('scene', '')} · {row.get('planner', '')} · {outcome}{struck}"
