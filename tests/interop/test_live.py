"""The live door: frames on virtual buses or a clock of its own, drops and late cycles counted, a bus that falls silent."""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.cli import main
from mcdas_opt.domain.doubt import Doubt, DoubtKind
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Alert, Sector
from mcdas_opt.errors import InputError, MeasurementWarning, ParameterError
from mcdas_opt.interop.esr_can import write_esr
from mcdas_opt.interop.esr_codec import EsrCodec
from mcdas_opt.interop.host_motion import LiveHost
from mcdas_opt.interop.live import loop as loop_module
from mcdas_opt.interop.live import session
from mcdas_opt.interop.live.assembler import Drops, ScanAssembler
from mcdas_opt.interop.live.inbox import Arrival, BusInbox, open_bus
from mcdas_opt.interop.live.loop import LiveLoop, LiveSettings
from mcdas_opt.interop.live.record import Line
from mcdas_opt.interop.live.session import live
from mcdas_opt.interop.live.silence import SilentBusError
from mcdas_opt.interop.live.watchdog import Watchdog
from mcdas_opt.interop.recordings.recording import Frame
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.sensors import mounting

can = pytest.importorskip("can")
pytest.importorskip("cantools")
PERIOD_S, SPEED_MPS, SLOTS = 0.05, 15.0, 4
CODEC, ESR = EsrCodec(), load_sensor("delphi_esr")


def traffic(seconds: float, sector: Sector = Sector.FRONT, gap_m: float = 30.0, rate_mps: float = -1.0) -> list[Scan]:
    """One target, `gap_m` from the radar at first and nearing at -`rate_mps`."""
    count = round(seconds / PERIOD_S)
    return [
        Scan(
            sensor=f"esr-{sector.value}", sector=sector, t_s=round(k * PERIOD_S, 6), mounting=mounting(sector, Vehicle()),
            radar=(RadarDetection(range_m=gap_m + rate_mps * k * PERIOD_S, azimuth_rad=0.0, range_rate_mps=rate_mps),), period_s=PERIOD_S,
        )
        for k in range(count)
    ]  # fmt: skip


def frames(scans: Sequence[Scan]) -> list[Frame]:
    return write_esr(scans, slots=SLOTS, speeds_mps=[SPEED_MPS] * len(scans))


class Clockwork:
    """An inbox on a clock of its own: waiting is what makes time pass. `work_s` is what every look at the clock costs."""

    def __init__(self, sent: Sequence[Frame], work_s: float = 0.0) -> None:
        self.channels = tuple(sorted({frame.channel for frame in sent}))
        self.now, self._work_s = 0.0, work_s
        self._left = [Arrival(frame.t_s, frame.channel, frame.identifier, frame.data) for frame in sent]

    def clock(self) -> float:
        self.now += self._work_s
        return self.now

    def wait(self, until_s: float) -> list[Arrival]:
        self.now = max(self.now, until_s)
        here = [arrival for arrival in self._left if arrival.t_s <= self.now]
        self._left = self._left[len(here) :]
        return here


def loop_on(inbox: Clockwork, radars: dict[str, Sector], **settings: float) -> tuple[LiveLoop, list[Line]]:
    lines: list[Line] = []
    planner = Planner(settings=Settings(cycle_s=PERIOD_S))
    wanted = LiveSettings(**settings)
    loop = LiveLoop(inbox, radars, planner, lines.append, codec=CODEC, sensor=ESR, settings=wanted, clock=inbox.clock)
    return loop, lines


def test_a_line_a_cycle_and_the_cars_found() -> None:
    sent = sorted(frames(traffic(2.0)) + frames(traffic(2.0, Sector.REAR, gap_m=40.0, rate_mps=-2.0)), key=lambda frame: frame.t_s)
    loop, lines = loop_on(Clockwork(sent), {"can0": Sector.FRONT, "can1": Sector.REAR})
    summary = loop.run(cycles=35)
    assert [line.cycle for line in lines] == list(range(35))
    assert summary.cycles == 35
    assert summary.late_cycles == summary.missed_cycles == summary.unverified_plans == 0
    assert {line.status for line in lines} <= {"planned", "fallback", "waiting"}
    last = lines[-1]
    assert sorted(track.role.value for track in last.tracks) == ["front", "rear"]
    front = next(track for track in last.tracks if track.role.value == "front")
    assert front.speed_s_mps == pytest.approx(SPEED_MPS - 1.0, abs=0.5)
    assert set(last.covered) == {"front", "rear"}
    assert last.passed
    assert last.drops == Drops()
    json.dumps(last.to_dict(), allow_nan=False)


