"""What the user is told, once, of measurements that nobody can be tracked by."""

from __future__ import annotations

import sys
import warnings
from dataclasses import dataclass, field

from mcdas_opt.domain.measurement import Scan
from mcdas_opt.errors import MeasurementWarning
from mcdas_opt.tracking.screening import AGE_MAX_S, LAG_MAX_S, MOST_DETECTIONS, RANGE_MAX_M, SPEED_MAX_MPS

_WHY = {
    "not_finite": "is not finite",
    "negative_range": "has a negative range",
    "implausible": f"is beyond {RANGE_MAX_M:g} m, {SPEED_MAX_MPS:g} m/s or half a turn, or off any road; metres, m/s, radians?",
    "future": "is of a time that is still to come",
    "stale": f"is more than {AGE_MAX_S:g} s old",
    "out_of_order": f"is older than this sensor's last, or than another's by more than {LAG_MAX_S:g} s",
}


@dataclass(slots=True)
class Notices:
    """Each kind is said once, by a `MeasurementWarning`; further ones are counted alone, under the counter of that name."""

    _said: set[str] = field(default_factory=set)

    def say(self, counter: str, what: str) -> None:
        """The warning names the caller's line, outside this package."""
        if counter not in self._said:
            self._said.add(counter)
            warnings.warn(f"{what} (said once; counted as `{counter}`)", MeasurementWarning, stacklevel=1 + _depth())


def _depth() -> int:
    """How many frames up, from `say` on, the caller from outside this package is."""
    frame, depth = sys._getframe(1), 0
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "mcdas_opt":
        frame, depth = frame.f_back, depth + 1
    return depth


def another_clock(scan: Scan, now: float) -> str:
    return (
        f"{_scan(scan)}: t_s = {scan.t_s!r} is {scan.t_s - now:.6g} s ahead of now = {now!r}, so that the scan is dropped: another clock, "
        "or milliseconds? Both are seconds of one clock"
    )


def long_cycles(apart_s: float) -> str:
    return (
        f"updates are {apart_s:.6g} s apart: nobody can be tracked over more than {AGE_MAX_S:g} s, so that no sector is covered. "
        "Milliseconds? `now` and the times of scans are seconds"
    )


def standing_clock(now: float) -> str:
    return (
        f"now = {now!r}: the clock stands, or runs to and fro, so that nobody can be tracked and no sector is covered. "
        "Each cycle needs its own time"
    )


def another_odometry(moved_m: float, driven_m: float, within_s: float) -> str:
    return (
        f"the host's place moved by {moved_m:.3g} m along the road within {within_s:.3g} s by the clock, in which its speed says "
        f"{driven_m:.3g} m: tracks are not relied on, so that no sector is covered. `s_m` and `d_m` are of each cycle's host; "
        "metres, m/s, seconds?"
    )


def unfollowed(scan: Scan, scans: int) -> str:
    return (
        f"{_scan(scan)}: a return has come in {scans} scans and no track comes of it, so that its range rates are not believed until "
        "a minute after the last such scan, and the sensor covers nothing until a track comes of its place. Is the rate positive where the "
        "distance grows, in m/s? Are the host's place, speed and heading, the mounting and the clock right?"
    )


def range_rates(scan: Scan, too_high_mps: float) -> str:
    return (
        f"{_scan(scan)}: its range rates are {abs(too_high_mps):.2g} m/s too {'high' if too_high_mps > 0.0 else 'low'}, as its ranges "
        "change: they are not believed until a minute after this was last so, and cars are tracked by their places. Is the rate positive "
        "where the distance grows, in m/s, and not over ground? Are the scans' times right?"
    )


def too_many_detections(scan: Scan, detections: int) -> str:
    return (
        f"{_scan(scan)}: of {detections} detections the nearest {MOST_DETECTIONS} are followed, so that the sensor covers nothing. "
        "Group a radar's points into objects before"
    )


def refused(scan: Scan, fault: str, scans: int, now: float) -> str:
    return (
        f"{_scan(scan)}: nothing could be taken of {scans} scans in a row, so that the sensor covers nothing. "
        f"What the last one says, of t_s = {scan.t_s!r} at now = {now!r}, {_WHY[fault]}"
    )


def elsewhere(scan: Scan) -> str:
    return (
        f"{_scan(scan)}: every return comes from the other side of the car (mounting.yaw_rad = {scan.mounting.yaw_rad:.4g}), so that the "
        "scan is dropped and the sensor covers nothing. The yaw, or the sector, is wrong: a sensor that looks back has a yaw of pi"
    )


def two_scans_at_once(scan: Scan) -> str:
    return (
        f"{_scan(scan)}: two scans of t_s = {scan.t_s!r} say different things, so that the sensor covers nothing. Two sensors of one name?"
    )


def _scan(scan: Scan) -> str:
    return f"scan of {scan.sensor!r}, {scan.sector.value}"
