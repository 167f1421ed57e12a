"""Nearer than its least range a radar sees nobody: not seen where it could not be seen is no evidence of absence."""

from __future__ import annotations

import math

import numpy as np

from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.near_face import half_extent
from mcdas_opt.tracking.fix import Viewpoint

_SIGMAS = 2.0
_FRESH_S = 0.5  # that a body is still there in the dark is news only so often
_ANY_BEARING_RAD, _ANY_RATE_MPS = 10.0, 100.0  # standard deviations that say nothing


def unseen_near(
    place: tuple[float, float], sd_m: float, size: tuple[float, float] | None, scan: Scan, view: Viewpoint, frame: FrenetFrame
) -> RadarDetection | None:
    """What a scan says of a body of that `size` (length, width; None: a point), believed at (s, d) to `sd_m`, that it did not see but
    could not have seen: it is somewhere between the sensor and its least range. None where it would have been seen, or lies outside
    the beams, or where it is, is not known to half the least range.

    A range uniform in that interval (its standard deviation, length / sqrt 12, worth one look in `_FRESH_S`), of no bearing or speed.
    """
    blind = scan.blind
    if blind is None or sd_m > 0.5 * blind.range_max_m:
        return None
    x, y, yaw = place[0], place[1], 0.0
    if not frame.road.is_straight:
        x, y, yaw = (float(q[0]) for q in frame.to_plane(np.array([x]), np.array([y]), np.zeros(1)))
    bearing = math.atan2(y - view.y, x - view.x)
    distance = math.hypot(x - view.x, y - view.y) - (0.0 if size is None else float(half_extent(bearing - yaw, *size)))
    azimuth = math.remainder(bearing - view.yaw, 2.0 * math.pi)
    if not blind.holds(distance - _SIGMAS * sd_m, azimuth):
        return None
    reach = blind.range_max_m
    return RadarDetection(
        range_m=0.5 * reach,
        azimuth_rad=azimuth,
        range_rate_mps=0.0,
        range_sd_m=reach * math.sqrt(max(_FRESH_S / scan.period_s, 1.0) / 12.0),
        azimuth_sd_rad=_ANY_BEARING_RAD,
        range_rate_sd_mps=_ANY_RATE_MPS,
    )
