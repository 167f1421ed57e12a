"""`mcdas-opt warmup`: what the first plan would wait for, ahead."""

from __future__ import annotations

from typing import Annotated

import typer

from mcdas_opt.cli import completion
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, console, emit, headed_table


def warmup(
    vehicle: Annotated[
        list[str] | None,
        typer.Option("--vehicle", help="A shipped vehicle or a file; may be repeated; default sedan.", autocompletion=completion.vehicles),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Loads the native library and poses a vehicle's problems once: which form runs, and what the first planner of a process waits for.

    Example: mcdas-opt warmup --vehicle sedan
    """
    from mcdas_opt.catalogue.vehicles import load_vehicle
    from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
    from mcdas_opt.planning.warm_up import warm_up

    cars = [load_vehicle(name) for name in vehicle or ("sedan",)]
    with progress_bar("load") as progress:
        done = []
        for number, car in enumerate(cars):
            progress(number, len(cars))
            done.append(warm_up(car))
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "vehicles": to_document(done)})
        return
    table = headed_table("ready", "vehicle", "solver", "took")
    for one in done:
        table.add_row(one.vehicle, one.solver, f"{one.seconds:.1f} s")
    console().print(table)
