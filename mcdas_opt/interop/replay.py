"""Runs a recording through the whole pipeline: tracker, situation, planner, in the planner's cycle time."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from mcdas_opt.catalogue.data_files import find
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import require_type, require_type_if_given
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Role, Sector, Status
from mcdas_opt.errors import InputError, check_file_name
from mcdas_opt.interop.esr_can import read_esr
from mcdas_opt.interop.host_motion import HostMotion
from mcdas_opt.interop.log_check import check_log
from mcdas_opt.interop.recordings.recording import format_of, open_recording
from mcdas_opt.interop.replay_record import Cycle, Replay, SeenTrack, Summary
from mcdas_opt.interop.sensor_log import SensorLog
from mcdas_opt.interop.target_list import Columns, read_targets
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.record import CycleTimes
from mcdas_opt.situation.assess import assess
from mcdas_opt.tracking.tracker import Tracker

LONGEST_S = 6.0 * 3600.0  # a longer recording is taken for one with a broken clock
SILENT_S = 10.0  # without a scan: then nothing is planned until the next one
_SLOWEST_S = 2.0  # scans that are farther apart are none of a radar's, whose time is in seconds

Progress = Callable[[int, int], None]


@usual_arithmetic
def replay(
    log: str | Path,
    format: str | None = None,
    *,
    dbc: str | Path | None = None,
    rear: str | Path | None = None,
    host: str | Path | None = None,
    road: Scene | None = None,
    columns: Columns | Mapping[str, str] | None = None,
    planner: str = "mpc",
    plan: bool = True,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> Replay:
    """Runs a recording of radars through tracker, situation and (with `plan`) planner, every `settings.cycle_s`.

    `log` is a path, or the name of a shipped ESR recording; `format` is by default what the file is called. CAN
    frames are an ESR's; with `columns`, or without frames, a front radar's target list is read from the recording's tables, and a
    rear radar's from those of `rear`, by the same columns. `host` is a
    CSV of the host's speed (or that name); without it the recording's own is taken.

    The host keeps to the middle of its lane. `road` is a scene whose road and vehicle are used; default one straight lane, so that there
    is nowhere to steer out to, and a sedan. Sectors without a log are not covered, that is occupied. Where no radar is heard for
    SILENT_S, or neither a radar nor a speed for a second, nothing is planned until the next scan. `progress(done, of)` is called every
    cycle.

    Raises `InputError` where a file is unusable or has not the channels (it lists those that there are), the host's speed is unknown, at
    any time of a scan, signs or units are plainly wrong (`interop.log_check`), or an option belongs to another kind of recording;
    `MissingExtraError` for what a format needs.
    """
    require_type("log", log, str, Path)
    require_type_if_given("columns", columns, Columns, Mapping)
    require_type_if_given("road", road, Scene)
    vehicle = road.vehicle if road is not None else Vehicle()
    check_file_name(log)
    path = find("logs", str(log), ".log") if not Path(log).exists() else Path(log)
    format = format or format_of(path)
    recording = _read(path, format, dbc, rear, columns, vehicle)
    motion = _motion(log, host, recording)
    lane = road.assumed_road if road is not None else Road()
    settings = settings or Settings()
    times = _cycle_times(log, recording, motion, settings.cycle_s)
    motion.require(np.unique(recording.arrivals_s))
    check_log(recording, motion)
    brain = Planner(vehicle, planner, settings=settings, road=lane) if plan else None
    tracker = brain.tracker if brain is not None else Tracker()
    cycles: list[Cycle] = []
    taken: list[float] = []
    before: Assessment | None = None
    answer: Plan | None = None
    handed = unverified = 0
    for k, now in enumerate(times):
        upto = handed
        while upto < len(recording.scans) and recording.arrivals_s[upto] <= now + 1e-9:
            upto += 1
        scans, handed = recording.scans[handed:upto], upto
        state = motion.state(now, times[0], lane, vehicle)
        started = time.perf_counter()
        for scan in scans:  # one by one, each with the host's pose at its own time: at 17 m/s a scan 0.05 s old is 0.85 m off
            tracker.update((scan,), motion.state(scan.t_s, times[0], lane, vehicle), lane, now)
        if brain is not None:
            answer = brain.step((), state, now)
            unverified += answer.status is not Status.UNAVOIDABLE and not answer.verdict.passed
        elif not scans:
            tracker.update((), state, lane, now)
        situation = Situation(
            time_s=now, host=state, tracks=tracker.tracks(now), coverage=tracker.coverage(now), road=lane, vehicle=vehicle.name
        )  # fmt: skip
        before = assess(situation, vehicle, settings.selector, before)
        taken.append(1e3 * (time.perf_counter() - started))
        cycles.append(_cycle(situation, before, answer, settings.cycle_s))
        if progress is not None:
            progress(k + 1, len(times))
    left_out = round((times[-1] - times[0]) / settings.cycle_s) + 1 - len(times)
    summary = _summary(recording, cycles, left_out, dict(tracker.counters), taken, 0 if answer is None else len(cycles), unverified)
    name = planner if plan else None
    return Replay(
        name=path.stem, format=format, planner=name, cycles=tuple(cycles), summary=summary, road=lane, vehicle=vehicle, log=recording
    )


def _read(
    path: Path,
    format: str,
    dbc: str | Path | None,
    rear: str | Path | None,
    columns: Columns | Mapping[str, str] | None,
    vehicle: Vehicle,
) -> SensorLog:
    """An ESR's CAN frames where the recording has frames and nobody names its columns, else a front radar's target list."""
    opened = open_recording(path, format)
    behind = None if rear is None else open_recording(Path(rear), format_of(Path(rear)))
    if columns is None and opened.can_log() is not None:
        return read_esr(opened, rear=behind, dbc=dbc, vehicle=vehicle)
    if dbc is not None:
        raise InputError("--dbc", "", None, f"belongs to a recording of CAN frames, which {path} is not read as")
    return read_targets(opened, columns=columns, vehicle=vehicle, rear=behind)


def _motion(log: str | Path, host: str | Path | None, recording: SensorLog) -> HostMotion:
    if host is not None:
        return HostMotion.read(find("logs", str(host), ".host.csv"))
    if recording.host_speed is None:
        rule = "does not say the host's speed: pass --host, a CSV of t_s, speed_mps, or name its channel: --columns host_speed_mps=..."
        raise InputError(log, "", None, rule)
    if len(recording.host_speed) < 2:
        only = "at one time only: are its time stamps all equal?" if len(recording.host_speed) else "nowhere as a number with a time"
        raise InputError(log, "", None, f"says the host's speed {only}")
    return HostMotion(t_s=recording.host_speed[:, 0], speed_mps=recording.host_speed[:, 1], source=f"{log}: host speed")


def _cycle_times(log: str | Path, recording: SensorLog, motion: HostMotion, cycle_s: float) -> list[float]:
    """Times of the cycles, from the first scan's arrival to the last one's, without those that have had no scan for SILENT_S, or no scan
    and no speed."""
    arrivals = np.unique(np.asarray(recording.arrivals_s, dtype=np.float64))
    first, last = float(arrivals[0]), float(arrivals[-1])
    if last - first > LONGEST_S:
        raise InputError(
            log, "time", last - first, f"spans more than {LONGEST_S:g} s: is one of its time stamps broken, or are they not in seconds?"
        )
    apart_s = float(np.median(np.diff(arrivals))) if arrivals.size > 1 else 0.0
    if apart_s > _SLOWEST_S:
        rule = f"is between two scans (median), which must be at most {_SLOWEST_S:g} s: are its time stamps not in seconds?"
        raise InputError(log, "time", apart_s, rule)
    count = math.ceil((last - first) / cycle_s - 1e-6) + 1
    times = np.array([round(first + k * cycle_s, 9) for k in range(count)])
    before = arrivals[np.searchsorted(arrivals, times + 1e-9, side="right") - 1]
    silent_s = times - before
    kept: list[float] = times[(silent_s <= SILENT_S) & (motion.known(times) | (silent_s <= cycle_s))].tolist()
    return kept


def _cycle(situation: Situation, assessment: Assessment, answer: Plan | None, cycle_s: float) -> Cycle:
    host = situation.host
    tracks = tuple(SeenTrack.of(track, host, assessment.roles.get(track.id, Role.OTHER)) for track in situation.tracks)
    chosen = assessment if answer is None else answer
    asked = None if answer is None else answer.command_at(cycle_s)
    return Cycle(
        t_s=situation.time_s,
        host=host,
        tracks=tracks,
        covered=tuple(sector for sector in Sector if situation.coverage.sees(sector)),
        mode=chosen.mode,
        side=chosen.side,
        warning=chosen.warning,
        status=None if answer is None else answer.status,
        alert=None if answer is None else answer.alert,
        reason=chosen.reason,
        doubts=() if answer is None else answer.doubts,
        acceleration_mps2=None if asked is None else asked.acceleration_mps2,
        steering_rad=None if asked is None else asked.steering_rad,
        speed_mps=None if answer is None else float(np.interp(cycle_s, answer.trajectory.t_s, answer.trajectory.speed_mps)),
        plan=answer,
    )


def _summary(
    recording: SensorLog, cycles: list[Cycle], left_out: int, counters: dict[str, int], taken: list[float], plans: int, unverified: int
) -> Summary:
    lives: dict[str, list[float]] = {}
    for cycle in cycles:
        for track in cycle.tracks:
            lives.setdefault(track.id, []).append(cycle.t_s)
    last = cycles[-1]
    statuses = Counter(cycle.status.value for cycle in cycles if cycle.status is not None)
    modes = Counter(cycle.mode.value for cycle in cycles)
    sights = {sector.value: sum(sector in cycle.covered for cycle in cycles) / len(cycles) for sector in Sector}
    return Summary(
        cycles=len(cycles),
        start_s=cycles[0].t_s,
        end_s=last.t_s,
        cycles_left_out=left_out,
        frames_good=recording.good,
        frames_bad=recording.bad.total,
        frames_other=recording.other,
        bad=recording.bad.to_document(),
        scans=len(recording.scans),
        detections=recording.detections,
        gated=dict(sorted(recording.gated.items())),
        tracker={name: int(count) for name, count in sorted(counters.items())},
        sensor_pieces=recording.pieces,
        tracks_started=len(lives),
        tracks_ended=len(lives) - len(last.tracks),
        longest_track_s=max((times[-1] - times[0] for times in lives.values()), default=0.0),
        covered=sights,
        plans=plans,
        unverified_plans=unverified,
        statuses=dict(sorted(statuses.items())),
        modes=dict(sorted(modes.items())),
        cycle_ms=CycleTimes.of(taken),
        radars={sector.value: f"{Path(one.file).name} {one.bus}".rstrip() for sector, one in recording.sources.items()},
    )