def test_a_line_asks_for_what_is_planned_a_cycle_later() -> None:
    """At the line's own time a plan is where the car is: whoever commanded that never braked."""
    loop, lines = loop_on(Clockwork(frames(traffic(2.0, gap_m=15.0, rate_mps=-6.0))), {"can0": Sector.FRONT}, trajectories=True)
    loop.run(cycles=30)
    braking = [line for line in lines if line.mode == "brake"]
    assert len(braking) > 5
    for line in braking:
        assert line.trajectory is not None
        assert line.plan_age_s is not None
        asked = line.trajectory.command_at(line.plan_age_s + loop.settings.cycle_s)
        assert (line.acceleration_mps2, line.steering_rad) == (asked.acceleration_mps2, asked.steering_rad)
        assert line.acceleration_mps2 < line.host.acceleration_mps2 - 0.1


def test_the_summary_says_what_the_tracker_counted() -> None:
    """Rates of the wrong sign: said once, and counted, in the summary too; what was counted outlives a planner that begins anew."""
    wrong = [replace(scan, radar=tuple(replace(one, range_rate_mps=6.0) for one in scan.radar)) for scan in traffic(4.0, rate_mps=-6.0)]
    inbox = Clockwork(frames(wrong))
    loop, _ = loop_on(inbox, {"can0": Sector.FRONT})
    with pytest.warns(MeasurementWarning, match="counted as"):
        counted = loop.run(cycles=60).tracker
    assert counted["scans"] > 50
    assert counted["range_rates"] + counted["unfollowed"] > 0
    assert counted == loop.summary.tracker  # asked twice, counted once
    planner = Failing(settings=Settings(cycle_s=PERIOD_S))
    inbox = Clockwork(frames(traffic(2.0)))
    summary = LiveLoop(inbox, {"can0": Sector.FRONT}, planner, lambda _: None, codec=CODEC, sensor=ESR, clock=inbox.clock).run(cycles=30)
    assert summary.faults > 5
    assert summary.tracker["scans"] > 3 * planner.tracker.counters["scans"]


class Failing(Planner):
    """Fails in every third cycle, whatever it had begun."""

    asked = 0

    def step(self, *args: Any, **options: Any) -> Plan:
        self.asked += 1
        plan = super().step(*args, **options)
        if self.asked % 3 == 0:
            raise ZeroDivisionError("of a planner")
        return plan


def test_the_loop_outlives_its_planner() -> None:
    """A failure is a line and is counted; the last plan goes on, and the next cycle's planner begins anew."""
    inbox, lines = Clockwork(frames(traffic(2.0))), list[Line]()
    planner = Failing(settings=Settings(cycle_s=PERIOD_S))
    loop = LiveLoop(inbox, {"can0": Sector.FRONT}, planner, lines.append, codec=CODEC, sensor=ESR, clock=inbox.clock)
    summary = loop.run(cycles=30)
    failed = [line for line in lines if line.status == "fault"]
    assert summary.faults == len(failed) == summary.statuses["fault"] == planner.asked // 3 > 5
    assert {line.reason for line in failed} == {"ZeroDivisionError: of a planner"}
    assert all(line.warning and line.alert is Alert.WARN and line.acceleration_mps2 is not None for line in failed)
    assert lines[-1].faults == summary.faults
    planned = [line.to_dict() for line in lines if line.passed is not None]
    assert all(line["alert"] in tuple(Alert) and line["warning"] is (line["alert"] != "none") for line in planned)
    assert [line.cycle for line in lines] == list(range(30))
    json.dumps([line.to_dict() for line in lines], allow_nan=False)


class Doubting(Planner):
    """Doubts two tracks in every plan."""

    doubt = Doubt(kind=DoubtKind.ONE_PLACE, tracks=("2", "3"), value=0.4, unit="m")

    def step(self, *args: Any, **options: Any) -> Plan:
        return replace(super().step(*args, **options), doubts=(self.doubt,))


def test_a_line_says_which_tracks_are_doubted() -> None:
    inbox, lines = Clockwork(frames(traffic(1.0))), list[Line]()
    planner = Doubting(settings=Settings(cycle_s=PERIOD_S))
    LiveLoop(inbox, {"can0": Sector.FRONT}, planner, lines.append, codec=CODEC, sensor=ESR, clock=inbox.clock).run(cycles=10)
    told = [line.to_dict() for line in lines if line.passed is not None]
    assert len(told) > 5
    for line in told:
        (doubt,) = line["doubts"]
        assert (doubt["words"], doubt["tracks"]) == ("tracks 2 and 3 are in one place, 0.4 m deep", ["2", "3"])


