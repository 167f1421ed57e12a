"""`mcdas-opt live`: CAN in, plans out."""

from __future__ import annotations

import contextlib
import json
import sys
from typing import TYPE_CHECKING, Annotated

import typer

from mcdas_opt.cli import options, speeds
from mcdas_opt.cli.screen import PlannerOption, emit, leaving
from mcdas_opt.errors import InputError

if TYPE_CHECKING:
    from mcdas_opt.interop.live.record import LiveSummary


def live(
    context: typer.Context,
    bus: Annotated[str, typer.Option("--bus", help="Channel of the front radar (an ESR).")] = "can0",
    rear: Annotated[str | None, typer.Option("--rear", help="Channel of the rear radar, where there is one.")] = None,
    interface: Annotated[str, typer.Option("--interface", help="python-can's: socketcan, pcan, kvaser, udp_multicast ...")] = "socketcan",
    play: Annotated[str | None, typer.Option("--play", help="No car: play a candump log, or a shipped one (front_and_rear).")] = None,
    dbc: options.Dbc = None,
    road: options.Road = None,
    speed: speeds.HostSpeed = None,
    rate: Annotated[float, typer.Option("--rate", min=1.0, max=100.0, help="Cycles a second [Hz].")] = 20.0,
    silence: Annotated[float, typer.Option("--silence", help="Give up when nothing was heard for so long [s].")] = 1.0,
    deadline: Annotated[float | None, typer.Option("--deadline", help="A plan is due so many ms into a cycle; default 0.9 cycles.")] = None,
    cycles: Annotated[int | None, typer.Option("--cycles", help="Stop after so many; default at Ctrl-C.")] = None,
    trajectories: Annotated[bool, typer.Option("--trajectories", help="Print the plan's whole trajectory in every line.")] = False,
    planner: PlannerOption = "mpc",
    as_json: Annotated[bool, typer.Option("--json", help="As always here: a line of JSON a cycle on stdout, nothing else.")] = False,
) -> None:
    """ESR frames from a CAN bus in, a judged plan a cycle out: a line of JSON each, the counts at the end on stderr.

    Example without a car: mcdas-opt live --play front_and_rear --rear can1 --cycles 100
    """
    del as_json  # there is no other form
    from mcdas_opt.catalogue.scenes import load_scene
    from mcdas_opt.interop.live.loop import LiveSettings
    from mcdas_opt.interop.live.record import Line
    from mcdas_opt.interop.live.session import live as run

    def publish(line: Line) -> None:
        emit(line.to_dict())
        sys.stdout.flush()

    if play is not None:
        options.unread(context, ("interface",), "--play, which has buses of its own")
    try:
        settings = LiveSettings(cycle_s=1.0 / rate, silence_s=silence, speed_mps=speed, trajectories=trajectories)
        scene = None if road is None else load_scene(road)
        with leaving("what was printed stands") if cycles is not None else contextlib.suppress(KeyboardInterrupt):
            run(
                publish, bus=bus, rear=rear, interface=interface, play=play, dbc=dbc, road=scene, planner=planner, settings=settings,
                deadline_s=None if deadline is None else 1e-3 * deadline, cycles=cycles, ended=_say,
            )  # fmt: skip
    except BrokenPipeError:
        raise InputError("stdout", "", None, "was closed by whoever read it") from None


def _say(summary: LiveSummary) -> None:
    sys.stderr.write(json.dumps(summary.to_dict(), allow_nan=False) + "\n")
