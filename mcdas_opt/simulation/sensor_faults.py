"""What real sensors do wrong: several reflections of a body, echoes twice, ghosts, false alarms, misses, lost scans, misalignment; and what
the host gets wrong about its own motion."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, RadarDetection, Scan
from mcdas_opt.domain.rules import finite, non_negative, require, whole, within
from mcdas_opt.domain.sensor import Sensor
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import ParameterError
from mcdas_opt.simulation.sight import echo

_MOST_REFLECTIONS = 16
_GHOST_FARTHER_M, _GHOST_ASIDE_M = (4.0, 15.0), (2.0, 6.0)  # of an echo that came by a second way, from the one that came straight
_CLUTTER_MPS = 15.0  # false alarms open or close in by up to so much
_TWICE_M, _TWICE_MPS = 0.5, 0.3  # standard deviations between two echoes of one body
_SLOWEST_MPS = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorFaults:
    """Shares are of 1, of each scan or detection by itself, except `ghosts`: of bodies, each of which has its ghost all along.

    `reflections` is how many points of a body a radar shows, the farthest at its far end. `yaw_rad` and `aside_m` turn and shift every
    sensor against where it is said to be. The host's speed is told wrong by a share, its yaw rate by an offset.
    """

    reflections: int = 1
    duplicates: float = 0.0
    ghosts: float = 0.0
    false_alarms_per_scan: float = 0.0
    missed: float = 0.0
    dropouts: float = 0.0
    yaw_rad: float = 0.0
    aside_m: float = 0.0
    host_speed_share: float = 0.0
    host_yaw_rate_radps: float = 0.0

    def __post_init__(self) -> None:
        if not 1 <= whole("reflections", self.reflections) <= _MOST_REFLECTIONS:
            raise ParameterError("reflections", self.reflections, f"must be a whole number from 1 to {_MOST_REFLECTIONS}")
        for name, value in (("duplicates", self.duplicates), ("ghosts", self.ghosts), ("missed", self.missed), ("dropouts", self.dropouts)):
            within(name, value, 0.0, 1.0)
        require(self, non_negative, "false_alarms_per_scan")
        within("yaw_rad", self.yaw_rad, -0.2, 0.2, "rad")
        within("aside_m", self.aside_m, -2.0, 2.0, "m")
        within("host_speed_share", self.host_speed_share, -0.5, 0.5)
        finite("host_yaw_rate_radps", self.host_yaw_rate_radps, "rad/s")

    def told(self, host: HostState, wheelbase_m: float) -> HostState:
        """The host's state as its own sensors tell it."""
        if self.host_speed_share == 0.0 and self.host_yaw_rate_radps == 0.0:
            return host
        turned = math.atan(wheelbase_m * self.host_yaw_rate_radps / max(host.speed_mps, _SLOWEST_MPS))
        steering = host.steering_rad + (turned if host.speed_mps > _SLOWEST_MPS else 0.0)
        return replace(host, speed_mps=host.speed_mps * (1.0 + self.host_speed_share), steering_rad=steering)


class SectorFaults:
    """The faults of one sector's sensor, drawn from a stream of their own: without faults a scan stays as it is."""

    def __init__(self, faults: SensorFaults, sector: Sector, seed: int) -> None:
        self._faults = faults
        self._random = np.random.default_rng([seed, 101, list(Sector).index(sector)])
        self._ghosts: dict[str, tuple[float, float] | None] = {}

    def of(self, scan: Scan, names: Sequence[str], radar: Sensor | None) -> Scan | None:
        """The scan as it arrives, None where it is lost. `names` are the bodies of its radar points, one each."""
        faults, random = self._faults, self._random
        if random.random() < faults.dropouts:
            return None
        if radar is None:
            bodies = [body for body in scan.bodies if random.random() >= faults.missed]
            return replace(scan, bodies=(*bodies, *self._twice_said(bodies)))
        points = [point for point in scan.radar if random.random() >= faults.missed]
        twice = [self._beside(point) for point in points if random.random() < faults.duplicates]
        known = dict(zip(names, scan.radar, strict=True))
        shown = [*points, *twice, *self._ghosts_of(known, radar), *self._false_alarms(radar)]
        return replace(scan, radar=tuple(self._misaligned(point) for point in shown))

    def _twice_said(self, bodies: Sequence[BodyDetection]) -> Iterator[BodyDetection]:
        for body in bodies:
            if self._random.random() < self._faults.duplicates:
                off = self._random.normal(0.0, _TWICE_M, 2)
                yield replace(body, name=f"{body.name} again", s_m=body.s_m + float(off[0]), d_m=body.d_m + 0.3 * float(off[1]))

    def _beside(self, point: RadarDetection) -> RadarDetection:
        off, faster = self._random.normal(0.0, _TWICE_M), self._random.normal(0.0, _TWICE_MPS)
        return replace(point, range_m=max(point.range_m + float(off), 0.0), range_rate_mps=point.range_rate_mps + float(faster))

    def _ghosts_of(self, points: dict[str, RadarDetection], radar: Sensor) -> Iterator[RadarDetection]:
        """Echoes by a second way: farther, to one side, with about the body's own range rate."""
        for name, point in points.items():
            if name not in self._ghosts:
                farther, aside = self._random.uniform(*_GHOST_FARTHER_M), self._random.uniform(*_GHOST_ASIDE_M)
                side = 1.0 if self._random.random() < 0.5 else -1.0
                self._ghosts[name] = (float(farther), float(side * aside)) if self._random.random() < self._faults.ghosts else None
            ghost = self._ghosts[name]
            if ghost is None:
                continue
            away = point.range_m + ghost[0]
            seen = replace(point, range_m=away, azimuth_rad=point.azimuth_rad + math.atan2(ghost[1], away))
            if radar.sees(seen.range_m, seen.azimuth_rad):
                yield seen

    def _false_alarms(self, radar: Sensor) -> Iterator[RadarDetection]:
        for _ in range(int(self._random.poisson(self._faults.false_alarms_per_scan))):
            beam = radar.beams[int(self._random.integers(len(radar.beams)))]
            bounds = (radar.range_min_m, beam.range_max_m), (-beam.half_angle_rad, beam.half_angle_rad), (-_CLUTTER_MPS, _CLUTTER_MPS)
            yield echo(radar, *(float(self._random.uniform(low, high)) for low, high in bounds))

    def _misaligned(self, point: RadarDetection) -> RadarDetection:
        """As a sensor says it that looks from so far to the left of where it is said to be, turned to the left."""
        faults = self._faults
        if faults.yaw_rad == 0.0 and faults.aside_m == 0.0:
            return point
        return replace(point, azimuth_rad=point.azimuth_rad - faults.yaw_rad - math.atan2(faults.aside_m, max(point.range_m, 1.0)))
