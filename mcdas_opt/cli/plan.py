"""`mcdas-opt plan`: one plan, judged."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mcdas_opt.cli import options
from mcdas_opt.cli.screen import (
    JsonOption,
    PlannerOption,
    check_picture,
    console,
    facts_table,
    give,
    headed_table,
    number,
    time_to_react_table,
)
from mcdas_opt.errors import InputError

if TYPE_CHECKING:
    from mcdas_opt.domain.plan import Plan

_NAMES = "slower, same, faster: its speed at the end; late: begins later; driven: the corrected closed form's own drive"


def plan(
    scene: options.SceneOrSituation,
    planner: PlannerOption = "mpc",
    params: options.Params = None,
    out: Annotated[Path | None, typer.Option("--out", help="Draw the plan (.png, .gif, .html), or save its situation (.json).")] = None,
    as_json: JsonOption = False,
) -> None:
    """One plan at t = 0, judged.

    Example: mcdas-opt plan sandwich-60-40 --out plan.png
    """
    from mcdas_opt.planning.parameter_files import planner_with
    from mcdas_opt.simulation.first_situation import save_situation, situation_of

    drawing = out is not None and out.suffix.lower() in (".png", ".gif", ".html")
    if out is not None and drawing:
        check_picture(out)
    elif out is not None and out.suffix.lower() != ".json":
        raise InputError(out, "", None, "must end in .png, .gif or .html (a picture) or in .json (the situation)")
    situation, vehicle = situation_of(scene)
    chosen = planner_with(params, vehicle, planner)
    written: list[Path] = []
    if out is not None and not drawing:
        beside = save_situation(situation, vehicle, out)
        written = [out] if beside is None else [out, beside]
    answer = chosen.plan(situation)
    give(answer, lambda: _print(answer, f"{planner}: {scene}"), out if drawing else None, as_json=as_json)
    if written and not as_json:
        console().print(f"written: {', '.join(map(str, written))}", soft_wrap=True)


def _print(answer: Plan, title: str) -> None:
    from mcdas_opt.plotting.words import alerted, ending, passed

    screen = console()
    rows: list[tuple[str, object]] = [
        ("mode", f"{answer.mode} {answer.side if answer.side != 'none' else ''}".strip()),
        ("status", answer.status),
        ("alert", alerted(answer)),
        ("reason", answer.reason),
        ("verdict", answer.verdict.reason),
        ("ends", ending(answer)),
        ("prediction", answer.prediction),
        ("doubts", "; ".join(doubt.words for doubt in answer.doubts) or "none"),
        ("Table 1, literally", answer.literal_mode or "no mode"),
        ("time", f"{answer.timing_ms.total:.1f} ms ({answer.iterations} solver iterations)"),
    ]
    screen.print(facts_table(title, rows))
    table = headed_table("candidates", "name", "cost", "passed", "refusal")
    for candidate in answer.candidates:
        table.add_row(candidate.name, number(candidate.cost), passed(candidate), candidate.refusal)
    screen.print(table)
    if any("-" in candidate.name for candidate in answer.candidates):
        screen.print(_NAMES, style="dim")
    if answer.escapes is not None:
        screen.print(time_to_react_table("time to react: how long each candidate stays open", answer.escapes))
