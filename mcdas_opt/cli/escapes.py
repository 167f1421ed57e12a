"""`mcdas-opt escapes`: which ways out are open, until when, and what closes them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mcdas_opt.cli.screen import JsonOption, console, emit, number


def escapes(
    scene: Annotated[str, typer.Argument(metavar="SCENE|SITUATION.json", help="A scene, or a saved situation (JSON).")],
    out: Annotated[Path | None, typer.Option("--out", help="Draw the timeline, or with --map the map (.png).")] = None,
    over: Annotated[bool, typer.Option("--map", help="Over front gaps and rear closing speeds instead, Table 1 drawn over it.")] = False,
    as_json: JsonOption = False,
) -> None:
    """The ways out at t = 0: open or closed, the last moment, what closes them, what they ask.

    Example: mcdas-opt escapes sandwich-60-40 --out escapes.png
    """
    from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
    from mcdas_opt.domain.settings import WarningSettings
    from mcdas_opt.planning.escape_map import escapes as escapes_of
    from mcdas_opt.simulation.first_situation import situation_of
    from mcdas_opt.situation.alert import alert

    if out is not None:
        from mcdas_opt.plotting.export import check_picture

        check_picture(out, (".png",))
    situation, vehicle = situation_of(scene)
    if over:
        from mcdas_opt.planning.escape_sweep import swept

        sweep = swept(situation, vehicle)
        if out is not None:
            from mcdas_opt.plotting.escape_map import escape_map
            from mcdas_opt.plotting.style import save_png

            save_png(escape_map(sweep), out)
        document = {"schema_version": SCHEMA_VERSION, **to_document(sweep)}
        if as_json:
            emit(document)
        else:
            screen = console()
            for name, moments in zip(("brake", "accelerate", "left", "right"), sweep.last_moment_s, strict=True):
                screen.print(f"{name}: open in {(moments == moments).mean():.0%} of {moments.size} states")
            screen.print(f"Table 1 has a row for {(sweep.table1_row > 0).mean():.0%} of them")
            if out is not None:
                screen.print(f"drawn: {out}")
        return
    found = escapes_of(situation, vehicle)
    told = alert(found, WarningSettings())
    if out is not None:
        from mcdas_opt.plotting.escape_timeline import escape_sheet
        from mcdas_opt.plotting.style import save_png

        save_png(escape_sheet(situation, vehicle, found, told), out)
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "escapes": found.to_dict(), "keeping_on_s": found.keeping_on_s, "alert": told.value})
        return
    from rich.table import Table

    table = Table(title=f"ways out: {scene}", title_justify="left")
    for heading in ("way", "open", "last moment", "comfortable until", "closed by", "asks now"):
        table.add_column(heading)
    for name, way in zip(("brake", "accelerate", "left", "right"), found.ways, strict=True):
        moments = number(way.last_moment_s, "s"), number(way.last_comfortable_s, "s")
        table.add_row(name, "yes" if way.open else "no", *moments, way.closed_by or "-", number(way.demand_mps2, "m/s²"))
    screen = console()
    screen.print(table)
    screen.print(f"keeping on ends in {number(found.keeping_on_s, 's')}; alert: {told}")
    if out is not None:
        screen.print(f"drawn: {out}")
