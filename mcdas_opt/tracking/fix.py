"""Fixes: detections turned into linear measurements of a body centre's state x = (s, vs, d, vd).

A radar detection becomes (s, d, relative speed on the line of sight): *converted*, not extended. The conversion depends on the
measurement alone and its error shrinks with the range, so that it is good where an extended filter is worst, beside the host (range
2 m, prior 0.5 m); its bias at long range is 7 mm (dynamics.radar.position_covariance). The range rate then is linear in the speeds
with the *measured* line of sight, the azimuth's error on it is in R. No Jacobian is taken at an uncertain state.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, Mounting, RadarDetection
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.radar import position, sensor_velocity
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.near_face import half_extent, half_extent_and_slope

Belief = tuple[Array, Array]  # state (s, vs, d, vd), covariance (4, 4)
LEAST_STRETCH = 0.2  # of 1 - d kappa
_HEADING_SD_RAD = 0.1  # of cars' headings against the road
_SLOWEST_MPS = 3.0  # below this the direction of motion says little about the heading


class Reading(NamedTuple):
    """z = H x + noise of covariance R: (m,), (m, 4), (m, m)."""

    z: Array
    H: Array
    R: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyFix:
    """An ideal sensor's word: the whole state (s, vs, d, vd)."""

    state: Array
    variance: Array

    @property
    def place(self) -> tuple[float, float]:
        """(s, d)"""
        return float(self.state[0]), float(self.state[2])

    def read(self, belief: Belief) -> Reading:
        return Reading(self.state, np.eye(4), np.diag(self.variance))


@dataclass(frozen=True, slots=True, kw_only=True)
class RadarFix:
    """A radar point as a body of `size` aligned with the road would have sent it (size None: the point is the centre).

    `place` is the centre (s, d), `range_m` its range, of which `extent_m` lies within the body; `bearing_rad` is the line of sight
    against the road there, `kappa` the road's curvature, `stretch` 1 - d kappa; `relative` is the range rate plus the sensor's own speed
    on the line of sight, `sideways` the sensor's speed to the left of it.
    """

    place: tuple[float, float]
    range_m: float
    extent_m: float
    bearing_rad: float
    kappa: float
    stretch: float
    relative: float
    sideways: float
    variance: Array  # of range, azimuth, range rate
    size: tuple[float, float] | None

    def read(self, belief: Belief) -> Reading:
        """The measurement for a target of that belief.

        Its heading turns the face that was seen: the believed heading atan(vd / vs) counts as far as its own variance says,
        against cars' habit to follow the road (0.1 rad). What stays uncertain of it goes into R, and so does the speed across the
        line of sight that the azimuth's error mixes into the range rate (in a bend also by taking the road's direction elsewhere).
        """
        _, vs, _, vd = belief[0].tolist()
        forward = vs * self.stretch
        along, across = math.cos(self.bearing_rad), math.sin(self.bearing_rad)
        shift, slope, doubt = 0.0, 0.0, 0.0
        if self.size is not None:
            speed = max(abs(forward), _SLOWEST_MPS)
            weight = _HEADING_SD_RAD**2 / (_HEADING_SD_RAD**2 + float(belief[1][3, 3]) / speed**2)
            seen = self.bearing_rad - weight * math.atan(vd / math.copysign(speed, forward))
            extent, slope = half_extent_and_slope(seen, *self.size)
            shift = extent - self.extent_m
            doubt = slope**2 * _HEADING_SD_RAD**2 * (1.0 - weight)
        r = self.range_m + shift
        s, d = self.place
        turned = vd * along - forward * across  # the target's speed to the left of the line of sight
        s_r, s_phi = along / self.stretch, (slope * along - r * across) / self.stretch
        d_r, d_phi = across, slope * across + r * along
        v_r = self.kappa * (turned * s_r + vs * along * d_r)
        v_phi = self.kappa * (turned * s_phi + vs * along * d_phi) + self.sideways - turned
        jacobian = np.array([[s_r, s_phi, 0.0], [d_r, d_phi, 0.0], [v_r, v_phi, 1.0]])
        variance = self.variance + np.array([doubt, 0.0, 0.0])
        return Reading(
            np.array([s + shift * along / self.stretch, d + shift * across, self.relative]),
            np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, self.stretch * along, 0.0, across]]),
            (jacobian * variance) @ jacobian.T,
        )


Fix = BodyFix | RadarFix


