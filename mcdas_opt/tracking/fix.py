"""Fixes: detections turned into linear measurements of a body centre's state x = (s, vs, d, vd).

A radar detection becomes (s, d, relative speed on the line of sight): *converted*, not extended. The conversion depends on the
measurement alone and its error shrinks with the range, so that it is good where an extended filter is worst, beside the host (range
2 m, prior 0.5 m); its bias at long range is 7 mm (dynamics.radar.position_covariance). The range rate then is linear in the speeds
with the *measured* line of sight, the azimuth's error on it is in R. No Jacobian is taken at an uncertain state.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, Mounting, RadarDetection
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.radar import position, sensor_velocity
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.near_face import half_extent, half_extent_slope

_LEAST_STRETCH = 0.2  # of 1 - d kappa


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyFix:
    """An ideal sensor's word: the whole state, (4,)."""

    z: Array
    variance: Array
    H: Array = field(default_factory=lambda: np.eye(4))

    def noise(self, state: Array) -> Array:
        """(4, 4) R."""
        return np.diag(self.variance)


@dataclass(frozen=True, slots=True, kw_only=True)
class RadarFix:
    """z = (s, d, relative speed on the line of sight plus the sensor's own).

    `jacobian` (3, 3) is that of z by (range, azimuth, range rate) with a gap at [2, 1]: the speed that the azimuth's error mixes in,
    `swing` gives it as swing[0] - swing[1] vs - swing[2] vd.
    """

    z: Array
    H: Array
    variance: Array
    jacobian: Array
    swing: tuple[float, float, float]

    def noise(self, state: Array) -> Array:
        """(3, 3) R; it depends a little on the speeds believed."""
        J = self.jacobian.copy()
        J[2, 1] = self.swing[0] - self.swing[1] * state[1] - self.swing[2] * state[3]
        return np.asarray((J * self.variance) @ J.T)


Fix = BodyFix | RadarFix


def body_fix(body: BodyDetection, frame: FrenetFrame, position_sd: float, speed_sd: float) -> BodyFix:
    """The state that an ideal detection states; its speed over ground along the road becomes ds/dt."""
    stretch = 1.0 - body.d_m * float(frame.road.curvature_at(body.s_m))
    z = np.array([body.s_m, body.speed_s_mps / stretch, body.d_m, body.speed_d_mps])
    p, v = position_sd**2, speed_sd**2
    return BodyFix(z=z, variance=np.array([p, v, p, v]))


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
        """Where `mounting` is and how it moves: rear-axle speed, and the yaw rate v tan(delta) / L on the lever to the sensor."""
        x, y, yaw = (float(q[0]) for q in frame.to_plane(np.array([host.s_m]), np.array([host.d_m]), np.array([host.heading_rad])))
        c, s = np.cos(yaw), np.sin(yaw)
        yaw_rate = host.speed_mps * np.tan(host.steering_rad) / vehicle.wheelbase_m
        vx, vy = sensor_velocity(host.speed_mps, yaw_rate, yaw, vehicle.centre_m + mounting.x_m, mounting.y_m, np)
        return cls(
            x=x + mounting.x_m * c - mounting.y_m * s,
            y=y + mounting.x_m * s + mounting.y_m * c,
            yaw=yaw + mounting.yaw_rad,
            vx=float(vx),
            vy=float(vy),
            host_s_m=host.s_m,
        )


def radar_fixes(
    detections: Sequence[RadarDetection], view: Viewpoint, frame: FrenetFrame, size: tuple[float, float] | None
) -> list[RadarFix | None]:
    """Fixes of the centres of bodies of `size` (length, width), aligned with the road; size None: the points are the centres.

    None stands for a point that has no place along the road (near or beyond its centre of curvature).
    """
    if not detections:
        return []
    r, phi, rate = np.array([(p.range_m, p.azimuth_rad, p.range_rate_mps) for p in detections]).T
    theta = view.yaw + phi
    slope = np.zeros_like(r)
    if size is not None:  # the road's heading near the point is good enough for a first half extent
        extent = half_extent(theta - _heading_near(frame, view, r * np.cos(theta), r * np.sin(theta)), *size)
        r = r + extent
    x, y = position(r, phi, view.x, view.y, view.yaw, np)
    s, d, _ = frame.to_road(x, y, theta, near_s_m=view.host_s_m)
    bearing = theta - frame.road_heading(s)
    stretch = 1.0 - d * frame.road.curvature_at(s)
    if size is not None:  # now with the heading at the centre itself
        correction = half_extent(bearing, *size) - extent
        r, s, d = r + correction, s + correction * np.cos(bearing) / stretch, d + correction * np.sin(bearing)
        slope = half_extent_slope(bearing, *size)
    rows = zip(detections, s, d, r, rate, theta, bearing, stretch, slope, strict=True)
    return [_radar_fix(view, *row) if row[7] >= _LEAST_STRETCH else None for row in rows]


def _radar_fix(
    view: Viewpoint,
    point: RadarDetection,
    s: float,
    d: float,
    r: float,
    rate: float,
    theta: float,
    bearing: float,
    stretch: float,
    slope: float,
) -> RadarFix:
    ux, uy = math.cos(theta), math.sin(theta)  # line of sight u in the plane; n is u turned left
    along, across = math.cos(bearing), math.sin(bearing)  # u against the road
    return RadarFix(
        z=np.array([s, d, rate + ux * view.vx + uy * view.vy]),
        H=np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, stretch * along, 0.0, across]]),
        variance=np.array([point.range_sd_m**2, point.azimuth_sd_rad**2, point.range_rate_sd_mps**2]),
        jacobian=np.array(
            [
                [along / stretch, (slope * along - r * across) / stretch, 0.0],
                [across, slope * across + r * along, 0.0],
                [0.0, 0.0, 1.0],
            ]
        ),
        swing=(ux * view.vy - uy * view.vx, -stretch * across, along),
    )


def _heading_near(frame: FrenetFrame, view: Viewpoint, dx: Array, dy: Array) -> Array:
    """The road's heading at a point (dx, dy) from the sensor, by its distance along the tangent at the host."""
    here = float(frame.road_heading(np.array([view.host_s_m]))[0])
    return frame.road_heading(view.host_s_m + dx * math.cos(here) + dy * math.sin(here))
