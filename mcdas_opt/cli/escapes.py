"""`mcdas-opt escapes`: which candidates are open, until when, and what closes them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mcdas_opt.cli import options
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, console, emit, time_to_react_table
from mcdas_opt.cli.streams import said_before_it_is_written


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
    from mcdas_opt.domain.settings import WarningSettings
    from mcdas_opt.simulation.first_situation import situation_of
    from mcdas_opt.time_to_react.alert import alert
    from mcdas_opt.time_to_react.escapes import escapes as escapes_of

    if out is not None:
        from mcdas_opt.plotting.export import check_picture

        check_picture(out, (".png",))
    situation, vehicle = situation_of(scene)
    if over:
        from mcdas_opt.time_to_react.sweep import swept

        with progress_bar("map") as progress:
            sweep = swept(situation, vehicle, progress=progress)
        document = {"schema_version": SCHEMA_VERSION, **to_document(sweep)}
        with said_before_it_is_written():
            if as_json:
                emit(document)
            else:
                screen = console()
                for name, moments in zip(("brake", "accelerate", "left", "right"), sweep.last_moment_s, strict=True):
                    screen.print(f"{name}: open in {(moments == moments).mean():.0%} of {moments.size} states")
                screen.print(f"Table 1 has a row for {(sweep.table1_row > 0).mean():.0%} of them")
        if out is not None:
            from mcdas_opt.plotting.export import save_figure
            from mcdas_opt.plotting.time_to_react_map import time_to_react_map

            save_figure(time_to_react_map(sweep), out)
            if not as_json:
                console().print(f"drawn: {out}")
        return
    found = escapes_of(situation, vehicle)
    told = alert(found, WarningSettings())
    with said_before_it_is_written():
        if as_json:
            emit({"schema_version": SCHEMA_VERSION, "escapes": found.to_dict(), "keeping_on_s": found.keeping_on_s, "alert": told.value})
        else:
            screen = console()
            screen.print(time_to_react_table(f"time to react: {scene}", found))
            ends = "meets nobody within 10 s" if found.keeping_on_s is None else f"ends in {found.keeping_on_s:.2f} s"
            screen.print(f"keeping acceleration and steering {ends}; alert: {told}")
    if out is not None:
        from mcdas_opt.plotting.export import save_figure
        from mcdas_opt.plotting.time_to_react_timeline import time_to_react_sheet

        save_figure(time_to_react_sheet(found, told), out)
        if not as_json:
            console().print(f"drawn: {out}")
