"""Whether the signs and units of a log are right: range rates against ranges, the host's speed against what stands, azimuths by themselves.

Nothing here looks at a single detection: a fault of sign or unit is in every row, noise and clutter are not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import InputError
from mcdas_opt.interop.host_motion import HostMotion
from mcdas_opt.interop.sensor_log import SensorLog, Source

_MPH, _KMH = 1.0 / 0.44704, 3.6
_RATES = {
    -1.0: "positive when closing",
    _KMH: "in km/h",
    -_KMH: "in km/h and positive when closing",
    _MPH: "in mph",
    -_MPH: "in mph and positive when closing",
}
_SPEEDS = {_KMH: "in km/h", _MPH: "in mph"}
_STRETCH_S = 1.0  # noise of 0.25 m at 10 Hz leaves 0.3 m/s of a slope over so long
_FASTEST_MPS, _BESIDE_M = 60.0, 1.5  # a target moves by no more than that from scan to scan, and this for its noise
_APART_S = 0.3  # scans farther apart do not follow one another
_LIVELY_MPS = 2.0  # slower ones say nothing of signs and units
_FEWEST, _FEWEST_STANDING, _FEWEST_POINTS = 5, 10, 100
_DENSE = 256  # detections of a scan; more are too many to tell apart
_FARTHEST_M, _FASTEST_SAID_MPS = 1000.0, 1000.0
_Seen = tuple[float, float, float, float]


def check_log(log: SensorLog, motion: HostMotion) -> None:
    """Raises `InputError`, naming file and column, where it is plain that a range rate has the wrong sign or unit or is over ground, that
    azimuths are no radians or point behind the radar, or that the host's speed is in km/h or mph.

    Plain is what nearly all evidence says; a log that holds too little of it passes. That left and right are exchanged shows nowhere.
    """
    found = []
    for sector in log.sectors:
        source = log.sources.get(sector, Source())
        scans = [scan for scan in log.scans if scan.sector is sector]
        _check_bearings([point.azimuth_rad for scan in scans for point in scan.radar], source)
        stretches = _stretches(scans)
        _check_rates(stretches, source)
        _check_relative(stretches, source, motion)
        found.append(stretches)
    _check_speed(np.vstack(found), motion)


def _check_bearings(azimuths: Sequence[float], source: Source) -> None:
    said = np.abs([azimuth for azimuth in azimuths if math.isfinite(azimuth)])
    if said.size < _FEWEST_POINTS:
        return
    if np.mean(said > math.pi + 1e-6) > 0.05:
        rule = f"is beyond pi in {np.mean(said > math.pi):.0%} of the detections: azimuths are in rad, in [-pi, pi]; are these degrees?"
        raise InputError(source.file, source.bearing, None, rule)
    if np.mean(said > 0.5 * math.pi) > 0.95:
        rule = "has the targets behind the radar: x points away from the car, ahead of a front radar and behind the car for a rear one"
        raise InputError(source.file, source.bearing, None, rule)


def _check_rates(stretches: Array, source: Source) -> None:
    slope, rate = stretches[:, 1], stretches[:, 2]
    lively = np.abs(slope) >= _LIVELY_MPS
    if np.count_nonzero(lively) < _FEWEST:
        return
    ratio = rate[lively] / slope[lively]
    middle = float(np.median(ratio))
    for factor, words in _RATES.items():
        if abs(middle - factor) < 0.1 * abs(factor) and np.mean(np.abs(ratio - factor) < np.abs(ratio - 1.0)) >= 0.8:
            rule = (
                f"is {middle:.2f} times the speed at which the ranges change (median of {ratio.size} stretches of {_STRETCH_S:g} s): it "
                f"seems to be {words}, and must be in m/s, positive when opening; --columns (of CAN: the DBC) turns signs and scales"
            )
            raise InputError(source.file, source.range_rate, None, rule)


def _check_relative(stretches: Array, source: Source, motion: HostMotion) -> None:
    own = np.interp(stretches[:, 0], motion.t_s, motion.speed_mps) * np.cos(stretches[:, 3])
    driving = np.abs(own) >= 2.0 * _LIVELY_MPS
    beyond = (stretches[:, 2] - stretches[:, 1])[driving]
    if beyond.size >= _FEWEST and np.mean(np.abs(beyond - own[driving]) < 0.25 * np.abs(own[driving])) >= 0.8:
        rule = (
            f"is the host's own speed more than the speed at which the ranges change ({beyond.size} stretches of {_STRETCH_S:g} s): it "
            "seems to be over ground, and must be relative to the host"
        )
        raise InputError(source.file, source.range_rate, None, rule)


def _check_speed(stretches: Array, motion: HostMotion) -> None:
    """Whatever stands comes nearer by v cos(bearing). Who is overtaken may do so by a third of that, but not at several speeds."""
    said = np.interp(stretches[:, 0], motion.t_s, motion.speed_mps)
    lively = np.abs(stretches[:, 2]) >= _LIVELY_MPS
    if not lively.any():
        return
    speed = said[lively]
    ratio = -speed * np.cos(stretches[lively, 3]) / stretches[lively, 2]
    true = np.count_nonzero(np.abs(ratio - 1.0) < 0.03)
    for factor, words in _SPEEDS.items():
        standing = np.abs(ratio - factor) < 0.03 * factor
        count = np.count_nonzero(standing)
        if count < max(_FEWEST_STANDING, ratio.size / 3, 5 * true) or speed[standing].max() < 1.3 * speed[standing].min():
            continue
        rule = (
            f"is {factor:.2f} times the speed at which standing objects come nearer ({count} of {ratio.size} stretches of "
            f"{_STRETCH_S:g} s): it seems to be {words}, and must be in m/s"
        )
        raise InputError(motion.source, "speed_mps", None, rule)


def _stretches(scans: Sequence[Scan]) -> Array:
    """(n, 4): time [s], slope of the range [m/s], mean range rate [m/s] and bearing from the car's axis [rad] of targets over a second."""
    rows = []
    for track in _followed(scans):
        t_s = track[:, 0]
        begin = 0
        while begin < len(track):
            end = int(np.searchsorted(t_s, t_s[begin] + _STRETCH_S))
            part = track[begin:end]
            since = part[:, 0] - part[:, 0].mean()
            if len(part) >= 5 and part[-1, 0] - part[0, 0] >= 0.5 * _STRETCH_S:
                rows.append((part[:, 0].mean(), since @ part[:, 1] / (since @ since), part[:, 2].mean(), part[:, 3].mean()))
            begin = end
    return np.array(rows).reshape(-1, 4)


