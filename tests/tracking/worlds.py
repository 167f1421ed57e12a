"""Small worlds for the tracker: a host on a road, bodies with the truth of the filter's own model, scans of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.sensor import Sensor
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.simulation.sensors import ideal_detections, mounting
from mcdas_opt.simulation.sight import View

CAR = Vehicle()
ESR = load_sensor("delphi_esr")
STRAIGHT = Road(lanes_left=1, lanes_right=1)
BEND = Road(lanes_left=1, lanes_right=1, curvature=((0.0, 0.0), (40.0, 0.008), (200.0, 0.004)))


def host_at(t: float, road: Road = STRAIGHT, speed: float = 12.0) -> HostState:
    """In the lane's middle at constant speed, steering as the road bends."""
    s = speed * t
    return HostState(s_m=s, speed_mps=speed, steering_rad=math.atan(CAR.wheelbase_m * float(road.curvature_at(s))))


def body_of(x: Array, road: Road = STRAIGHT, name: str = "a", length: float = 4.5, width: float = 1.8) -> Body:
    """The body whose centre moves as x = (s, ds/dt, d, dd/dt) says, heading where it goes."""
    s, vs, d, vd = x
    along = vs * (1.0 - d * float(road.curvature_at(s)))
    return Body(name=name, s_m=s, d_m=d, heading_rad=math.atan2(vd, along), speed_mps=math.hypot(along, vd), length_m=length, width_m=width)


def noisy(point: RadarDetection, random: np.random.Generator) -> RadarDetection:
    a, b, c = random.standard_normal(3)
    return replace(
        point,
        range_m=point.range_m + point.range_sd_m * a,
        azimuth_rad=point.azimuth_rad + point.azimuth_sd_rad * b,
        range_rate_mps=point.range_rate_mps + point.range_rate_sd_mps * c,
    )


def dead_scan(sector: Sector, t_s: float) -> Scan:
    """What a sensor reports that does not work."""
    return Scan(sensor="delphi_esr", sector=sector, t_s=t_s, working=False, period_s=0.05)


def radar_scan(
    t: float,
    bodies: Sequence[Body],
    *,
    sector: Sector = Sector.FRONT,
    sensor: Sensor = ESR,
    road: Road = STRAIGHT,
    host: HostState | None = None,
    random: np.random.Generator | None = None,
) -> Scan:
    """What a radar in that sector sees at t; without `random` nothing is noisy."""
    place = mounting(sector, CAR)
    seen = View(host_at(t, road) if host is None else host, bodies, CAR, road).detections(sensor, place)
    points = tuple(point if random is None else noisy(point, random) for _, point in seen)
    return Scan(sensor=sensor.name, sector=sector, t_s=t, mounting=place, radar=points, period_s=sensor.period_s, blind=sensor.blind)


def ideal_scan(t: float, bodies: Sequence[Body], *, sector: Sector = Sector.FRONT, host: HostState | None = None) -> Scan:
    found = ideal_detections(sector, host_at(t) if host is None else host, bodies, CAR)
    return Scan(sensor="ideal", sector=sector, t_s=t, mounting=mounting(sector, CAR), bodies=found, period_s=0.05)


@dataclass(frozen=True)
class Step:
    """Truth at one scan of a target that moves as the filter's model says."""

    t: float
    x: Array


def model_motion(start: Sequence[float], random: np.random.Generator, steps: int, dt: float, along: float, across: float) -> list[Step]:
    """Accelerations constant over each dt, independent, with standard deviations `along` and `across`."""
    x = np.array(start, dtype=np.float64)
    path = []
    for k in range(steps):
        a, b = random.standard_normal(2) * (along, across)
        s, vs, d, vd = x
        x = np.array([s + vs * dt + 0.5 * a * dt**2, vs + a * dt, d + vd * dt + 0.5 * b * dt**2, vd + b * dt])
        path.append(Step((k + 1) * dt, x))
    return path
