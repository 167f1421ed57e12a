"""The claims as data: what pages state, by which command it is measured, what it must keep, and what was measured last."""

from __future__ import annotations

import hashlib
import re
import shlex
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from mcdas_opt.catalogue.data_files import checked, read_toml
from mcdas_opt.catalogue.part import Part
from mcdas_opt.errors import InputError, ParameterError, nearest

FOLDER = Path(__file__).parent
ROOT = FOLDER.parent.parent
RECORDS = FOLDER / "records.toml"
SIZES = ("quick", "full")
_ABOVE_THE_PLANNER = ("cli", "plotting", "studio", "interop", "tuning", "evaluation")


class Goal(Part):
    at_most: float | None = None
    at_least: float | None = None
    equals: float | str | bool | None = None

    def kept_by(self, value: object) -> bool:
        """Whether the value keeps every part of the goal that is set; what is no number breaks a bound."""
        if self.equals is not None and value != self.equals:
            return False
        if self.at_most is None and self.at_least is None:
            return True
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            return False
        return (self.at_most is None or value <= self.at_most) and (self.at_least is None or value >= self.at_least)

    def __str__(self) -> str:
        named = (("=", self.equals), ("<=", self.at_most), (">=", self.at_least))
        return " and ".join(f"{sign} {value}" for sign, value in named if value is not None)


def _groups(pattern: str) -> tuple[str, ...]:
    """Names of the pattern's groups; none of what is no pattern."""
    try:
        return tuple(re.compile(pattern).groupindex)
    except re.error:
        return ()


class Claim(Part):
    """`value`, `of`, `low` and `high` are paths into the JSON that the command prints. `{folder}` in a command is one for its files.

    Of a command that prints words, `pattern` is a regular expression instead, with groups of these names.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9-]+$")]
    says: str
    size: Literal["quick", "full"]
    command: str
    value: str | None = None
    of: str | None = None
    low: str | None = None
    high: str | None = None
    pattern: str | None = None
    unit: str = ""
    goal: Goal

    @model_validator(mode="after")
    def _is_found_in_one_way(self) -> Self:
        if (self.value is None) == (self.pattern is None):
            raise ValueError("must have a value, the path into JSON, or a pattern of words")
        if self.pattern is not None and "value" not in _groups(self.pattern):
            raise ValueError("pattern: must be a regular expression with a group (?P<value>...)")
        return self


class ClaimsFile(Part):
    claim: list[Claim]


class Record(Part):
    """A measured value, and what it was measured on: the commit, the planner's digest, how fast the machine was, how long it took."""

    value: float | bool | str
    of: float | None = None
    low: float | None = None
    high: float | None = None
    date: str
    commit: str
    planner: str
    machine: float | None = None
    took_s: float | None = None

    @property
    def is_old(self) -> bool:
        """Measured on code whose planner has changed since."""
        return self.planner != planner_digest()


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    claim: Claim
    record: Record | None

    @property
    def is_fresh(self) -> bool:
        """Measured, and on this planner."""
        return self.record is not None and not self.record.is_old

    @property
    def shown(self) -> str:
        """The value as a page says it: k/n with its interval, or a number with its unit."""
        found = self.record
        if found is None:
            return "not measured"
        if isinstance(found.value, (bool, str)):
            return str(found.value).lower()
        text = f"{found.value:.4g}" if found.of is None else f"{found.value:.0f}/{found.of:.0f}"
        interval = "" if found.low is None or found.high is None else f" [{100.0 * found.low:.1f}, {100.0 * found.high:.1f} %]"
        return f"{text}{interval} {self.claim.unit}".rstrip()


def claims() -> dict[str, Claim]:
    """Every claim by its name. Raises `InputError` that names file, key, value and rule."""
    found: dict[str, Claim] = {}
    for path in sorted(FOLDER.glob("*.toml")):
        if path == RECORDS:
            continue
        for claim in checked(ClaimsFile, read_toml(path), path).claim:
            if claim.name in found:
                raise InputError(path, "claim.name", claim.name, "stands twice")
            words(claim, path)
            found[claim.name] = claim
    return found


