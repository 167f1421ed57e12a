"""Delphi ESR radars on CAN: candump logs to scans, and scans to candump logs, by one codec."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.sensor import Sensor
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.interop.esr_codec import ANGLE, RANGE_RATE, TRACKS, EsrCodec, EsrHealth, EsrMotion, EsrTarget, TargetStatus, WrongLengthError
from mcdas_opt.interop.host_motion import forward
from mcdas_opt.interop.recordings.recording import Frame, Recording, Tally, listed
from mcdas_opt.interop.sensor_log import SensorLog, Source, cycles, in_order_of_arrival, increasing, require_clock, usual_period
from mcdas_opt.simulation.sensors import mounting
from mcdas_opt.simulation.sight import echo

FRAME_SPACING_S = 0.0003  # a classic frame of 8 bytes at 500 kbit/s takes about 0.25 ms


def read_esr(log: Recording, *, rear: Recording | None = None, dbc: str | Path | None = None, vehicle: Vehicle | None = None) -> SensorLog:
    """Scans of a front ESR and, where there is one, of a rear ESR: in a file of its own, or on a second bus of the same file.

    Of two buses in one file the first by name is the front radar's, can2 before can10. Both radars sit in the middle of their bumper.
    A slot whose status says that the radar did not see its target in this cycle is gated and counted; bad frames are left out and counted.
    The standard deviations are those of the shipped `delphi_esr`: the CAN interface carries none.

    Raises `InputError` for a recording that carries no CAN, holds none of the radar's frames, or holds more than two buses with
    them; for a DBC without the messages; `MissingExtraError` without cantools or python-can.
    """
    codec = EsrCodec(dbc=dbc)
    vehicle, sensor = vehicle or Vehicle(), load_sensor("delphi_esr")
    first, bad, other = _decoded(log, codec, dbc)
    buses = _buses(first)
    if len(buses) > (2 if rear is None else 1):
        rule = "at most a front and a rear bus may carry ESR tracks" if rear is None else "a log of two buses and --rear exclude each other"
        raise InputError(log.path, "bus", ", ".join(buses), rule)
    streams = {
        sector: [i for i in first if i.frame.channel == bus] for sector, bus in zip((Sector.FRONT, Sector.REAR), buses, strict=False)
    }
    tally = Tally()
    tally.absorb(bad, "" if rear is None else "front: ")
    if rear is not None:
        second, bad, more = _decoded(rear, codec, dbc)
        buses = _buses(second)
        if len(buses) > 1:
            raise InputError(rear.path, "bus", ", ".join(buses), "the rear log must hold one bus with ESR tracks")
        streams[Sector.REAR] = second
        tally.absorb(bad, "rear: ")
        other += more
    files = {sector: log.path if rear is None or sector is Sector.FRONT else rear.path for sector in streams}
    for sector, items in streams.items():
        require_clock(files[sector], "time", [i.frame.t_s for i in items], [i.frame.line for i in items])
    gated: dict[str, int] = {}
    arriving = [_scans(sector, items, vehicle, sensor, gated) for sector, items in streams.items()]
    scans, arrivals = in_order_of_arrival(arriving)
    spoken = [
        (i.frame.t_s, forward(log.path, i.frame.line, "host speed", i.item.speed_mps))
        for i in next(iter(streams.values()))
        if isinstance(i.item, EsrMotion)
    ]
    speeds = increasing(spoken)
    good = sum(len(items) for items in streams.values())
    host = np.array(speeds) if speeds else None
    sources = {
        sector: Source(file=str(file), bus=streams[sector][0].frame.channel, range_rate=RANGE_RATE, bearing=ANGLE)
        for sector, file in files.items()
    }
    return SensorLog(scans=scans, arrivals_s=arrivals, good=good, bad=tally, other=other, gated=gated, host_speed=host, sources=sources)


def write_esr(
    scans: Iterable[Scan],
    *,
    buses: Mapping[Sector, str] | None = None,
    dbc: str | Path | None = None,
    slots: int = TRACKS,
    speeds_mps: Sequence[float] | None = None,
) -> list[Frame]:
    """The frames that ESRs would have sent for `scans`, in time order: health, the host's speed where given, then every slot.

    The first `slots` track messages are sent in every cycle; those without a target carry the radar's defaults, which look valid.
    Raises `ParameterError` for a value that the message cannot carry, more detections than slots, or a sector without a bus.
    """
    codec = EsrCodec(dbc=dbc)
    buses = buses or {Sector.FRONT: "can0", Sector.REAR: "can1"}
    if not 1 <= slots <= TRACKS:
        raise ParameterError("slots", slots, f"must lie in [1, {TRACKS}]")
    frames: list[Frame] = []
    for index, scan in enumerate(scans):
        if scan.sector not in buses:
            raise ParameterError("sector", scan.sector.value, "has no bus; known: " + ", ".join(s.value for s in buses))
        if len(scan.radar) > slots:
            raise ParameterError("radar", len(scan.radar), f"must be at most {slots} detections, the slots that are sent")
        items: list[EsrTarget | EsrMotion | EsrHealth] = [EsrHealth(working=scan.working)]
        if speeds_mps is not None:
            items.append(EsrMotion(speed_mps=speeds_mps[index], scan_index=index % 65536))
        items += [_target(slot, d) for slot, d in enumerate(scan.radar)]
        items += [EsrTarget(slot=slot, status=TargetStatus.NO_TARGET) for slot in range(len(scan.radar), slots)]
        for k, item in enumerate(items):
            identifier, data = codec.encode(item)
            frames.append(Frame(t_s=scan.t_s + k * FRAME_SPACING_S, channel=buses[scan.sector], identifier=identifier, data=data))
    return sorted(frames, key=lambda frame: frame.t_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Decoded:
    frame: Frame
    item: EsrTarget | EsrMotion | EsrHealth


def _decoded(recording: Recording, codec: EsrCodec, dbc: str | Path | None) -> tuple[list[_Decoded], Tally, int]:
    """The radar's messages in a file, its bad frames, and how many sound lines were not the radar's."""
    log = recording.can_log()
    if log is None:
        raise InputError(recording.path, "", None, f"carries no CAN frames; {listed(recording.channels)}")
    bad = Tally()
    bad.absorb(log.bad)
    items, seen, other = [], set(), log.other
    for frame in log.frames:
        key = (frame.t_s, frame.channel, frame.identifier, frame.data)
        try:
            item = codec.decode(frame.identifier, frame.data)
        except WrongLengthError as error:
            bad.add("cut short" if error.short else "too long", frame.line)
            continue
        if item is None:
            other += 1
        elif key in seen:
            bad.add("repeated", frame.line)
        else:
            seen.add(key)
            items.append(_Decoded(frame=frame, item=item))
    if not any(isinstance(i.item, EsrTarget) for i in items):
        source = "the shipped DBC" if dbc is None else str(dbc)
        raise InputError(recording.path, "", None, f"holds no ESR track frame (0x500 to 0x53F by {source}); {listed(recording.channels)}")
    return items, bad, other


def _buses(items: list[_Decoded]) -> list[str]:
    """By name, numbers in it as numbers."""
    return sorted({i.frame.channel for i in items}, key=lambda bus: [int(p) if p.isdecimal() else p for p in re.split(r"(\d+)", bus)])


def _scans(sector: Sector, items: list[_Decoded], vehicle: Vehicle, sensor: Sensor, gated: dict[str, int]) -> list[tuple[float, Scan]]:
    stamps, keys = [i.frame.t_s for i in items], [i.frame.identifier for i in items]
    period = usual_period(stamps, keys)
    place = mounting(sector, vehicle)
    scans, working = [], True
    for group in cycles(stamps, keys, period):
        detections = []
        for item in (items[k].item for k in group):
            if isinstance(item, EsrHealth):
                working = item.working
            elif isinstance(item, EsrTarget):
                if item.status.measured:
                    detections.append(detection_of(item, sensor))
                else:
                    reason = item.status.name.lower().replace("_", " ")
                    gated[reason] = gated.get(reason, 0) + 1
        scan = Scan(
            sensor=f"esr-{sector.value}", sector=sector, t_s=stamps[group[0]], mounting=place, radar=tuple(detections),
            working=working, period_s=period,
        )  # fmt: skip
        scans.append((max(stamps[k] for k in group), scan))
    return scans


def detection_of(target: EsrTarget, sensor: Sensor) -> RadarDetection:
    """What a slot says, with the standard deviations of `sensor`: the CAN interface carries none."""
    return echo(sensor, target.range_m, target.azimuth_rad, target.range_rate_mps)


def _target(slot: int, detection: RadarDetection) -> EsrTarget:
    plain = EsrTarget(slot=slot, status=TargetStatus.UPDATED)
    return replace(plain, range_m=detection.range_m, azimuth_rad=detection.azimuth_rad, range_rate_mps=detection.range_rate_mps)
