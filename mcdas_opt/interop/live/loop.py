"""The live loop: frames that arrived, scans, tracks, a judged plan and a line, twenty times a second."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.rules import non_negative, positive, require, within
from mcdas_opt.domain.sensor import Sensor
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vocabulary import Alert, Role, Sector, Status
from mcdas_opt.interop.esr_codec import EsrCodec
from mcdas_opt.interop.host_motion import LiveHost
from mcdas_opt.interop.live.assembler import Drops, ScanAssembler
from mcdas_opt.interop.live.inbox import Inbox
from mcdas_opt.interop.live.record import FAULT, LATE, WAITING, Line, LiveSummary
from mcdas_opt.interop.live.silence import Silence
from mcdas_opt.interop.live.watchdog import Watchdog
from mcdas_opt.interop.replay_record import SeenTrack
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.record import CycleTimes
from mcdas_opt.situation.roles import assign_roles

Publish = Callable[[Line], None]
_LATEST = 72_000  # cycles, an hour of them at 20 Hz, of which the times are kept


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveSettings:
    """Cycle time and timeouts. `speed_mps` replaces the speed that the radars are told (for a bench where nobody tells them)."""

    cycle_s: float = 0.05
    silence_s: float = 1.0
    speed_mps: float | None = None
    trajectories: bool = False  # whether lines hold the plan's whole trajectory

    def __post_init__(self) -> None:
        require_types(self)
        require(self, positive, "cycle_s", "silence_s")
        if self.speed_mps is not None:
            non_negative("speed_mps", self.speed_mps, "m/s")


@dataclass(slots=True)
class _Run:
    """Counts of a run so far."""

    began_s: float
    statuses: Counter[str] = field(default_factory=Counter)
    took_ms: deque[float] = field(default_factory=lambda: deque(maxlen=_LATEST))
    longest_ms: float = 0.0
    cycles: int = 0
    late: int = 0
    missed: int = 0
    unverified: int = 0
    faults: int = 0
    tracked: Counter[str] = field(default_factory=Counter)  # until the planner last began anew
    now_s: float = 0.0


class LiveLoop:
    """Belongs to one thread. `publish` is called once a cycle, and from the watchdog's thread when a plan is late.

    `radars`: which channel of the inbox carries which sector's ESR. `clock` is the inbox's; a watchdog needs real time, so that a loop
    on another clock is given none.
    """

    def __init__(
        self,
        inbox: Inbox,
        radars: Mapping[str, Sector],
        planner: Planner,
        publish: Publish,
        *,
        codec: EsrCodec,
        sensor: Sensor,
        settings: LiveSettings | None = None,
        clock: Callable[[], float] = time.monotonic,
        watchdog: Watchdog | None = None,
    ) -> None:
        self.settings = settings or LiveSettings()
        if self.settings.speed_mps is not None:
            within("speed_mps", self.settings.speed_mps, 0.0, planner.vehicle.speed_max_mps, "m/s")
        self._inbox, self._planner, self._publish, self._clock, self._watchdog = inbox, planner, publish, clock, watchdog
        self._radars = {name: ScanAssembler(sector, codec, planner.vehicle, sensor) for name, sector in radars.items()}
        self._host = LiveHost(planner.road, planner.vehicle)
        self._run = _Run(began_s=clock())
        self._silence = Silence(self._run.began_s, self.settings.silence_s, self.settings.cycle_s)

    def run(self, cycles: int | None = None) -> LiveSummary:
        """So many cycles, or until interrupted. Raises `SilentBusError` when nothing (more) is heard for `silence_s` of listening."""
        run, cycle_s = self._run, self.settings.cycle_s
        beat = 0
        while cycles is None or run.cycles < cycles:
            beat += 1
            due = run.began_s + beat * cycle_s
            for arrival in self._inbox.wait(due):
                self._radars[arrival.channel].take(arrival)
            now = self._clock()
            self._note_speed(now)
            silent = self._silence.of(self._radars, self._host.heard_s, now)
            line = self._cycle(now, due, silent)
            self._publish(line)
            run.cycles += 1
            run.statuses[line.status] += 1
            run.now_s = self._clock()
            run.took_ms.append(1e3 * (run.now_s - now))
            run.longest_ms = max(run.longest_ms, run.took_ms[-1])
            passed = int((run.now_s - run.began_s) / cycle_s + 1e-9)
            run.missed += max(passed - beat, 0)
            beat = max(beat, passed)
        return self.summary

    @property
    def summary(self) -> LiveSummary:
        """Of what has been run so far; the middle and the 99th of a hundred times are those of the latest 72,000 cycles."""
        run, tracked = self._run, self._run.tracked.copy()
        tracked.update(self._planner.tracker.counters)
        return LiveSummary(
            cycles=run.cycles,
            duration_s=max(run.now_s - run.began_s, 0.0),
            statuses=dict(sorted(run.statuses.items())),
            late_cycles=run.late,
            missed_cycles=run.missed,
            unverified_plans=run.unverified,
            faults=run.faults,
            drops={name: radar.drops for name, radar in self._radars.items()},
            tracker=dict(sorted(tracked.items())),
            cycle_ms=replace(CycleTimes.of(list(run.took_ms) or [0.0]), max=run.longest_ms),
        )

    def _note_speed(self, now: float) -> None:
        if self.settings.speed_mps is not None:
            self._host.note(now, self.settings.speed_mps)
            return
        for radar in self._radars.values():
            if radar.speed is not None:
                self._host.note(*radar.speed)

    def _cycle(self, now: float, due: float, silent: tuple[str, ...]) -> Line:
        scans = [scan for radar in self._radars.values() for scan in radar.ready(now)]
        late_s = max(now - due, 0.0)
        if self._host.heard_s is None:
            return self._line(WAITING, now, None, scans=len(scans), silent=silent, late_s=late_s)
        before = self._planner.previous
        cycle, late_at = self._run.cycles, due + self.settings.cycle_s

        def bark() -> None:
            self._run.late += 1
            self._publish(self._line(LATE, self._clock(), before, scans=len(scans), silent=silent, late_s=late_s, cycle=cycle))

        if self._watchdog is not None:
            self._watchdog.arm(late_at, bark)
        try:
            plan = self._planner.step(scans, self._host.state(now), now)
        except Exception as error:  # whatever it is: the next cycle has a planner that begins anew
            self._run.faults += 1
            self._run.tracked.update(self._planner.tracker.counters)
            self._planner.reset()
            line = self._line(FAULT, self._clock(), before, scans=len(scans), silent=silent, late_s=late_s)
            return replace(line, reason=f"{type(error).__name__}: {error}", alert=Alert.WARN, warning=True)
        finally:
            if self._watchdog is not None:
                self._watchdog.disarm()
        done = self._clock()
        if self._watchdog is None and done > late_at:
            self._run.late += 1
        self._run.unverified += plan.status is not Status.UNAVOIDABLE and not plan.verdict.passed
        return self._line(plan.status.value, done, plan, scans=len(scans), silent=silent, late_s=late_s, took_ms=1e3 * (done - now))

    def _line(
        self,
        status: str,
        t_s: float,
        plan: Plan | None,
        *,
        scans: int,
        silent: tuple[str, ...],
        late_s: float,
        took_ms: float = 0.0,
        cycle: int | None = None,
    ) -> Line:
        situation = self._planner.situation if plan is not None and plan is self._planner.previous else None
        age = None if plan is None else t_s - plan.time_s
        asked = None if plan is None or age is None or age > plan.trajectory.t_s[-1] else plan.command_at(age + self.settings.cycle_s)
        drops = Drops()
        for radar in self._radars.values():
            drops = drops.plus(radar.drops)
        return Line(
            cycle=self._run.cycles if cycle is None else cycle,
            t_s=t_s - self._run.began_s,
            status=status,
            mode=None if plan is None else plan.mode.value,
            side=None if plan is None else plan.side.value,
            alert=None if plan is None else plan.alert,
            warning=plan is not None and plan.warning,
            passed=None if plan is None else plan.verdict.passed,
            reason="" if plan is None else plan.reason,
            doubts=() if plan is None else plan.doubts,
            plan_age_s=age,
            acceleration_mps2=None if asked is None else asked.acceleration_mps2,
            steering_rad=None if asked is None else asked.steering_rad,
            host=None if situation is None else situation.host,
            covered=() if situation is None else tuple(sector.value for sector in Sector if situation.coverage.sees(sector)),
            silent=silent,
            tracks=() if situation is None else self._seen(situation),
            scans=scans,
            late_s=late_s,
            took_ms=took_ms,
            late_cycles=self._run.late,
            missed_cycles=self._run.missed,
            faults=self._run.faults,
            drops=drops,
            trajectory=plan.trajectory if plan is not None and self.settings.trajectories else None,
        )

    def _seen(self, situation: Situation) -> tuple[SeenTrack, ...]:
        host, road = situation.host, situation.road
        roles = assign_roles(
            situation.tracks, situation.host_lane, host, self._planner.vehicle, road, self._planner.settings.selector
        ).roles
        return tuple(SeenTrack.of(track, host, roles.get(track.id, Role.OTHER)) for track in situation.tracks)