ALL = {True: frames(traffic(1.5)), False: write_esr(traffic(1.5), slots=SLOTS)}  # with the radar's counter and without


@given(lost=st.sets(st.integers(3, 25), min_size=1, max_size=6), counter=st.booleans())
def test_scans_that_do_not_come_are_counted(lost: set[int], counter: bool) -> None:
    scans = traffic(1.5)
    sent = ALL[counter]
    kept = [frame for frame in sent if not _of(frame, lost)]
    assembler = ScanAssembler(Sector.FRONT, CODEC, Vehicle(), ESR)
    got = []
    for frame in kept:
        assembler.take(Arrival(frame.t_s, frame.channel, frame.identifier, frame.data))
        got += assembler.ready(frame.t_s)
    got += assembler.ready(10.0)
    assert len(got) == len(scans) - len(lost)
    assert assembler.drops.dropped_scans == len(lost)
    assert assembler.drops.incomplete_scans == 0


def _of(frame: Frame, scans: set[int]) -> bool:
    """Whether a frame is of one of these scans (stamps are a few ms after their scan's)."""
    return int((frame.t_s + 1e-6) / PERIOD_S) in scans


def test_what_is_no_sound_frame_is_counted_by_kind() -> None:
    sent = frames(traffic(1.0))
    cut = [replace(frame, data=frame.data[:5]) if frame.identifier == 0x500 and _of(frame, {3, 7}) else frame for frame in sent]
    strange = Frame(t_s=0.5, channel="can0", identifier=0x123, data=b"\1")
    assembler = ScanAssembler(Sector.FRONT, CODEC, Vehicle(), ESR)
    for frame in [*cut, strange]:
        assembler.take(Arrival(frame.t_s, frame.channel, frame.identifier, frame.data))
    assembler.take(Arrival(0.6, "can0", 0, b"", "error frame"))
    assembler.ready(10.0)
    drops = assembler.drops
    assert (drops.bad_frames, drops.other_frames, drops.bus_faults, drops.incomplete_scans, drops.dropped_scans) == (2, 1, 1, 2, 0)


@pytest.mark.parametrize(
    ("sent", "said"),
    [
        ([], "is silent: no frame for 0.5 s"),
        (frames(traffic(1.0)), "is silent: no frame any more for 0.5 s"),
        (
            [Frame(t_s=0.01 * k, channel="can0", identifier=0x123, data=b"\1") for k in range(200)],
            r"is silent: frames, but no ESR track frame \(0x500 to 0x53F\) for 0.5 s",
        ),
        (write_esr(traffic(2.0), slots=SLOTS), r"says no host speed \(ESR_Status1, 0x4E0\) for 0.5 s: pass --speed"),
    ],
)
def test_a_bus_that_falls_silent_is_one_clear_error(sent: list[Frame], said: str) -> None:
    loop, lines = loop_on(Clockwork(sent), {"can0": Sector.FRONT}, silence_s=0.5)
    with pytest.raises(SilentBusError, match=f"^can0: {said}"):
        loop.run(cycles=200)
    assert len(lines) < 45
    assert loop.summary.cycles == len(lines)


@pytest.mark.parametrize("stopped", [False, True], ids=["the lines are not read", "the process is stopped"])
def test_time_in_which_the_loop_did_not_listen_is_no_silence(stopped: bool) -> None:
    """Six times the patience, twice: in a stopped process nobody takes frames either, and the next come a cycle later."""
    inbox, lines = Clockwork(frames(traffic(10.0))), list[Line]()

    def publish(line: Line) -> None:
        lines.append(line)
        if line.cycle in (10, 25):
            inbox.now += 3.0
            if stopped:
                inbox._left = [arrival for arrival in inbox._left if arrival.t_s > inbox.now + 1.5 * PERIOD_S]

    settings, planner = LiveSettings(silence_s=0.5), Planner(settings=Settings(cycle_s=PERIOD_S))
    loop = LiveLoop(inbox, {"can0": Sector.FRONT}, planner, publish, codec=CODEC, sensor=ESR, settings=settings, clock=inbox.clock)
    assert loop.run(cycles=40).cycles == 40
    assert lines[-1].silent == ()
    with pytest.raises(SilentBusError, match=r"no frame any more for 0\.5 s"):
        loop.run()
    assert inbox.now < 11.0


