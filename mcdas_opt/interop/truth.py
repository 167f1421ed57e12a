"""Tracks of a replay against the truth behind the recording: errors, breaks, and the raw detections' errors beside them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.catalogue.data_files import find
from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.measurement import Mounting
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError
from mcdas_opt.geometry.near_face import half_extent
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.interop.recordings.csv_table import CsvTable
from mcdas_opt.interop.replay_record import Cycle, Replay, SeenTrack

GATE_M = 5.0  # a track farther from the true point than this is another object
GAP_S = 0.5  # truth is not interpolated over a longer silence


@dataclass(frozen=True, slots=True, kw_only=True)
class TrueTarget:
    """Antenna to the target's nearest point, over time: (n,) each. Azimuth [rad] is ISO 8855 in the radar's own frame, NaN: nobody."""

    t_s: Array
    range_m: Array
    azimuth_rad: Array
    range_rate_mps: Array

    def at(self, t_s: Array, mounting: Mounting) -> tuple[Array, Array]:
        """((m, 2) positions in the host's frame from the radar [m], (m,) range rates); NaN where the truth says nothing."""
        after = np.clip(np.searchsorted(self.t_s, t_s), 1, self.t_s.size - 1)
        spoken = (t_s >= self.t_s[0] - 1e-6) & (t_s <= self.t_s[-1] + 1e-6) & (self.t_s[after] - self.t_s[after - 1] <= GAP_S)
        bearing = mounting.yaw_rad + self.azimuth_rad
        x, y, rate = (
            np.where(spoken, np.interp(t_s, self.t_s, column), np.nan)
            for column in (self.range_m * np.cos(bearing), self.range_m * np.sin(bearing), self.range_rate_mps)
        )
        return np.column_stack([x, y]), np.where(np.isfinite(x), rate, np.nan)


@dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """Root mean squares over `samples` instants; None without any. Along and across are the host's axes."""

    samples: int
    along_rmse_m: float | None
    across_rmse_m: float | None
    range_rate_rmse_mps: float | None

    @classmethod
    def of(cls, errors: Array) -> Errors:
        """From (n, 3) errors along, across and in range rate; rows with NaN are instants without a pair."""
        whole = errors[np.all(np.isfinite(errors), axis=1)]
        if not len(whole):
            return cls(samples=0, along_rmse_m=None, across_rmse_m=None, range_rate_rmse_mps=None)
        along, across, rate = (float(v) for v in np.sqrt(np.mean(whole**2, axis=0)))
        return cls(samples=len(whole), along_rmse_m=along, across_rmse_m=across, range_rate_rmse_mps=rate)


@dataclass(frozen=True, slots=True, kw_only=True)
class SectorComparison:
    """One radar's target. `breaks`: how often its track was lost or changed its name; `covered`: share of its cycles with a track.

    The compared point is the one that the radar sees, the assumed body's near face, so that the body's assumed length cancels.
    The arrays have a row per cycle, (n, 3): along and across from the radar [m] and range rate [m/s], true, tracked, and the standard
    deviations that the tracker claims (speed along for the range rate); `raw_errors` has one per scan, at `raw_t_s`. NaN: none.
    """

    tracked: Errors
    raw: Errors
    breaks: int
    covered: float
    first_covered_s: float | None
    t_s: Array = field(repr=False)
    true_points: Array = field(repr=False)
    tracked_points: Array = field(repr=False)
    tracked_sds: Array = field(repr=False)
    raw_t_s: Array = field(repr=False)
    raw_errors: Array = field(repr=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """By sector; only sectors with both a log and a truth."""

    sectors: dict[Sector, SectorComparison]

    def to_dict(self) -> dict[str, Any]:
        document: dict[str, Any] = to_document(self.sectors)
        return document


def read_truth(path: str | Path) -> dict[Sector, TrueTarget]:
    """From a CSV with `t` (or `t_s`) and, for front and rear, `front_range`, `front_azimuth_deg` (clockwise positive),
    `front_range_rate` ...; empty cells where nobody was there. Raises `InputError` naming the line or the missing column."""
    table = CsvTable(path)
    present = [sector for sector in (Sector.FRONT, Sector.REAR) if f"{sector.value}_range" in table.header]
    if not present:
        table.column("front_range", "rear_range")
    columns = [table.column("t_s", "t")]
    for sector in present:
        columns += [table.column(f"{sector.value}_{name}") for name in ("range", "azimuth_deg", "range_rate")]
    rows = table.sound_rows(columns)
    values = np.array([row.values for row in rows])
    late = np.flatnonzero(~(np.diff(values[:, 0], prepend=-math.inf) > 0.0))
    if late.size or len(rows) < 2:
        line = rows[int(late[0])].line if late.size else rows[0].line
        raise InputError(path, f"line {line}", None, "needs at least two rows whose times increase")
    targets = {}
    for k, sector in enumerate(present):
        distance, azimuth, rate = values[:, 1 + 3 * k : 4 + 3 * k].T
        targets[sector] = TrueTarget(t_s=values[:, 0], range_m=distance, azimuth_rad=-np.radians(azimuth), range_rate_mps=rate)
    return targets


def compare(replay: Replay, truth: str | Path | Mapping[Sector, TrueTarget]) -> Comparison:
    """Every cycle's nearest track, and every scan's nearest detection, against the true point of their sector.

    `truth` is a file (see `read_truth`), the name of a shipped recording, or the targets themselves. Raises `InputError` where truth
    and recording have no sector or no time in common.
    """
    targets = truth if isinstance(truth, Mapping) else read_truth(find("logs", str(truth), ".truth.csv"))
    sectors = {s: _compare(replay, s, targets[s]) for s in replay.log.sectors if s in targets}
    if not any(np.isfinite(c.true_points).any() for c in sectors.values()):
        name = "truth" if isinstance(truth, Mapping) else truth
        raise InputError(name, "", None, "has no sector or no time in common with the recording")
    return Comparison(sectors=sectors)


def _compare(replay: Replay, sector: Sector, target: TrueTarget) -> SectorComparison:
    mounting = replay.mounting(sector)
    times = np.array([cycle.t_s for cycle in replay.cycles])
    true = np.column_stack(target.at(times, mounting))
    tracked, sds = np.full_like(true, np.nan), np.full_like(true, np.nan)
    names: list[str | None] = []
    for k, cycle in enumerate(replay.cycles):
        found = _nearest([near_point(track, cycle, mounting, replay) for track in cycle.tracks], true[k])
        names.append(None if found is None else cycle.tracks[found[0]].id)
        if found is not None:
            tracked[k] = found[1]
            sds[k] = np.sqrt(np.diag(cycle.tracks[found[0]].covariance))[[0, 2, 1]]
    raw_times, raw = _raw_errors(replay, sector, target, mounting)
    there = np.isfinite(true[:, 0])
    had = np.array([name is not None for name in names]) & there
    return SectorComparison(
        tracked=Errors.of(tracked - true),
        raw=Errors.of(raw),
        breaks=_breaks([name for name, present in zip(names, there, strict=True) if present]),
        covered=float(had.sum() / there.sum()) if there.any() else 0.0,
        first_covered_s=float(times[had][0]) if had.any() else None,
        t_s=times,
        true_points=true,
        tracked_points=tracked,
        tracked_sds=sds,
        raw_t_s=raw_times,
        raw_errors=raw,
    )


def near_point(track: SeenTrack, cycle: Cycle, mounting: Mounting, replay: Replay) -> Array:
    """(3,): the point of a track's assumed body that a radar at `mounting` sees, from the radar in the host's axes, and its range
    rate. The host's turning is left out of the range rate: it moves a bumper across the line of sight."""
    host = cycle.host
    frame = frame_near(replay.road, host.s_m)
    s, d = np.array([host.s_m, host.s_m + track.s_m]), np.array([host.d_m, host.d_m + track.d_m])
    x, y, yaw = frame.to_plane(s, d, np.array([host.heading_rad, 0.0]))
    turn = np.array([[math.cos(yaw[0]), math.sin(yaw[0])], [-math.sin(yaw[0]), math.cos(yaw[0])]])
    centre = turn @ np.array([x[1] - x[0], y[1] - y[0]]) - [mounting.x_m, mounting.y_m]
    distance = math.hypot(*centre)
    if distance == 0.0:
        return np.full(3, np.nan)
    sight, heading = centre / distance, float(yaw[1] - yaw[0])
    ahead, left = track.speed_s_mps, track.speed_d_mps
    velocity = [
        ahead * math.cos(heading) - left * math.sin(heading) - host.speed_mps,
        ahead * math.sin(heading) + left * math.cos(heading),
    ]
    bearing = math.atan2(sight[1], sight[0]) - heading
    point = centre - sight * float(half_extent(bearing, track.length_m, track.width_m))
    return np.array([*point, float(sight @ velocity)])


def _nearest(points: Sequence[Array], true: Array) -> tuple[int, Array] | None:
    """Index and value of the point nearest to the true one, within the gate."""
    misses = [math.hypot(point[0] - true[0], point[1] - true[1]) for point in points]
    near = [k for k, miss in enumerate(misses) if miss <= GATE_M]
    if not near:
        return None
    best = min(near, key=misses.__getitem__)
    return best, points[best]


def _raw_errors(replay: Replay, sector: Sector, target: TrueTarget, mounting: Mounting) -> tuple[Array, Array]:
    """Times (m,) of the sector's scans and (m, 3) errors of their detections nearest to the truth."""
    scans = [scan for scan in replay.log.scans if scan.sector is sector]
    times = np.array([scan.t_s for scan in scans])
    true = np.column_stack(target.at(times, mounting))
    errors = np.full_like(true, np.nan)
    for k, scan in enumerate(scans):
        bearings = [mounting.yaw_rad + detection.azimuth_rad for detection in scan.radar]
        points = [
            np.array([d.range_m * math.cos(bearing), d.range_m * math.sin(bearing), d.range_rate_mps])
            for d, bearing in zip(scan.radar, bearings, strict=True)
        ]
        found = _nearest(points, true[k])
        if found is not None:
            errors[k] = found[1] - true[k]
    return times, errors


def _breaks(names: list[str | None]) -> int:
    """How often a target that had a track lost it, or got one of another name."""
    return sum(1 for before, now in pairwise(names) if before is not None and now != before)
