"""Options that several commands have, and the refusal of those that a command would not read."""

from collections.abc import Container
from pathlib import Path
from typing import Annotated

import typer

from mcdas_opt.cli import completion
from mcdas_opt.errors import InputError

SceneOrSituation = Annotated[
    str, typer.Argument(metavar="SCENE|SITUATION.json", help="A scene, or a saved situation (JSON).", autocompletion=completion.scenes)
]
Resume = Annotated[bool, typer.Option("--resume", help="Go on where a run into the same folder was stopped.")]
Plant = Annotated[
    str, typer.Option("--plant", help="The car that is driven: kinematic, dynamic (with tyres), std, multi-body, or a plug-in.")
]
Controller = Annotated[
    str | None, typer.Option("--controller", help="Tracks plans: feed-forward, stanley, mpc-single-track, lqr-inverse-tyre, lqr-errors.")
]
MotionSensors = Annotated[
    str, typer.Option("--motion-sensors", help="How the host measures its own motion: ideal, or production (noise and offsets).")
]
NoiseSeed = Annotated[int | None, typer.Option("--seed", min=0, help="Of the measurement noise; default the scene's.")]
Dbc = Annotated[Path | None, typer.Option("--dbc", help="The DBC to decode by; default the shipped minimal one.")]
Road = Annotated[
    str | None,
    typer.Option("--road", help="A scene whose road and vehicle to drive; default one straight lane.", autocompletion=completion.scenes),
]
Scheduler = Annotated[str | None, typer.Option("--scheduler", help="Address of a Dask scheduler, instead of --workers.")]
ParkingVehicle = Annotated[str | None, typer.Option("--vehicle", help="Instead of the case's vehicle.", autocompletion=completion.vehicles)]
Clearance = Annotated[float | None, typer.Option("--clearance", min=0.0, help="Instead of the case's clearance [m].")]
Params = Annotated[Path | None, typer.Option("--params", help="Parameters to plan with: a TOML of `tune`.")]
MovingPicture = Annotated[Path | None, typer.Option("--out", help="Draw it: .png (a sheet), .gif, or .html (plays and scrubs).")]


def unread(context: typer.Context, names: Container[str | None], by: str) -> None:
    """Raises `InputError` that names the options, of these parameters, that were written, and who would not read them."""
    written = [
        option.opts[0]
        for option in context.command.params
        if option.name in names and getattr(context.get_parameter_source(str(option.name)), "name", "") == "COMMANDLINE"
    ]
    if written:
        raise InputError(", ".join(written), "", None, f"not read by {by}")


def only_one_sort_of_workers(context: typer.Context, scheduler: str | None) -> None:
    """Raises `InputError` where both `--workers` and `--scheduler` were written."""
    if scheduler is not None:
        unread(context, ("workers",), "--scheduler, which has workers of its own")
