"""Sensors of the simulated host: radars with seeded noise, ideal ones, and sectors without any."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from mcdas_opt.catalogue.sensors import IDEAL, NONE, load_sensor
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, Mounting, RadarDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.sensor import Sensor
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.simulation.sensor_faults import SectorFaults, SensorFaults
from mcdas_opt.simulation.sight import View

IDEAL_PERIOD_S = 0.05
IDEAL_REACH_M = 60.0  # of the ideal side sensors, along the road, either way


class SectorSensors(Protocol):
    """Which sensor looks into a sector: "ideal", "none" or a sensor file (a scene's [sensors])."""

    def of(self, sector: Sector) -> str: ...


def mounting(sector: Sector, vehicle: Vehicle) -> Mounting:
    """Bumper for front and rear, middle of the flank for the sides, looking straight out."""
    half_length, half_width = 0.5 * vehicle.length_m, 0.5 * vehicle.width_m
    return {
        Sector.FRONT: Mounting(x_m=half_length),
        Sector.REAR: Mounting(x_m=-half_length, yaw_rad=math.pi),
        Sector.LEFT: Mounting(y_m=half_width, yaw_rad=0.5 * math.pi),
        Sector.RIGHT: Mounting(y_m=-half_width, yaw_rad=-0.5 * math.pi),
    }[sector]


@dataclass(slots=True)
class _Post:
    """A sector's sensor, its own noise stream, and how many of its scans have been due."""

    sector: Sector
    radar: Sensor | None
    random: np.random.Generator
    place: Mounting
    began_s: float | None = None
    count: int = 0

    @property
    def name(self) -> str:
        return IDEAL if self.radar is None else self.radar.name

    @property
    def period_s(self) -> float:
        return IDEAL_PERIOD_S if self.radar is None else self.radar.period_s

    def is_due(self, t: float) -> bool:
        """Whether a scan is due at t."""
        return self.began_s is None or self.began_s + self.count * self.period_s <= t + 1e-9

    def takes(self, t: float) -> bool:
        """As `is_due`, and counts the scan; scans missed since the last call are not made up for."""
        if not self.is_due(t):
            return False
        if self.began_s is None:
            self.began_s = t
        self.count = math.floor((t - self.began_s) / self.period_s + 1e-6) + 1
        return True


class SensorSuite:
    """The host's four sectors. Deterministic: the same calls with the same seed give the same scans.

    Each sector draws from a stream of its own, a fixed number of values per body and scan, so that neither another sensor nor what
    the host does changes the noise.
    """

    def __init__(
        self,
        sensors: SectorSensors,
        vehicle: Vehicle,
        road: Road,
        seed: int,
        beside: Path | None = None,
        faults: SensorFaults | None = None,
    ) -> None:
        """`beside` is the folder in which sensor files are also sought. Raises `InputError` for an unknown sensor."""
        self._faults = faults
        self._at_fault = {} if faults is None else {sector: SectorFaults(faults, sector, seed) for sector in Sector}
        self._vehicle = vehicle
        self._road = road
        streams = np.random.SeedSequence(seed).spawn(len(Sector))
        self._posts: list[_Post] = []
        for sector, stream in zip(Sector, streams, strict=True):
            name = sensors.of(sector)
            if name != NONE:
                radar = None if name == IDEAL else load_sensor(name, beside)
                self._posts.append(_Post(sector, radar, np.random.default_rng(stream), mounting(sector, vehicle)))

    def is_due(self, t: float) -> bool:
        """Whether any scan is due at t."""
        return any(post.is_due(t) for post in self._posts)

    def scans(self, t: float, host: HostState, bodies: Sequence[Body]) -> tuple[Scan, ...]:
        """The scans due at t, of the world as it is at t. The first call starts every sensor's clock."""
        due = [post for post in self._posts if post.takes(t)]
        if not due:
            return ()
        view = View(host, bodies, self._vehicle, self._road)
        return tuple(scan for scan in (self._scan(post, t, view) for post in due) if scan is not None)

    def _scan(self, post: _Post, t: float, view: View) -> Scan | None:
        place, bodies = post.place, view.bodies
        if post.radar is None:
            seen_bodies = ideal_detections(post.sector, view.host, bodies, self._vehicle)
            said = Scan(sensor=post.name, sector=post.sector, t_s=t, mounting=place, period_s=post.period_s, bodies=seen_bodies)
            return said if self._faults is None else self._at_fault[post.sector].of(said, (), None)
        normal = post.random.standard_normal((len(bodies), 3))
        luck = post.random.random(len(bodies))
        seen = view.detections(post.radar, place)
        shown = [(i, _with_noise(echo, normal[i])) for i, echo in seen if luck[i] < post.radar.detection_probability]
        if self._faults is not None and self._faults.reflections > 1:
            shown += [one for i, _ in shown for one in self._more_reflections(i, post, view)]
        noisy = tuple(point for _, point in shown)
        scan = Scan(
            sensor=post.name,
            sector=post.sector,
            t_s=t,
            mounting=place,
            period_s=post.period_s,
            radar=noisy,
            blind=post.radar.blind,
        )
        if self._faults is None:
            return scan
        first: dict[int, str] = {}
        names = tuple(first.setdefault(i, bodies[i].name) if i not in first else f"{bodies[i].name} {k}" for k, (i, _) in enumerate(shown))
        return self._at_fault[post.sector].of(scan, names, post.radar)

    def _more_reflections(self, i: int, post: _Post, view: View) -> Iterator[tuple[int, RadarDetection]]:
        """Of a body that is seen: further points along it."""
        assert self._faults is not None
        assert post.radar is not None
        count = self._faults.reflections - 1
        for share in (np.arange(count) + 1.0) / count:
            yield i, view.reflection(i, float(share), post.radar, post.place)


def ideal_detections(sector: Sector, host: HostState, bodies: Sequence[Body], vehicle: Vehicle) -> tuple[BodyDetection, ...]:
    """Every neighbour whose centre lies beyond the bumper, or beyond the flank within `IDEAL_REACH_M` along the road."""

    def holds(body: Body) -> bool:
        ahead, left = body.s_m - host.s_m, body.d_m - host.d_m
        if sector in (Sector.FRONT, Sector.REAR):
            return (ahead if sector is Sector.FRONT else -ahead) > 0.5 * vehicle.length_m
        return (left if sector is Sector.LEFT else -left) > 0.5 * vehicle.width_m and abs(ahead) <= IDEAL_REACH_M

    return tuple(
        BodyDetection(
            name=body.name,
            s_m=body.s_m,
            d_m=body.d_m,
            speed_s_mps=body.speed_along_mps,
            speed_d_mps=body.speed_across_mps,
            length_m=body.length_m,
            width_m=body.width_m,
            heading_rad=body.heading_rad,
            kind=body.kind,
        )
        for body in bodies
        if holds(body)
    )


def _with_noise(point: RadarDetection, normal: Array) -> RadarDetection:
    return replace(
        point,
        range_m=max(point.range_m + point.range_sd_m * float(normal[0]), 0.0),
        azimuth_rad=point.azimuth_rad + point.azimuth_sd_rad * float(normal[1]),
        range_rate_mps=point.range_rate_mps + point.range_rate_sd_mps * float(normal[2]),
    )
