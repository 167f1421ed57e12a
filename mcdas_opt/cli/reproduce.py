"""`mcdas-opt reproduce`: the paper's tables and figures."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Annotated

import typer

from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, console, emit


def reproduce(
    out: Annotated[Path, typer.Option("--out", help="Folder for Figures 7-12 (PNG); made if absent.")] = Path("reproduction"),
    as_json: JsonOption = False,
) -> None:
    """Every table and figure of the paper: published against computed, and the reading under which they agree.

    Example: mcdas-opt reproduce --out paper
    """
    from mcdas_opt.evaluation.reproduction import reproduce as run

    with progress_bar("the paper"):
        done = run(out)
    if as_json:
        emit(done.to_dict())
        return
    from rich import box
    from rich.table import Table

    table = Table(title="the paper, published against computed", title_justify="left", box=box.SIMPLE, pad_edge=False)
    table.add_column("", no_wrap=True)
    table.add_column("item", overflow="fold")
    for heading in ("published", "computed"):
        table.add_column(heading, justify="right", min_width=11, max_width=12)
    table.add_column("unit", no_wrap=True)
    table.add_column("note", justify="right", no_wrap=True)
    readings = list(dict.fromkeys(row.reading for row in done.rows))
    for row in done.rows:
        values = [f"{v:.7f}".rstrip("0").rstrip(".") if isinstance(v, float) else v or "-" for v in (row.published, row.computed)]
        table.add_row(row.agreement, row.item, *values, row.unit, str(1 + readings.index(row.reading)))
    screen = console()
    screen.print(table)
    counts = Counter(row.agreement for row in done.rows)
    counted = ", ".join(f"{word} {count}" for word, count in counts.items())
    screen.print(f"{counted} (equal: to half a unit of the last digit that the paper prints)", soft_wrap=True)
    notes = Table.grid(padding=(0, 2))
    for note, reading in enumerate(readings, start=1):
        notes.add_row(str(note), reading)
    screen.print(notes)
    for figure in done.figures:
        screen.print(f"drawn: {figure}")
