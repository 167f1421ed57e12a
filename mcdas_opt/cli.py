"""The commands: read, call one public function, print. Heavy packages load inside the command that needs them.

Exit 0: done (a refused plan or a collision is a result). 2: bad input, one message that names file, key, value and rule. 1: our fault.
With --json stdout holds one JSON document and nothing else; progress and tables go to stderr or are left out.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mcdas_opt.errors import InputError, McdasError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

app = typer.Typer(
    name="mcdas-opt",
    help="Planner for the car in the middle: front and rear vehicles as constraints, every plan judged before it leaves.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)

SceneArgument = Annotated[str, typer.Argument(metavar="SCENE", help="A scene file (TOML), or the name of a shipped scene.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout, nothing else.")]
PlannerOption = Annotated[str, typer.Option("--planner", help="mpc, closed-form, closed-form-corrected, or a registered method.")]


def main() -> None:
    """Entry point: turns our own errors into one line on stderr and the exit code of the contract."""
    try:
        app(standalone_mode=False)
    except McdasError as error:
        print(f"mcdas-opt: {error}", file=sys.stderr)  # noqa: T201
        sys.exit(2)
    except typer.Exit as stop:
        sys.exit(stop.exit_code)
    except typer.Abort:
        sys.exit(130)
    except Exception as error:
        show = getattr(error, "show", None)  # click's usage errors show themselves
        if show is not None:
            show()
            sys.exit(2)
        raise


def emit(document: dict[str, Any]) -> None:
    """One JSON document on stdout; refuses NaN rather than printing it."""
    sys.stdout.write(json.dumps(document, allow_nan=False) + "\n")


def console() -> Console:
    from rich.console import Console

    return Console(highlight=False)


def facts_table(title: str, rows: list[tuple[str, object]]) -> Table:
    """Two columns, name and value."""
    from rich.table import Table

    table = Table(title=title, show_header=False, title_justify="left")
    table.add_column(style="bold")
    table.add_column()
    for name, value in rows:
        table.add_row(name, str(value))
    return table


def number(value: float | None, unit: str = "", digits: int = 2) -> str:
    """A value for a table; a dash where there is none."""
    return "-" if value is None else f"{value:.{digits}f} {unit}".rstrip()


@app.callback(invoke_without_command=True)
def _root(version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False) -> None:
    if version:
        from mcdas_opt import __version__

        typer.echo(f"mcdas-opt {__version__}")
        raise typer.Exit


@app.command()
def plan(
    scene: Annotated[str, typer.Argument(metavar="SCENE|SITUATION.json", help="A scene, or a saved situation (JSON).")],
    planner: PlannerOption = "mpc",
    out: Annotated[Path | None, typer.Option("--out", help="Save the situation that was planned, as JSON.")] = None,
    as_json: JsonOption = False,
) -> None:
    """One plan at t = 0, judged."""
    from mcdas_opt.simulation.first_situation import plan_once, situation_of

    situation, vehicle = situation_of(scene)
    if out is not None:
        _write(out, situation.to_json())
    answer = plan_once(situation, vehicle, planner)
    if as_json:
        emit(answer.to_dict())
        return
    screen = console()
    rows: list[tuple[str, object]] = [
        ("mode", f"{answer.mode} {answer.side if answer.side != 'none' else ''}".strip()),
        ("status", answer.status),
        ("warning", "yes" if answer.warning else "no"),
        ("reason", answer.reason),
        ("verdict", answer.verdict.reason),
        ("prediction", answer.prediction),
        ("Table 1, literally", answer.literal_mode or "no mode"),
        ("time", f"{answer.timing_ms.total:.1f} ms ({answer.iterations} solver iterations)"),
    ]
    screen.print(facts_table(f"{planner}: {scene}", rows))
    from rich.table import Table

    table = Table(title="candidates", title_justify="left")
    for heading in ("way", "cost", "passed", "refusal"):
        table.add_column(heading)
    for candidate in answer.candidates:
        table.add_row(candidate.name, number(candidate.cost), "yes" if candidate.passed else "no", candidate.refusal)
    screen.print(table)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(path, "", None, f"cannot be written: {error.strerror}") from None
