"""Which bodies a radar sees: field of view and occlusion."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Mounting, RadarDetection
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.sensor import Sensor
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.radar import sensor_velocity
from mcdas_opt.geometry.rectangle import corners
from mcdas_opt.geometry.window import REACH_M, frame_near

_TINY = 1e-12


class View:
    """The plane around the host at one instant, for every sensor that looks then."""

    def __init__(self, host: HostState, bodies: Sequence[Body], vehicle: Vehicle, road: Road) -> None:
        self.host, self.bodies, self._vehicle = host, bodies, vehicle
        self._near = [i for i, body in enumerate(bodies) if abs(body.s_m - host.s_m) < REACH_M]
        poses = [(host.s_m, host.d_m, host.heading_rad)]
        poses += [(bodies[i].s_m, bodies[i].d_m, bodies[i].heading_rad) for i in self._near]
        if not road.is_straight:
            plane = frame_near(road, host.s_m).to_plane(*np.array(poses).T)
            poses = list(zip(*(column.tolist() for column in plane), strict=True))
        self._host_pose, self._poses = poses[0], poses[1:]
        self._shapes: list[Array] | None = None

    def detections(self, radar: Sensor, place: Mounting) -> list[tuple[int, RadarDetection]]:
        """(index, noise-free detection) of the bodies in sight: in the field of view, and nobody across the line of sight.

        The point lies where the line of sight to the body's centre enters the body (geometry.near_face); a body counts as hidden when
        that line is cut, even if a corner peeps out. The range rate is the relative velocity on the line of sight: the body's along its
        heading (its own yaw rate is left out: the point moves as the centre does), the sensor's by the rear axle's speed, along the body
        and, where that slips, sideways, and the yaw rate.
        """
        if not self._near:
            return []
        eye, own, yaw = self._looking(place)
        seen: list[tuple[int, RadarDetection]] = []
        for k, (i, (bx, by, angle)) in enumerate(zip(self._near, self._poses, strict=True)):
            body = self.bodies[i]
            ahead, aside = bx - eye[0], by - eye[1]
            bearing = math.atan2(aside, ahead)
            azimuth = math.remainder(bearing - yaw - place.yaw_rad, 2.0 * math.pi)
            if not radar.sees(radar.range_min_m, azimuth):  # no beam looks that way
                continue
            distance = math.hypot(ahead, aside) - _half_extent(bearing - angle, body.length_m, body.width_m)
            if not radar.sees(distance, azimuth):
                continue
            u = (math.cos(bearing), math.sin(bearing))
            if self._hidden(k, eye, (eye[0] + distance * u[0], eye[1] + distance * u[1])):
                continue
            moving = (body.speed_mps * math.cos(angle), body.speed_mps * math.sin(angle))
            rate = float(np.array(u) @ np.array((moving[0] - own[0], moving[1] - own[1])))
            seen.append((i, echo(radar, distance, azimuth, rate)))
        return seen

    def reflection(self, i: int, share: float, radar: Sensor, place: Mounting) -> RadarDetection:
        """A noise-free point of body i on its long axis: share 0 is the end that is nearer to the sensor, 1 the other end."""
        body, (bx, by, angle) = self.bodies[i], self._poses[self._near.index(i)]
        eye, own, yaw = self._looking(place)
        axis = math.cos(angle), math.sin(angle)
        near = 1.0 if (eye[0] - bx) * axis[0] + (eye[1] - by) * axis[1] > 0.0 else -1.0
        along = near * (0.5 - share) * body.length_m
        ahead, aside = bx + along * axis[0] - eye[0], by + along * axis[1] - eye[1]
        bearing, distance = math.atan2(aside, ahead), math.hypot(ahead, aside)
        closing = (body.speed_mps * axis[0] - own[0]) * math.cos(bearing) + (body.speed_mps * axis[1] - own[1]) * math.sin(bearing)
        return echo(radar, distance, math.remainder(bearing - yaw - place.yaw_rad, 2.0 * math.pi), closing)

    def _looking(self, place: Mounting) -> tuple[tuple[float, float], tuple[float, float], float]:
        """Where a sensor is, its velocity, and the host's heading, in the plane."""
        x, y, yaw = self._host_pose
        c, s = math.cos(yaw), math.sin(yaw)
        slip, yaw_rate = self.host.turning(self._vehicle.wheelbase_m)
        no_slip = sensor_velocity(self.host.speed_mps, yaw_rate, yaw, self._vehicle.centre_m + place.x_m, place.y_m, math)
        eye = (x + place.x_m * c - place.y_m * s, y + place.x_m * s + place.y_m * c)
        return eye, (no_slip[0] - slip * s, no_slip[1] + slip * c), yaw

    def _hidden(self, k: int, eye: tuple[float, float], point: tuple[float, float]) -> bool:
        """Whether another body than the k-th near one cuts the line from the eye to the point."""
        if len(self._near) < 2:
            return False
        if self._shapes is None:
            sizes = [(self.bodies[i].length_m, self.bodies[i].width_m) for i in self._near]
            self._shapes = corners(*np.array(self._poses).T, *np.array(sizes).T).tolist()
        return any(_cuts(eye, point, shape) for j, shape in enumerate(self._shapes) if j != k)


def echo(radar: Sensor, range_m: float, azimuth_rad: float, range_rate_mps: float) -> RadarDetection:
    """What a radar measures, with its standard deviations."""
    return RadarDetection(
        range_m=range_m,
        azimuth_rad=azimuth_rad,
        range_rate_mps=range_rate_mps,
        range_sd_m=radar.range_sd_m,
        azimuth_sd_rad=radar.azimuth_sd_rad,
        range_rate_sd_mps=radar.range_rate_sd_mps,
    )


def _half_extent(bearing: float, length: float, width: float) -> float:
    """`near_face.half_extent` of one bearing."""
    along = 0.5 * length / max(abs(math.cos(bearing)), _TINY)
    return min(along, 0.5 * width / max(abs(math.sin(bearing)), _TINY))


def _cuts(start: tuple[float, float], end: tuple[float, float], shape: Sequence[Sequence[float]]) -> bool:
    """Whether the segment meets the rectangle with corners (4, 2): clipped against the slab between each pair of opposite edges."""
    low, high = 0.0, 1.0
    for near, far in ((shape[1], shape[0]), (shape[2], shape[1])):
        ax, ay = far[0] - near[0], far[1] - near[1]
        span = ax * ax + ay * ay
        a = (start[0] - near[0]) * ax + (start[1] - near[1]) * ay
        b = (end[0] - near[0]) * ax + (end[1] - near[1]) * ay
        if a == b:
            if not 0.0 <= a <= span:
                return False
            continue
        t0, t1 = sorted((-a / (b - a), (span - a) / (b - a)))
        low, high = max(low, t0), min(high, t1)
    return low <= high
