"""What a study in traffic found, as tables that fit a terminal of 80 columns."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mcdas_opt.cli.screen import console, facts_table, headed_table, number

if TYPE_CHECKING:
    from rich.table import Table

    from mcdas_opt.tuning.tune_in_traffic import StudyReport


def print_study(found: StudyReport, storage: Path) -> None:
    screen = console()
    rows: list[tuple[str, object]] = [
        ("study", f"{found.method}: {found.evaluations} trials, {found.pruned} pruned, in {storage}"),
        ("chosen", f"trial {found.choice.trial.number} of a front of {len(found.choice.front)}"),
        *(("why", reason) for reason in found.reasons),
        ("verdict", found.reason),
    ]
    screen.print(facts_table(f"tuned on {found.spec.suite}", rows))
    are_tuned = found.values != found.defaults
    if not are_tuned:
        screen.print("The best trial is the defaults: there are no other values to set beside them.")
    screen.print(_scenes_apart(found, are_tuned))
    screen.print(_values(found, are_tuned))
    _say_gain(found, are_tuned)


def _say_gain(found: StudyReport, are_tuned: bool) -> None:
    """The last words: whether it helped, on scenes that were not used."""
    screen, gain = console(), found.gain
    collided = [("defaults", gain.defaults), *([("tuned", gain.tuned)] if are_tuned else [])]
    told = ", ".join(f"{who} {one.k} of {one.n} [{100.0 * one.interval[0]:.0f}, {100.0 * one.interval[1]:.0f}] %" for who, one in collided)
    screen.print(f"Test scenes, not tuned on, that collided, with 95 % intervals: {told}.")
    if are_tuned:
        screen.print(f"Their scores, tuned less defaults, scene by scene: {gain.score_difference:+.3g} in the mean.")
    screen.print(f"The tuned values are {gain.verdict}." if are_tuned else "Tuning changed nothing.")


def _scenes_apart(found: StudyReport, are_tuned: bool) -> Table:
    table = headed_table("scenes apart", "set", "values", "collided", "lateral", "jerk", "beside", "score")
    sets = found.guarded.sets
    seeds = ", ".join(f"{one.name} {one.seed}" for one in sets)
    table.caption = (
        "collided: of the scenes of the set; the rest are means over them. lateral: peak lateral acceleration [m/s^2]; jerk: peak "
        f"[m/s^3]; beside: driven beside a lane's middle [m]; score: the less the better. Seeds: {seeds}."
    )
    table.caption_justify = "left"
    for one in sets:
        for who, cost in (("defaults", one.default), ("tuned", one.tuned))[: 1 + are_tuned]:
            hits = f"{round(cost.collisions * cost.drives)}/{cost.drives}"
            figures = (f"{cost.peak_lateral_mps2:.2f}", f"{cost.peak_jerk_mps3:.1f}", f"{cost.manoeuvre_m:.1f}", f"{cost.score:.2f}")
            table.add_row(one.name, who, hits, *figures)
    return _uncut(table)


def _values(found: StudyReport, are_tuned: bool) -> Table:
    table = headed_table("values", "name", "default", *(["tuned"] if are_tuned else []), "importance")
    for name, value in found.values.items():
        tuned = [f"{value:.4g}"] if are_tuned else []
        table.add_row(name, f"{found.defaults[name]:.4g}", *tuned, number(found.importance.get(name), "", 3))
    return _uncut(table)


def _uncut(table: Table) -> Table:
    for column in table.columns:
        column.no_wrap = True
    return table
