"""The program: every command on one application, our own errors as one line on stderr, and the exit codes of the contract.

Exit 0: done (a refused plan or a collision is a result). 2: bad input, one message that names file, key, value and rule. 1: our fault.
With --json stdout holds one JSON document and nothing else; progress and tables go to stderr or are left out.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
import warnings
from collections import Counter
from typing import Annotated, Any, Protocol, runtime_checkable

import typer
from typer.core import TyperCommand

from mcdas_opt.cli.benchmark import benchmark
from mcdas_opt.cli.doctor import doctor
from mcdas_opt.cli.escapes import escapes
from mcdas_opt.cli.export_c import export_c
from mcdas_opt.cli.export_log import export_log
from mcdas_opt.cli.follow import follow
from mcdas_opt.cli.live import live
from mcdas_opt.cli.log import complain, hint, say
from mcdas_opt.cli.park import park
from mcdas_opt.cli.plan import plan
from mcdas_opt.cli.replay import replay
from mcdas_opt.cli.reproduce import reproduce
from mcdas_opt.cli.schema import schema
from mcdas_opt.cli.screen import CutShortError
from mcdas_opt.cli.shortage import lacking_at_start, shortage
from mcdas_opt.cli.simulate import simulate
from mcdas_opt.cli.stop import INTERRUPTED, Stopped, ended_as_interrupted, interrupted_between_imports
from mcdas_opt.cli.streams import prepare_streams, told_where_stdout_ends
from mcdas_opt.cli.studio import studio
from mcdas_opt.cli.sumo import sumo
from mcdas_opt.cli.tune import tune
from mcdas_opt.cli.verify import judge, verify
from mcdas_opt.cli.warmup import warmup
from mcdas_opt.errors import InputError, McdasError

_FAULT, _MISTAKE, _LOST = 1, 2, "what was not yet written is lost"


class OnceCommand(TyperCommand):
    """Raises `InputError` that names the option."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        given = self.make_parser(ctx).parse_args(list(args))[2]
        for parameter, count in Counter(given).items():
            if count > 1 and parameter.param_type_name == "option" and not getattr(parameter, "is_flag", False):
                raise InputError(parameter.opts[0], "", None, f"is given {count} times, and takes one value")
        return super().parse_args(ctx, args)


app = typer.Typer(
    name="mcdas-opt",
    help="Planner for the car in the middle: front and rear vehicles as constraints, every plan judged before it leaves.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)
driving = (plan, simulate, verify, escapes, replay, live, sumo)
parking = (park, follow)
studying = (reproduce, tune, benchmark, studio)
carrying = (export_c, export_log, doctor, warmup, schema)
for command in (*driving, *parking, *studying, *carrying):
    app.command(cls=OnceCommand)(command)
app.command("judge", hidden=True, cls=OnceCommand)(judge)  # the old name of verify


@runtime_checkable
class _UsageError(Protocol):
    """A wrong command line, wherever typer has its click from: it prints itself."""

    def show(self) -> None: ...


def run() -> None:
    """The commands: turns our own errors into one line on stderr and the exit code of the contract."""
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)  # by then everything is said and written: nothing to interrupt
    try:
        prepare_streams()
    except InputError as error:
        complain(str(error))
        sys.exit(_MISTAKE)
    os.environ.pop("MPLBACKEND", None)  # no command shows a figure, and a name that is none keeps matplotlib from being loaded
    if not os.environ.get("COLUMNS", "1").strip("0"):
        del os.environ["COLUMNS"]  # on a screen without columns nothing is printed
    if lacking := lacking_at_start():
        complain(f"the machine has too little left: {lacking}")
        sys.exit(_FAULT)
    warnings.showwarning = _warned
    try:
        with told_where_stdout_ends(), interrupted_between_imports(), ended_as_interrupted() as stopped:
            code = _run(stopped)
    except Exception as error:
        lacking = shortage(error)
        if not lacking:
            raise
        complain(f"the machine has too little left: {lacking}; {_LOST}")
        code = _FAULT
    if code:
        sys.exit(code)


def _warned(message: Warning | str, category: type[Warning], *where: object, **more: object) -> None:
    """A warning is one line, without the place in our code that gave it."""
    hint(f"warning: {message}")


def _run(stopped: Stopped) -> int:
    """The exit code; ends the process where it was interrupted."""
    try:
        code = app(standalone_mode=False)  # an interrupt comes back as the exit code 130
    except McdasError as error:
        complain(str(error))
        return _MISTAKE
    except CutShortError as stop:
        stopped.end(str(stop))
    except typer.Exit as stop:
        return stop.exit_code
    except (typer.Abort, KeyboardInterrupt):
        stopped.end(_LOST)
    except Exception as error:
        if isinstance(error, _UsageError):
            error.show()
            return _MISTAKE
        raise
    if code == INTERRUPTED:
        stopped.end(_LOST)
    return code if isinstance(code, int) else 0


@app.callback(invoke_without_command=True)
def _root(
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Errors alone on stderr: no hints, no progress.")] = False,
    version: Annotated[bool, typer.Option("--version", help="Print versions, of what this stands on too, and exit.")] = False,
) -> None:
    say(quiet)
    if version:
        from mcdas_opt import __version__
        from mcdas_opt.evaluation.doctor import packages

        typer.echo(f"mcdas-opt {__version__}")
        for package in packages():
            if not package.extra:
                typer.echo(f"  {package.name} {package.version or 'missing'}")
        raise typer.Exit
