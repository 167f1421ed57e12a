"""Sensors of the simulated host: radars with seeded noise, ideal ones, and sectors that nobody watches."""

from __future__ import annotations

import math
from collections.abc import Sequence
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
from mcdas_opt.dynamics.radar import sensor_velocity
from mcdas_opt.geometry.near_face import half_extent
from mcdas_opt.geometry.rectangle import corners
from mcdas_opt.geometry.window import REACH_M, frame_near

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


def dead_scan(sector: Sector, t_s: float, sensor: str = IDEAL, period_s: float = IDEAL_PERIOD_S) -> Scan:
    """What a sensor reports that is there and does not work."""
    return Scan(sensor=sensor, sector=sector, t_s=t_s, working=False, period_s=period_s)


@dataclass(slots=True)
class _Post:
    """A sector's sensor, its own noise stream, and how many of its scans have been due."""

    sector: Sector
    radar: Sensor | None
    random: np.random.Generator
    began_s: float | None = None
    count: int = 0

    @property
    def name(self) -> str:
        return IDEAL if self.radar is None else self.radar.name

    @property
    def period_s(self) -> float:
        return IDEAL_PERIOD_S if self.radar is None else self.radar.period_s

    def is_due(self, t: float) -> bool:
        """Whether a scan is due at t; scans missed since the last call are not made up for."""
        if self.began_s is None:
            self.began_s = t
        if self.began_s + self.count * self.period_s > t + 1e-9:
            return False
        self.count = math.floor((t - self.began_s) / self.period_s + 1e-6) + 1
        return True


class SensorSuite:
    """The host's four sectors. Deterministic: the same calls with the same seed give the same scans.

    Each sector draws from a stream of its own, a fixed number of values per body and scan, so that neither another sensor nor what
    the host does changes the noise.
    """

    def __init__(self, sensors: SectorSensors, vehicle: Vehicle, road: Road, seed: int, beside: Path | None = None) -> None:
        """`beside` is the folder in which sensor files are also sought. Raises `InputError` for an unknown sensor."""
        self._vehicle = vehicle
        self._road = road
        streams = np.random.SeedSequence(seed).spawn(len(Sector))
        self._posts: list[_Post] = []
        for sector, stream in zip(Sector, streams, strict=True):
            name = sensors.of(sector)
            if name != NONE:
                radar = None if name == IDEAL else load_sensor(name, beside)
                self._posts.append(_Post(sector, radar, np.random.default_rng(stream)))

    def scans(self, t: float, host: HostState, bodies: Sequence[Body]) -> tuple[Scan, ...]:
        """The scans due at t, of the world as it is at t. The first call starts every sensor's clock."""
        return tuple(self._scan(post, t, host, bodies) for post in self._posts if post.is_due(t))

    def _scan(self, post: _Post, t: float, host: HostState, bodies: Sequence[Body]) -> Scan:
        place = mounting(post.sector, self._vehicle)
        common = Scan(sensor=post.name, sector=post.sector, t_s=t, mounting=place, period_s=post.period_s)
        if post.radar is None:
            return replace(common, bodies=ideal_detections(post.sector, host, bodies, self._vehicle))
        normal = post.random.standard_normal((len(bodies), 3))
        luck = post.random.random(len(bodies))
        seen = radar_detections(post.radar, place, host, bodies, self._vehicle, self._road)
        noisy = (_with_noise(echo, normal[i]) for i, echo in seen if luck[i] < post.radar.detection_probability)
        return replace(common, radar=tuple(noisy))


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
        )
        for body in bodies
        if holds(body)
    )


def radar_detections(
    radar: Sensor, place: Mounting, host: HostState, bodies: Sequence[Body], vehicle: Vehicle, road: Road
) -> list[tuple[int, RadarDetection]]:
    """(index, noise-free detection) of the bodies in sight: in the field of view, and nobody across the line of sight.

    The point lies where the line of sight to the body's centre enters the body (geometry.near_face); a body counts as hidden when
    that line is cut, even if a corner peeps out. The range rate is the relative velocity on the line of sight: the body's along its
    heading (its own yaw rate is left out: the point moves as the centre does), the sensor's by rear-axle speed and yaw rate
    v tan(delta) / L.
    """
    frame = frame_near(road, host.s_m)
    near = [i for i, body in enumerate(bodies) if abs(body.s_m - host.s_m) < REACH_M]
    poses = [(host.s_m, host.d_m, host.heading_rad)] + [(bodies[i].s_m, bodies[i].d_m, bodies[i].heading_rad) for i in near]
    x, y, yaw = frame.to_plane(*np.array(poses).T)
    c, s = math.cos(yaw[0]), math.sin(yaw[0])
    eye = np.array([x[0] + place.x_m * c - place.y_m * s, y[0] + place.x_m * s + place.y_m * c])
    yaw_rate = host.speed_mps * math.tan(host.steering_rad) / vehicle.wheelbase_m
    own = sensor_velocity(host.speed_mps, yaw_rate, yaw[0], vehicle.centre_m + place.x_m, place.y_m, np)
    shapes = [
        corners(px, py, angle, bodies[i].length_m, bodies[i].width_m) for i, px, py, angle in zip(near, x[1:], y[1:], yaw[1:], strict=True)
    ]
    seen: list[tuple[int, RadarDetection]] = []
    for k, i in enumerate(near):
        body, angle = bodies[i], yaw[1 + k]
        line = np.array([x[1 + k], y[1 + k]]) - eye
        bearing = math.atan2(line[1], line[0])
        distance = math.hypot(line[0], line[1]) - float(half_extent(bearing - angle, body.length_m, body.width_m))
        azimuth = math.remainder(bearing - yaw[0] - place.yaw_rad, 2.0 * math.pi)
        if not radar.sees(distance, azimuth):
            continue
        u = np.array([math.cos(bearing), math.sin(bearing)])
        if any(_cuts(eye, eye + distance * u, shape) for j, shape in enumerate(shapes) if j != k):
            continue
        moving = body.speed_mps * np.array([math.cos(angle), math.sin(angle)])
        point = RadarDetection(
            range_m=distance,
            azimuth_rad=azimuth,
            range_rate_mps=float(u @ (moving - np.array(own))),
            range_sd_m=radar.range_sd_m,
            azimuth_sd_rad=radar.azimuth_sd_rad,
            range_rate_sd_mps=radar.range_rate_sd_mps,
        )
        seen.append((i, point))
    return seen


def _with_noise(point: RadarDetection, normal: Array) -> RadarDetection:
    return replace(
        point,
        range_m=max(point.range_m + point.range_sd_m * float(normal[0]), 0.0),
        azimuth_rad=point.azimuth_rad + point.azimuth_sd_rad * float(normal[1]),
        range_rate_mps=point.range_rate_mps + point.range_rate_sd_mps * float(normal[2]),
    )


def _cuts(start: Array, end: Array, shape: Array) -> bool:
    """Whether the segment meets the rectangle with corners (4, 2): clipped against the slab between each pair of opposite edges."""
    low, high = 0.0, 1.0
    for near, far in ((shape[1], shape[0]), (shape[2], shape[1])):
        axis = far - near
        span = float(axis @ axis)
        a, b = float((start - near) @ axis), float((end - near) @ axis)
        if a == b:
            if not 0.0 <= a <= span:
                return False
            continue
        t0, t1 = sorted((-a / (b - a), (span - a) / (b - a)))
        low, high = max(low, t0), min(high, t1)
    return low <= high
