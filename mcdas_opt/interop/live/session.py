"""A live session: buses opened, the loop run on them, everything closed again; and a log played onto them, a bench without a car."""

from __future__ import annotations

import contextlib
import gc
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from mcdas_opt.catalogue.data_files import find
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import positive, require_type, require_type_if_given
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.interop.esr_codec import EsrCodec
from mcdas_opt.interop.live.inbox import BusInbox, open_bus
from mcdas_opt.interop.live.loop import LiveLoop, LiveSettings, Publish
from mcdas_opt.interop.live.record import LiveSummary
from mcdas_opt.interop.live.watchdog import Watchdog
from mcdas_opt.interop.recordings.candump import read_candump
from mcdas_opt.interop.recordings.recording import Frame
from mcdas_opt.planning.planner import Planner

DEADLINE_SHARE = 0.9  # of the cycle: by then a plan is due
VIRTUAL = "virtual"
_CROWDS = (1, 3, 8)  # neighbours: each is a problem of its own size


def live(
    publish: Publish,
    *,
    bus: str = "can0",
    rear: str | None = None,
    interface: str = "socketcan",
    play: str | Path | None = None,
    dbc: str | Path | None = None,
    road: Scene | None = None,
    planner: str = "mpc",
    settings: LiveSettings | None = None,
    deadline_s: float | None = None,
    cycles: int | None = None,
    ended: Callable[[LiveSummary], None] | None = None,
) -> LiveSummary:
    """Reads a front ESR on `bus` and a rear one on `rear`, plans every `settings.cycle_s`, hands a line a cycle to `publish`.

    `play` is a candump log (a path or a shipped name) that is played onto virtual buses of the names `bus` and `rear`, which are then
    the log's own. `road` is a scene whose road and vehicle are used; default one straight lane, so that there is nowhere to steer out
    to. `deadline_s`: a plan is due so long after its cycle began (default 0.9 cycles); one that is not there when the next cycle is due is
    announced by a line "late". Runs for `cycles`, or until interrupted; `ended` gets the summary however it ended.

    Raises `SilentBusError` when the buses are or go silent, `InputError` for a bus that cannot be opened, a DBC without the messages or
    a log that is none, `ParameterError` for a setting out of range, `MissingExtraError` without python-can and cantools.
    """
    if not callable(publish):
        raise ParameterError("publish", publish, "must take a line: it is called once a cycle")
    require_type("bus", bus, str)
    require_type_if_given("rear", rear, str)
    require_type_if_given("play", play, str, Path)
    require_type_if_given("dbc", dbc, str, Path)
    require_type_if_given("road", road, Scene)
    require_type_if_given("settings", settings, LiveSettings)
    settings = settings or LiveSettings()
    if cycles is not None:
        positive("cycles", cycles)
    if bus == rear:
        raise InputError("--rear", "", rear, "is the front radar's bus")
    vehicle = "sedan" if road is None else road.vehicle
    brain = Planner(
        vehicle,
        planner,
        settings=Settings(cycle_s=settings.cycle_s),
        road=Road() if road is None else road.assumed_road,
        deadline_s=DEADLINE_SHARE * settings.cycle_s if deadline_s is None else deadline_s,
    )
    warm_up(brain)
    codec, sensor = EsrCodec(dbc=dbc), load_sensor("delphi_esr")
    radars = {bus: Sector.FRONT} if rear is None else {bus: Sector.FRONT, rear: Sector.REAR}
    frames = None if play is None else read_candump(find("logs", str(play), ".log")).frames
    opened = _open_all(radars, VIRTUAL if play is not None else interface)
    gc.collect()
    with contextlib.ExitStack() as stack:
        gc.freeze()  # else Python's collector looks through all that is loaded every few minutes, for 30 ms, within a cycle
        stack.callback(gc.unfreeze)
        inbox = stack.enter_context(BusInbox(opened))
        watchdog = Watchdog()
        stack.callback(watchdog.close)
        if frames is not None:
            player = LogPlayer(frames, _open_all(radars, VIRTUAL))
            stack.callback(player.close)
            player.start()
        loop = LiveLoop(inbox, radars, brain, publish, codec=codec, sensor=sensor, settings=settings, watchdog=watchdog)
        try:
            return loop.run(cycles)
        finally:
            if ended is not None:
                ended(loop.summary)


def _open_all(names: Iterable[str], interface: str) -> dict[str, Any]:
    """The buses by their names; where one cannot be opened, those that were are closed again."""
    opened = {}
    with contextlib.ExitStack() as stack:
        for name in names:
            opened[name] = open_bus(name, interface)
            stack.callback(opened[name].shutdown)
        stack.pop_all()
    return opened


def warm_up(planner: Planner) -> None:
    """Lets a planner build what it builds when first needed, for few and for many neighbours, and forget what it planned: seconds that
    a live cycle does not have."""
    for count in _CROWDS:
        tracks = tuple(Track(id=str(k), s_m=40.0 + 12.0 * k, d_m=0.0, speed_s_mps=10.0) for k in range(count))
        planner.plan(
            Situation(host=HostState(speed_mps=15.0), coverage=Coverage(), tracks=tracks, road=planner.road, vehicle=planner.vehicle.name)
        )
        planner.reset()


class LogPlayer:
    """Sends frames in a thread of its own, each at its own time after `start`; those of a channel without a bus are left out."""

    def __init__(self, frames: Sequence[Frame], buses: Mapping[str, Any]) -> None:
        """`buses`: the log's channel to an open `can.BusABC`; the player closes them at its end."""
        self._frames = [frame for frame in frames if frame.channel in buses]
        self._buses = dict(buses)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._play, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        for bus in self._buses.values():
            bus.shutdown()

    def _play(self) -> None:
        from can import Message

        began = time.monotonic()
        for frame in self._frames:
            left = frame.t_s - self._frames[0].t_s - (time.monotonic() - began)
            if left > 0.0 and self._ended.wait(left):
                return
            message = Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=frame.identifier > 0x7FF)
            self._buses[frame.channel].send(message)