def words(claim: Claim, file: object) -> list[str]:
    """The command, which is ours: `mcdas-opt COMMAND ... --json` or `python -m benchmarks.NAME ...`. Raises `InputError` otherwise."""
    try:
        found = shlex.split(claim.command)
    except ValueError as error:
        raise InputError(file, f"{claim.name}.command", claim.command, str(error)) from None
    if found[:1] == ["mcdas-opt"] and len(found) > 1:
        known = _commands()
        if found[1] not in known:
            raise InputError(file, f"{claim.name}.command", found[1], f"is no command; {nearest(found[1], known)}")
        return found
    if found[:2] == ["python", "-m"] and len(found) > 2 and found[2].startswith("benchmarks."):
        if not (ROOT / f"{found[2].replace('.', '/')}.py").is_file():
            raise InputError(file, f"{claim.name}.command", found[2], "no such benchmark")
        return found
    raise InputError(file, f"{claim.name}.command", claim.command, "must begin with mcdas-opt or python -m benchmarks.NAME")


@lru_cache(maxsize=1)
def _commands() -> frozenset[str]:
    """Of `mcdas-opt`."""
    import typer

    from mcdas_opt.cli.app import app

    return frozenset(typer.main.get_command(app).commands)


def records() -> dict[str, Record]:
    """What was measured last, by the claim's name."""
    document = read_toml(RECORDS) if RECORDS.is_file() else {}
    return {name: checked(Record, entry, RECORDS) for name, entry in document.items()}


def entry(name: str) -> Entry:
    """A claim and its record. Raises `ParameterError` for a name that is none."""
    known = claims()
    if name not in known:
        raise ParameterError("claim", name, nearest(name, known))
    return Entry(claim=known[name], record=records().get(name))


@lru_cache(maxsize=1)
def planner_digest() -> str:
    """Of every source of the package that a plan, a drive or a verdict depends on, and of its data."""
    found = hashlib.sha256()
    package = ROOT / "mcdas_opt"
    sources = [path for pattern in ("*.py", "*.c", "*.h") for path in package.rglob(pattern)]
    below = [path for path in sources if path.relative_to(package).parts[0] not in _ABOVE_THE_PLANNER]
    for path in sorted([*below, *(ROOT / "models").rglob("*.toml")]):
        found.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()[:16]


def value_at(document: Any, path: str) -> Any:
    """The value behind a dotted path; `rows[item=X].computed` is of the row whose `item` is X. Raises `LookupError` where it is not."""
    here = document
    for part in path.split("."):
        name, _, chosen = part.partition("[")
        try:
            here = here[name]
            if chosen == "#]":
                here = len(here)
            elif chosen:
                key, _, wanted = chosen.removesuffix("]").partition("=")
                here = next(row for row in here if str(row[key]) == wanted)
        except (KeyError, TypeError, StopIteration):
            raise LookupError(f"{path}: there is no {part}") from None
    return here


def values(claim: Claim, said: Any) -> dict[str, Any]:
    """`value`, and `of`, `low` and `high` where the claim has them, in what its command printed. Raises `LookupError`."""
    if claim.pattern is not None:
        return dict(_values_in(str(said), claim.pattern))
    paths = {"value": claim.value, "of": claim.of, "low": claim.low, "high": claim.high}
    return {name: value_at(said, path) for name, path in paths.items() if path is not None}


def _values_in(text: str, pattern: str) -> dict[str, float | str]:
    """What the pattern's groups hold in a text, numbers as numbers."""
    found = re.search(pattern, text)
    if found is None:
        raise LookupError(f"nothing printed fits {pattern!r}")
    return {name: _number(value) for name, value in found.groupdict().items() if value is not None}


def _number(text: str) -> float | str:
    try:
        return float(text.replace(",", ""))
    except ValueError:
        return text
