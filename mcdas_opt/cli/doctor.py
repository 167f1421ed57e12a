"""`mcdas-opt doctor`: what is installed and what works."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, console, emit, facts_table, headed_table

if TYPE_CHECKING:
    from rich.table import Table

    from mcdas_opt.evaluation.doctor import Check, Diagnosis


def doctor(as_json: JsonOption = False) -> None:
    """What is installed, which solvers and which compiler work, and a self-test. Exits 1 when something that is needed does not work.

    Example: mcdas-opt doctor --json
    """
    from mcdas_opt.evaluation.doctor import diagnose

    with progress_bar("self-test"):
        found = diagnose()
    if as_json:
        emit(found.to_dict())
    else:
        _print(found)
    if not found.well:
        raise typer.Exit(1)


def _print(found: Diagnosis) -> None:
    screen = console()
    screen.print(facts_table(f"mcdas-opt {found.version}", [("python", found.python)]))
    table = headed_table("packages", "package", "version", "for")
    for package in sorted(found.packages, key=lambda p: (p.extra, p.name)):
        missing = "missing" if not package.extra else f"pip install 'mcdas-opt[{package.extra}]'"
        table.add_row(package.name, package.version or missing, package.extra)
    screen.print(table)
    for title, checks in (("solvers and compiler", (*found.solvers, found.compiler)), ("self-test", found.self_test)):
        screen.print(_checks(title, checks))
    if found.form is not None:
        screen.print(f"{found.form.name}: a plan takes {found.form.plan_ms:.1f} ms here")
        if found.form.why:
            screen.print(f"slow: {found.form.why}")
    well = "all works, but slowly" if found.form is not None and found.form.why else "all is well"
    screen.print(well if found.well else "something that is needed does not work")


def _checks(title: str, checks: tuple[Check, ...]) -> Table:
    table = headed_table(title, "what", "works", "seen")
    for column in table.columns:
        column.overflow = "fold"
    for check in checks:
        table.add_row(check.name, "yes" if check.works else "no", check.detail)
    return table