def test_one_of_two_radars_may_fall_silent_and_is_named() -> None:
    sent = sorted(frames(traffic(3.0)) + frames(traffic(1.0, Sector.REAR)), key=lambda frame: frame.t_s)
    loop, lines = loop_on(Clockwork(sent), {"can0": Sector.FRONT, "can1": Sector.REAR}, silence_s=0.5)
    loop.run(cycles=55)
    assert lines[15].silent == ()
    assert lines[15].covered == ("front", "rear")
    assert lines[-1].silent == ("can1",)
    assert lines[-1].covered == ("front",)


def test_a_speed_given_by_hand_replaces_the_bus() -> None:
    loop, lines = loop_on(Clockwork(write_esr(traffic(1.0), slots=SLOTS)), {"can0": Sector.FRONT}, speed_mps=7.0)
    loop.run(cycles=15)
    assert all(line.host is not None and line.host.speed_mps == 7.0 for line in lines)


def test_hours_of_cycles_are_remembered_by_their_latest_and_their_longest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loop_module, "_LATEST", 5)
    loop, _ = loop_on(Clockwork(frames(traffic(2.0)), work_s=0.001), {"can0": Sector.FRONT})
    summary = loop.run(30)
    assert len(loop._run.took_ms) == 5
    assert summary.cycles == 30
    assert summary.cycle_ms.max >= summary.cycle_ms.p99 >= summary.cycle_ms.p50 > 0.0


def test_cycles_that_take_too_long_are_counted() -> None:
    """Every look at the clock costs 30 ms: no cycle is done when the next is due."""
    inbox = Clockwork(frames(traffic(6.0)), work_s=0.03)
    loop, lines = loop_on(inbox, {"can0": Sector.FRONT})
    summary = loop.run(cycles=20)
    assert summary.late_cycles >= 15
    assert summary.missed_cycles >= 15
    assert lines[-1].late_cycles == summary.late_cycles
    assert len(lines) == 20


class Slow:
    """A planner that sleeps for ten cycles on its third plan."""

    def __init__(self, planner: Planner) -> None:
        self._planner, self._steps = planner, 0

    def __getattr__(self, name: str) -> object:
        return getattr(self._planner, name)

    def step(self, *arguments: object, **options: object) -> Plan:
        self._steps += 1
        if self._steps == 3:
            time.sleep(10 * PERIOD_S)
        return self._planner.step(*arguments, **options)


def test_the_watchdog_speaks_while_the_planner_is_late() -> None:
    """On a virtual bus in real time: the line "late" leaves before the plan that it waited for, with what the last plan asks for."""
    lines: list[tuple[float, Line]] = []
    buses = {"late-front": open_bus("late-front", "virtual")}
    sender, stop = open_bus("late-front", "virtual"), threading.Event()
    dog = Watchdog()
    thread = threading.Thread(target=_send_until, args=(sender, stop), daemon=True)
    thread.start()
    try:
        with BusInbox(buses) as inbox:
            loop = LiveLoop(
                inbox, {"late-front": Sector.FRONT}, Slow(Planner()), lambda line: lines.append((time.monotonic(), line)),
                codec=CODEC, sensor=ESR, settings=LiveSettings(speed_mps=SPEED_MPS, silence_s=30.0), watchdog=dog,
            )  # fmt: skip
            summary = loop.run(cycles=6)
    finally:
        stop.set()
        thread.join()
        sender.shutdown()
        dog.close()
    late = {line.cycle: (at, line) for at, line in lines if line.status == "late"}  # on a busy machine others than the slow one too
    plans = {line.cycle: at for at, line in lines if line.status != "late"}
    assert len(late) == sum(line.status == "late" for _, line in lines)
    assert all(at < plans[cycle] for cycle, (at, _) in late.items())
    assert any(line.acceleration_mps2 is not None for _, line in late.values())
    assert summary.late_cycles >= 1
    assert summary.missed_cycles >= 5


def _send_until(bus: object, stop: threading.Event) -> None:
    while not stop.wait(PERIOD_S):
        for frame in write_esr(traffic(PERIOD_S), slots=SLOTS):
            bus.send(can.Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=False))