def _followed(scans: Sequence[Scan]) -> list[Array]:
    """Targets from scan to scan, (n, 4) of time, range, range rate and bearing: only where no other is near enough to be taken for them.

    What is reported as range rate has no part in it.
    """
    done: list[list[_Seen]] = []
    tracks: list[list[_Seen]] = []
    before_s, before = -math.inf, np.empty((0, 2))
    for scan in scans:
        points = [point for point in scan.radar if _usable(point)]
        points = points if len(points) <= _DENSE else []
        bearings = [scan.mounting.yaw_rad + point.azimuth_rad for point in points]
        xy = np.array([(p.range_m * math.cos(b), p.range_m * math.sin(b)) for p, b in zip(points, bearings, strict=True)]).reshape(-1, 2)
        gone_on: dict[int, list[_Seen]] = {}
        if 0.0 < scan.t_s - before_s <= _APART_S:
            gap = xy[:, None, :] - before[None, :, :]
            near = np.hypot(gap[..., 0], gap[..., 1]) <= _BESIDE_M + _FASTEST_MPS * (scan.t_s - before_s)
            alone = near & (near.sum(axis=0, keepdims=True) == 1) & (near.sum(axis=1, keepdims=True) == 1)
            gone_on = {int(here): tracks[there] for here, there in zip(*np.nonzero(alone), strict=True)}
        tracks = [gone_on.get(k, []) for k in range(len(points))]
        done += [track for k, track in enumerate(tracks) if k not in gone_on]
        for track, point, bearing in zip(tracks, points, bearings, strict=True):
            track.append((scan.t_s, point.range_m, point.range_rate_mps, bearing))
        before_s, before = scan.t_s, xy
    return [np.array(track) for track in done]


def _usable(point: RadarDetection) -> bool:
    """Neither NaN nor absurd."""
    return 0.0 < point.range_m < _FARTHEST_M and abs(point.range_rate_mps) < _FASTEST_SAID_MPS and abs(point.azimuth_rad) <= math.pi
