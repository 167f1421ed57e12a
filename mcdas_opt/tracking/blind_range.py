"""A radar sees nobody nearer than its least range: a target missing there may still be there."""

from __future__ import annotations

import math

import numpy as np

from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.near_face import half_extent
from mcdas_opt.tracking.fix import Viewpoint

_SIGMAS = 2.0
_FRESH_S = 0.5  # between two such detections that count as independent
_ANY_RATE_MPS = 100.0  # a standard deviation that says nothing


def unseen_near(
    place: tuple[float, float], spread: Array, size: tuple[float, float] | None, scan: Scan, view: Viewpoint, frame: FrenetFrame
) -> RadarDetection | None:
    """The detection of a body that the scan does not show and could not show: it is somewhere in the blind fan before the sensor.

    The body has that `size` (length, width; None: a point) and is believed at `place` (s, d) with covariance `spread` (2, 2). None where
    the scan could have shown it, where it lies outside the fan, or where its distance is uncertain by more than half the fan's depth.

    Range and bearing uniform over the fan (standard deviations depth / sqrt 12 and half angle / sqrt 3), as if it were looked at once in
    `_FRESH_S`; nothing of its speed.
    """
    blind = scan.blind
    if blind is None:
        return None
    x, y, yaw = place[0], place[1], 0.0
    if not frame.road.is_straight:
        x, y, yaw = (float(q[0]) for q in frame.to_plane(np.array([x]), np.array([y]), np.zeros(1)))
    bearing = math.atan2(y - view.y, x - view.x)
    distance = math.hypot(x - view.x, y - view.y) - (0.0 if size is None else float(half_extent(bearing - yaw, *size)))
    azimuth = math.remainder(bearing - view.yaw, 2.0 * math.pi)
    sight, reach = np.array([math.cos(bearing - yaw), math.sin(bearing - yaw)]), blind.range_max_m
    sd_m = math.sqrt(max(float(sight @ spread @ sight), 0.0))
    if sd_m > 0.5 * reach or not blind.holds(distance - _SIGMAS * sd_m, azimuth):
        return None
    looks = max(_FRESH_S / scan.period_s, 1.0)
    return RadarDetection(
        range_m=0.5 * reach,
        azimuth_rad=0.0,
        range_rate_mps=0.0,
        range_sd_m=reach * math.sqrt(looks / 12.0),
        azimuth_sd_rad=blind.half_angle_rad * math.sqrt(looks / 3.0),
        range_rate_sd_mps=_ANY_RATE_MPS,
    )
