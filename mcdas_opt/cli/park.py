"""`mcdas-opt park`: one parking plan, judged."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from mcdas_opt.cli import completion, options
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, check_picture, console, facts_table, give, headed_table, number
from mcdas_opt.errors import InputError, blaming

if TYPE_CHECKING:
    from mcdas_opt.domain.parking import Parking


def park(
    context: typer.Context,
    case: Annotated[
        str,
        typer.Argument(metavar="CASE", help="A case (TOML), a TPCAP CSV, or the name of a shipped case.", autocompletion=completion.cases),
    ],
    planner: Annotated[str, typer.Option("--planner", help="nlp, search, closed-form, closed-form-corrected, two-arc.")] = "nlp",
    vehicle: options.ParkingVehicle = None,
    clearance: options.Clearance = None,
    cost: Annotated[
        str, typer.Option("--cost", help="time, path, gear-changes, steering, clearance: what the program minimises.")
    ] = "time",
    guesses: Annotated[
        str, typer.Option("--guesses", help="Where it starts from: search, one-more, two-arc, sigmoid, continuation; with commas.")
    ] = "search,one-more",
    checks: Annotated[str, typer.Option("--checks", help="Form of the collision checks: half-planes or duals.")] = "half-planes",
    solver: Annotated[
        str, typer.Option("--solver", help="ipopt, or fatrop (half-planes, no cost of clearance), with IPOPT where it fails.")
    ] = "ipopt",
    budget: Annotated[float | None, typer.Option("--budget", min=0.0, help="Stop improving after so many seconds (an extra cap).")] = None,
    out: options.MovingPicture = None,
    as_json: JsonOption = False,
) -> None:
    """One parking plan, judged.

    Example: mcdas-opt park parallel --out park.gif
    """
    from mcdas_opt.parking.case_file import load_parking_case
    from mcdas_opt.parking.closed_form import CLOSED_FORMS
    from mcdas_opt.parking.cost import costs_named
    from mcdas_opt.parking.park import check_planner
    from mcdas_opt.parking.park import park as run
    from mcdas_opt.parking.program.exchange import ExchangeSettings
    from mcdas_opt.parking.settings import ParkSettings

    check_picture(out)
    if planner in CLOSED_FORMS:
        options.unread(context, ("cost", "guesses", "checks", "solver", "budget"), f"{planner}, which minimises nothing")
    elif planner == "search":
        options.unread(context, ("guesses", "checks", "solver"), "search, only by nlp")
    check_planner(planner)
    problem = load_parking_case(case, vehicle=vehicle, clearance_m=clearance)
    settings = ParkSettings(
        costs=costs_named(cost),
        guesses=tuple(name.strip() for name in guesses.split(",")),
        exchange=ExchangeSettings(form=checks, solver=solver),
        time_budget_s=budget,
    )
    if solver == "fatrop" and (checks == "duals" or settings.costs.clearance > 0.0):
        raise InputError("--solver", "", solver, "is asked neither with --checks duals nor with --cost clearance: ipopt is")
    with progress_bar("park"), blaming(case):
        answer = run(problem, planner, settings=settings)
    is_there = answer.trajectory is not None or (out is not None and out.suffix.lower() == ".html")
    give(answer, lambda: _print(answer, f"{planner}: {case}"), out if is_there else None, as_json=as_json)
    if out is not None and not is_there and not as_json:
        console().print("nothing to draw")


def _print(answer: Parking, title: str) -> None:
    screen, timing = console(), answer.timing_ms
    rows: list[tuple[str, object]] = [
        ("status", answer.status),
        ("reason", answer.reason),
        ("verdict", answer.verdict.reason),
        ("duration", number(answer.duration_s, "s")),
        ("path", number(answer.path_m, "m")),
        ("gear changes", "-" if answer.gear_changes is None else answer.gear_changes),
        ("least clearance", f"{number(answer.min_clearance_m, 'm', 3)}, {answer.asked_clearance_m:g} m asked"),
        ("time", f"{timing['total'] / 1e3:.2f} s, first answer after {timing['first'] / 1e3:.2f} s"),
        *(("note", note) for note in answer.notes),
    ]
    screen.print(facts_table(title, rows))
    table = headed_table("attempts", "attempt", "duration", "gear changes", "sound", "note")
    for attempt in answer.attempts:
        table.add_row(
            attempt.name, number(attempt.duration_s, "s"), str(attempt.gear_changes), "yes" if attempt.passed else "no", attempt.note
        )
    screen.print(table)
