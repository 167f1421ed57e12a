"""`mcdas-opt follow`: a parking manoeuvre driven with noise, dead time and lag, a judged stop at hand in every cycle."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from mcdas_opt.cli import completion, options
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, check_picture, console, facts_table, give, number
from mcdas_opt.errors import ParameterError

if TYPE_CHECKING:
    from mcdas_opt.parking.closed_loop.record import ParkingDrive
    from mcdas_opt.parking.closed_loop.sight import Visitor


def follow(
    case: Annotated[
        str,
        typer.Argument(
            metavar="CASE", help="What the car believes: a case (TOML), a TPCAP CSV, or a shipped case.", autocompletion=completion.cases
        ),
    ],
    planner: Annotated[str, typer.Option("--planner", help="nlp or search.")] = "nlp",
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the measurement noise.")] = 0,
    shorter: Annotated[float, typer.Option("--shorter", min=0.0, help="The slot is really shorter by so much [m].")] = 0.0,
    person: Annotated[
        list[str] | None, typer.Option("--person", help="x,y,from or x,y,from,until [m, s]: somebody stands there. May be repeated.")
    ] = None,
    vehicle: options.ParkingVehicle = None,
    clearance: options.Clearance = None,
    out: options.MovingPicture = None,
    as_json: JsonOption = False,
) -> None:
    """A parking manoeuvre in closed loop: noise, delay, a slot shorter than believed, people in the way.

    Example: mcdas-opt follow parallel --shorter 0.3 --seed 3 --out follow.gif
    """
    from mcdas_opt.parking.case_file import load_parking_case
    from mcdas_opt.parking.case_variants import shorter_slot
    from mcdas_opt.parking.closed_loop.follow import follow as run

    check_picture(out)
    problem = load_parking_case(case, vehicle=vehicle, clearance_m=clearance)
    truth = shorter_slot(problem, shorter) if shorter > 0.0 else problem
    visitors = tuple(_visitor(text) for text in person or ())
    with progress_bar("drive"):
        drive = run(problem, planner, seed, truth=truth, visitors=visitors)
    give(drive, lambda: _print(drive, f"{planner}, seed {seed}: {case}"), out, as_json=as_json)


def _print(drive: ParkingDrive, title: str) -> None:
    rows: list[tuple[str, object]] = [
        ("outcome", str(drive.outcome)),
        ("reason", drive.reason),
        ("duration", number(drive.duration_s, "s")),
        ("end pose off by", f"{100.0 * drive.end_position_error_m:.1f} cm, {1e3 * drive.end_heading_error_rad:.1f} mrad"),
        ("least clearance", number(drive.min_clearance_m, "m", 3)),
        ("tracking, at most", f"{100.0 * drive.max_across_m:.1f} cm across, {100.0 * drive.max_along_m:.1f} cm along"),
        ("stops", f"{drive.stops_judged} judged, {drive.stops_unsound} unsound, {drive.stops_driven} driven"),
        ("plans anew", drive.replans),
        *((f"{event.time_s:.1f} s", event.text) for event in drive.events),
    ]
    console().print(facts_table(title, rows))


def _visitor(text: str) -> Visitor:
    from mcdas_opt.parking.closed_loop.sight import Visitor

    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (3, 4):
        raise ParameterError("--person", text, "must be x,y,from or x,y,from,until: numbers in metres and seconds")
    visitor = Visitor(x_m=values[0], y_m=values[1], from_s=values[2])
    return replace(visitor, until_s=values[3]) if len(values) == 4 else visitor