def test_a_watchdog_that_is_called_off_does_not_bark() -> None:
    barks: list[int] = []
    dog = Watchdog()
    for k in range(50):
        dog.arm(time.monotonic() + 30.0, lambda k=k: barks.append(k))
        dog.disarm()
    dog.arm(time.monotonic(), lambda: barks.append(-1))
    for _ in range(500):
        if barks:
            break
        time.sleep(0.01)
    dog.close()
    assert barks == [-1]


@given(steps=st.lists(st.tuples(st.floats(0.01, 0.2), st.floats(0.0, 40.0)), min_size=2, max_size=60))
def test_the_host_has_driven_what_its_speeds_say(steps: list[tuple[float, float]]) -> None:
    """By the trapezoidal rule over all speeds, though only the last moments are remembered; the acceleration keeps the vehicle's limits."""
    vehicle, host = Vehicle(), LiveHost(Road(), Vehicle())
    t, driven, before = 0.0, 0.0, None
    for dt, v in steps:
        t += dt
        driven += 0.0 if before is None else 0.5 * (before + v) * dt
        before = v
        host.note(t, v)
        host.note(t - 0.5 * dt, 99.0)  # late news of the past is left out
    assert before is not None
    state: HostState = host.state(t + 0.1)
    assert state.s_m == pytest.approx(driven + 0.1 * before, abs=1e-9)
    assert vehicle.acceleration_min_mps2 <= state.acceleration_mps2 <= vehicle.acceleration_max_mps2


def test_a_log_played_on_virtual_buses() -> None:
    before = threading.active_count()
    lines: list[Line] = []
    ended = []
    settings = LiveSettings(silence_s=20.0)
    live(lines.append, bus="can0", rear="can1", play="front_and_rear", settings=settings, cycles=30, ended=ended.append)
    assert ended[0].cycles == 30
    assert ended[0].unverified_plans == 0
    assert sum(line.status != "late" for line in lines) == 30
    assert sum(line.scans for line in lines) > 20
    assert sum(drops.bad_frames for drops in ended[0].drops.values()) == 0
    assert threading.active_count() <= before


def test_an_interrupt_leaves_the_summary() -> None:
    before = threading.active_count()
    ended = []

    def interrupt(_: Line) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        live(interrupt, bus="stop0", interface="virtual", cycles=5, ended=ended.append)
    assert ended[0].cycles == 0
    assert threading.active_count() <= before


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match=r"--interface = 'pigeon': is no interface of python-can"):
        open_bus("can0", "pigeon")
    with pytest.raises(InputError, match="no-such-can: cannot be opened as socketcan"):
        open_bus("no-such-can", "socketcan")
    with pytest.raises(InputError, match="--rear = 'can0': is the front radar's bus"):
        live(lambda _: None, bus="can0", rear="can0")
    with pytest.raises(ParameterError, match="cycle_s"):
        LiveSettings(cycle_s=0.0)
    with pytest.raises(ParameterError, match="speed_mps"):
        LiveSettings(speed_mps=math.nan)
    with pytest.raises(ParameterError, match=r"speed_mps = 1e\+308 m/s: must lie in \[0, 50\]"):
        live(lambda _: None, bus="fast0", interface="virtual", settings=LiveSettings(speed_mps=1e308))


def test_the_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["live", "--bus", "quiet", "--interface", "virtual", "--silence", "0.3", "--planner", "closed-form"]
    monkeypatch.setattr(sys, "argv", ["mcdas-opt", *arguments])
    with pytest.raises(SystemExit) as stop:
        main()
    out, err = capsys.readouterr()
    assert stop.value.code == 2
    assert [json.loads(line)["status"] for line in out.splitlines()] == ["waiting"] * len(out.splitlines())
    assert json.loads(err.splitlines()[0])["cycles"] == len(out.splitlines())
    assert err.splitlines()[-1] == "mcdas-opt: quiet: is silent: no frame for 0.3 s"


def test_a_rear_bus_that_cannot_be_opened_leaves_the_front_one_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[Any] = []

    def opening(channel: str, interface: str) -> Any:
        if channel == "can9":
            raise InputError(channel, "", None, "cannot be opened")
        opened.append(open_bus(channel, interface))
        return opened[-1]

    monkeypatch.setattr(session, "open_bus", opening)
    monkeypatch.setattr(session, "warm_up", lambda planner: None)
    with pytest.raises(InputError, match="can9: cannot be opened"):
        live(lambda line: None, bus="can0", rear="can9", interface="virtual")
    (front,) = opened
    with pytest.raises(can.CanOperationError):  # a virtual bus that was shut down
        front.send(can.Message())
