"""What the commands share: their common options, tables, progress on stderr, and one JSON document on stdout."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mcdas_opt.cli import completion
from mcdas_opt.cli.streams import said_before_it_is_written
from mcdas_opt.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from mcdas_opt.domain.escapes import Escapes
    from mcdas_opt.domain.result import Result
    from mcdas_opt.domain.verdict import Verdict

SceneArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENE",
        help="A scene file (TOML, or a CommonRoad scenario), or the name of a shipped scene.",
        autocompletion=completion.scenes,
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout, nothing else.")]
PlannerOption = Annotated[
    str, typer.Option("--planner", help="mpc, closed-form, -corrected, -tuned, or a registered method.", autocompletion=completion.planners)
]


def emit(document: dict[str, Any]) -> None:
    """One JSON document on stdout; refuses NaN rather than printing it."""
    sys.stdout.write(json.dumps(document, allow_nan=False) + "\n")


def console() -> Console:
    """The screen. Names of files and scenes are data: what a terminal would obey in them is written out."""
    from mcdas_opt.cli.plain_console import PlainConsole

    return PlainConsole(highlight=False, markup=False)


def check_picture(out: Path | None, *suffixes: str) -> None:
    """Refuses a picture of another kind before anything is computed; without suffixes it may move or play."""
    if out is not None:
        from mcdas_opt.plotting import export

        export.check_picture(out, suffixes or export.MOVING)


def check_spared(out: Path | None, *read: str | Path | None) -> None:
    """Refuses to write over what is read."""
    for one in read:
        if out is not None and one is not None and os.path.exists(one) and out.exists() and out.samefile(one):
            raise InputError("--out", "", str(out), "would be written over, and is read")


def give(answer: Result, show: Callable[[], None], out: Path | None, *, as_json: bool) -> None:
    """An answer as its document, or as `show` prints it. Then its picture, if one is asked for: what was computed has been said by then.
    It is drawn where nobody reads stdout to its end, too."""
    with said_before_it_is_written():
        if as_json:
            emit(answer.to_dict())
        else:
            show()
    if out is not None:
        from mcdas_opt.plotting.export import save_picture

        save_picture(answer, out)
        if not as_json:
            console().print(f"drawn: {out}")


def headed_table(title: str, *headings: str) -> Table:
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    for heading in headings:
        table.add_column(heading)
    return table


def facts_table(title: str, rows: list[tuple[str, object]]) -> Table:
    """Two columns, name and value."""
    from rich.table import Table

    table = Table(title=title, show_header=False, title_justify="left")
    table.add_column(style="bold")
    table.add_column()
    for name, value in rows:
        table.add_row(name, str(value))
    return table


def number(value: float | None, unit: str = "", digits: int = 2) -> str:
    """A value for a table; a dash where there is none."""
    return "-" if value is None else f"{value:.{digits}f} {unit}".rstrip()


def time_to_react_table(title: str, escapes: Escapes) -> Table:
    """The four candidates: open or closed, until when, what closes them, what they ask."""
    from mcdas_opt.time_to_react.library import KINDS

    table = headed_table(title, "candidate", "open", "last moment", "comfortable until", "closed by", "asks now")
    for name, candidate in zip(KINDS, escapes.candidates, strict=True):
        moments = (_moment(moment) for moment in (candidate.last_moment_s, candidate.last_comfortable_s))
        table.add_row(name, "yes" if candidate.open else "no", *moments, candidate.closed_by or "-", number(candidate.demand_mps2, "m/s²"))
    return table


def _moment(value_s: float | None) -> str:
    """Last moments are sought up to 10 s."""
    return number(value_s, "s") if value_s is None or value_s < 10.0 else "10 s or later"


def print_violations(screen: Console, verdict: Verdict) -> None:
    if not verdict.violations:
        return
    table = headed_table("violations", "rule", "at", "value", "limit", "unit")
    for found in verdict.violations:
        table.add_row(found.name, f"{found.t_s:.2f} s", f"{found.value:.4g}", f"{found.limit:.4g}", found.unit)
    screen.print(table)


class CutShortError(Exception):
    """Ctrl-C; says what it leaves."""


@contextmanager
def leaving(what: str) -> Iterator[None]:
    """Turns Ctrl-C into `CutShortError`, which tells the user `what` it leaves."""
    try:
        yield
    except KeyboardInterrupt:
        raise CutShortError(what) from None