def body_fix(body: BodyDetection, frame: FrenetFrame, position_sd: float, speed_sd: float) -> BodyFix:
    """The state that an ideal detection states; its speed over ground along the road becomes ds/dt."""
    stretch = 1.0 - body.d_m * float(frame.road.curvature_at(body.s_m))
    state = np.array([body.s_m, body.speed_s_mps / stretch, body.d_m, body.speed_d_mps])
    p, v = position_sd**2, speed_sd**2
    return BodyFix(state=state, variance=np.array([p, v, p, v]))


@dataclass(frozen=True, slots=True, kw_only=True)
class Viewpoint:
    """Pose and velocity of a sensor in the plane, at the scan's time."""

    x: float
    y: float
    yaw: float
    vx: float
    vy: float
    host_s_m: float

    @classmethod
    def of(cls, mounting: Mounting, host: HostState, vehicle: Vehicle, frame: FrenetFrame) -> Viewpoint:
        """Where `mounting` is and how it moves: the speed of the rear axle (or `Vehicle.zero_sideslip_point_m` ahead of it), and the yaw
        rate v tan(delta) / L on the lever from there to the sensor."""
        x, y, yaw = host.s_m, host.d_m, host.heading_rad
        if not frame.road.is_straight:
            x, y, yaw = (float(q[0]) for q in frame.to_plane(np.array([x]), np.array([y]), np.array([yaw])))
        c, s = math.cos(yaw), math.sin(yaw)
        yaw_rate = host.speed_mps * math.tan(host.steering_rad) / vehicle.wheelbase_m
        vx, vy = sensor_velocity(host.speed_mps, yaw_rate, yaw, vehicle.centre_m + mounting.x_m, mounting.y_m, math)
        return cls(
            x=x + mounting.x_m * c - mounting.y_m * s,
            y=y + mounting.x_m * s + mounting.y_m * c,
            yaw=yaw + mounting.yaw_rad,
            vx=vx,
            vy=vy,
            host_s_m=host.s_m,
        )


def radar_fixes(
    detections: Sequence[RadarDetection], view: Viewpoint, frame: FrenetFrame, size: tuple[float, float] | None
) -> list[RadarFix | None]:
    """Fixes of bodies of `size` (length, width), aligned with the road; size None: the points are the centres.

    None stands for a point that has no place along the road (near or beyond its centre of curvature).
    """
    if not detections:
        return []
    r, phi = np.array([(point.range_m, point.azimuth_rad) for point in detections]).T
    theta = view.yaw + phi
    extent = np.zeros_like(r)
    if size is not None:  # the road's heading near the point is good enough for a first half extent
        extent = half_extent(theta - _heading_near(frame, view, r * np.cos(theta), r * np.sin(theta)), *size)
        r = r + extent
    x, y = position(r, phi, view.x, view.y, view.yaw, np)
    s, d, _ = frame.to_road(x, y, theta, near_s_m=view.host_s_m)
    bearing = theta - frame.road_heading(s)
    if size is not None and not frame.road.is_straight:
        for _ in range(2):  # now with the heading at the centre itself
            correction = half_extent(bearing, *size) - extent
            r, extent = r + correction, extent + correction
            stretch = 1.0 - d * frame.road.curvature_at(s)
            s, d = s + correction * np.cos(bearing) / stretch, d + correction * np.sin(bearing)
            bearing = theta - frame.road_heading(s)
    kappa = frame.road.curvature_at(s)
    stretch = 1.0 - d * kappa
    fixes: list[RadarFix | None] = []
    for i, point in enumerate(detections):
        ux, uy = math.cos(theta[i]), math.sin(theta[i])
        fix = RadarFix(
            place=(float(s[i]), float(d[i])),
            range_m=float(r[i]),
            extent_m=float(extent[i]),
            bearing_rad=float(bearing[i]),
            kappa=float(kappa[i]),
            stretch=float(stretch[i]),
            relative=point.range_rate_mps + ux * view.vx + uy * view.vy,
            sideways=ux * view.vy - uy * view.vx,
            variance=np.array([point.range_sd_m**2, point.azimuth_sd_rad**2, point.range_rate_sd_mps**2]),
            size=size,
        )
        fixes.append(fix if fix.stretch >= LEAST_STRETCH else None)
    return fixes


def _heading_near(frame: FrenetFrame, view: Viewpoint, dx: Array, dy: Array) -> Array:
    """The road's heading at a point (dx, dy) from the sensor, by its distance along the tangent at the host."""
    here = float(frame.road_heading(np.array([view.host_s_m]))[0])
    return frame.road_heading(view.host_s_m + dx * math.cos(here) + dy * math.sin(here))
