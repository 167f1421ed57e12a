"""`mcdas-opt schema`: the keys of a file, for people and for editors."""

from __future__ import annotations

from itertools import groupby
from typing import Annotated

import typer

from mcdas_opt.cli.screen import JsonOption, console, emit, headed_table

_KINDS = "scene, vehicle, sensor, motion, parking-case, suite or family."


def schema(
    kind: Annotated[str, typer.Argument(metavar="KIND", help=_KINDS)],
    as_json: JsonOption = False,
) -> None:
    """Every key of a file with its unit, default and range; with --json its JSON Schema, by which editors complete and check TOML.

    Example: mcdas-opt schema scene --json > scene.schema.json
    """
    from mcdas_opt.evaluation.file_formats import keys
    from mcdas_opt.evaluation.file_formats import schema as schema_of

    if as_json:
        emit(schema_of(kind))
        return
    for table, rows in groupby(keys(kind), key=lambda key: key.table):
        shown = headed_table(table or kind, "key", "unit", "default", "allowed", "what")
        for key in rows:
            shown.add_row(key.name, key.unit, key.default, key.allowed or key.kind, key.about)
        console().print(shown)
