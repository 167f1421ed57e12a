"""`mcdas-opt escapes`: which candidates are open, until when, and what closes them."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mcdas_opt.cli import options
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, check_picture, console, emit, time_to_react_table
from mcdas_opt.cli.streams import said_before_it_is_written

if TYPE_CHECKING:
    from rich.table import Table


def escapes(
    scene: options.SceneOrSituation,
    out: Annotated[Path | None, typer.Option("--out", help="Draw the timeline, or with --map the map (.png).")] = None,
    over: Annotated[bool, typer.Option("--map", help="Over front gaps and rear closing speeds instead, Table 1 drawn over it.")] = False,
    as_json: JsonOption = False,
) -> None:
    """The time to react at t = 0: each candidate open or closed, its last moment, what closes it, what it asks.

    Example: mcdas-opt escapes sandwich-60-40 --out escapes.png
    """
    from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
    from mcdas_opt.simulation.first_situation import situation_of

    check_picture(out, ".png")
    situation, vehicle = situation_of(scene)
    if over:
        from mcdas_opt.plotting.time_to_react_map import time_to_react_map
        from mcdas_opt.time_to_react.library import KINDS
        from mcdas_opt.time_to_react.sweep import swept

        with progress_bar("map") as progress:
            sweep = swept(situation, vehicle, progress=progress)
        document, draw = to_document(sweep), partial(time_to_react_map, sweep)
        shares = zip(KINDS, sweep.last_moment_s, strict=True)
        said: list[Table | str] = [f"{name}: open in {(one == one).mean():.0%} of {one.size} states" for name, one in shares]
        said.append(f"Table 1 has a row for {(sweep.table1_row > 0).mean():.0%} of them")
    else:
        from mcdas_opt.domain.settings import WarningSettings
        from mcdas_opt.plotting.time_to_react_timeline import time_to_react_sheet
        from mcdas_opt.time_to_react.alert import alert
        from mcdas_opt.time_to_react.escapes import escapes as escapes_of

        found = escapes_of(situation, vehicle)
        told = alert(found, WarningSettings())
        document = {"escapes": found.to_dict(), "keeping_on_s": found.keeping_on_s, "alert": told.value}
        draw = partial(time_to_react_sheet, found, told)
        ends = "meets nobody within 10 s" if found.keeping_on_s is None else f"ends in {found.keeping_on_s:.2f} s"
        said = [time_to_react_table(f"time to react: {scene}", found), f"keeping acceleration and steering {ends}; alert: {told}"]
    with said_before_it_is_written():
        if as_json:
            emit({"schema_version": SCHEMA_VERSION, **document})
        else:
            for one in said:
                console().print(one)
    if out is not None:
        from mcdas_opt.plotting.export import save_figure

        save_figure(draw(), out)
        if not as_json:
            console().print(f"drawn: {out}")
