"""Where a track goes whose lane leads elsewhere than the host's road: along that lane."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Places, Track
from mcdas_opt.geometry.frenet import LEAST_STRETCH_MEASURED, FrenetFrame
from mcdas_opt.tracking.free_motion import TIMES_S, frame_for, heading_of, pace_of, tabulated, unwrapped, way_m
from mcdas_opt.tracking.plane import to_plane

_BESIDE_M, _ASKEW_RAD = 3.0, 1.2  # who is farther from its lane's middle, or turned farther from it, does not follow it
_SAMPLE_M, _BEHIND_M, _FARTHEST_M = 1.0, 5.0, 1000.0
_SETTLES_S = 0.5  # into the lane's direction, and from further off so near to its middle:
_KEEPS_M = 0.5
_KEEPS_MPS = 0.5  # who moves no faster across his lane keeps to it
_LOOKED_AT_M = 100.0  # of a lane, for its bends
_LEADS_OFF_M = 1.5  # a lane that stays nearer to its place across the road leads along it
_BEND_M, _TURN_MPS2 = 4.0, 4.0  # to either side of a place, over which a path of few points bends; and across, at most


def along_lane(track: Track, road: Road, rate_mps2: float = 0.0, lasts_s: float = 0.0) -> Callable[[Array], BodyMotion] | None:
    """The track's motion from its time on, if it follows its lane, as far beside the middle as it is now but for what it cuts a turn by,
    accelerating by that rate for so long; from the lane's end straight on. None where its lane is not known, or it does not follow it."""
    if track.lane_path_m is None:
        return None
    pace = pace_of(track, rate_mps2, lasts_s)
    frame = frame_for(track, road, float(pace.max()))
    (x, y, yaw), path = _in_the_plane(track, frame)
    forward = track.speed_s_mps * max(1.0 - track.d_m * float(road.curvature_at(track.s_m)), LEAST_STRETCH_MEASURED)
    speed = pace * math.hypot(forward, track.speed_d_mps)
    way = way_m(speed)
    stations, places, yaws = _sampled(path, (x, y), float(way[-1]))
    nearest = _nearest(places, x, y)
    (at_x, at_y), ahead = places[nearest], float(yaws[nearest])
    along, left = (float(off) for off in _turned(x - at_x, y - at_y, -ahead))
    askew = math.remainder(yaw - ahead, 2.0 * math.pi)
    if math.hypot(along, left) > _BESIDE_M or abs(askew) > _ASKEW_RAD:
        return None
    gone = stations[nearest] + way
    heading = np.interp(gone, stations, yaws)
    beyond, settling = np.maximum(gone - stations[-1], 0.0), np.exp(-TIMES_S / _SETTLES_S)
    kept_m = min(max(left, -_KEEPS_M), _KEEPS_M)
    off_x, off_y = _turned(along + beyond, kept_m + (left - kept_m) * settling, heading)
    poses = (
        np.interp(gone, stations, places[:, 0]) + off_x,
        np.interp(gone, stations, places[:, 1]) + off_y,
        heading + askew * settling,
    )
    return tabulated(road, frame, track.s_m, poses, (speed * np.cos(heading), speed * np.sin(heading)))


def keeps_to_lane(track: Track, road: Road) -> bool:
    """Whether somebody whose lane is known moves in its direction."""
    (x, y, yaw), path = _in_the_plane(track, frame_for(track, road))
    _, places, yaws = _sampled(path, (x, y), _SAMPLE_M)
    askew = yaw - float(yaws[_nearest(places, x, y)])
    return abs(math.hypot(track.speed_s_mps, track.speed_d_mps) * math.sin(askew)) <= _KEEPS_MPS


def leads_off(path: Places, d_m: float) -> bool:
    """Whether a lane leads elsewhere than along the road, of somebody at that place across it."""
    return max(abs(d - d_m) for _, d in path) > _LEADS_OFF_M


def bends_gently(track: Track, road: Road) -> bool:
    """Whether the lane of somebody, which is known, bends no more than he can drive through as fast as he is."""
    (x, y, _), path = _in_the_plane(track, frame_for(track, road))
    stations, _, yaws = _sampled(path, (x, y), _LOOKED_AT_M)
    bends = np.interp(stations + _BEND_M, stations, yaws) - np.interp(stations - _BEND_M, stations, yaws)
    sharpest = float(np.abs(bends).max()) / (2.0 * _BEND_M)
    return sharpest * (track.speed_s_mps**2 + track.speed_d_mps**2) <= _TURN_MPS2


def _in_the_plane(track: Track, frame: FrenetFrame) -> tuple[tuple[float, float, float], Array]:
    """Its (x, y, yaw), and (n, 2) of its lane, none where that is not known."""
    s, d = np.array([(track.s_m, track.d_m), *(track.lane_path_m or ())]).T.copy()
    x, y, yaw = to_plane(frame, s, d, np.full(s.shape, heading_of(track)))
    return (float(x[0]), float(y[0]), float(yaw[0])), np.column_stack([x[1:], y[1:]])


def _sampled(path: Array, place: tuple[float, float], ahead_m: float) -> tuple[Array, Array, Array]:
    """Stations, places (n, 2) and directions of a polyline, every metre or so: from a little before what is nearest to a place, as far as
    it is of matter."""
    steps = np.diff(path, axis=0)
    lengths = np.hypot(*steps.T)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    share = np.clip(((np.array(place) - path[:-1]) * steps).sum(axis=1) / np.maximum(lengths**2, 1e-12), 0.0, 1.0)
    off = np.hypot(*(path[:-1] + share[:, None] * steps - place).T)
    k = int(np.argmin(off))
    foot_m = float(along[k] + share[k] * lengths[k])
    begin_m, end_m = max(foot_m - _BEHIND_M, 0.0), min(foot_m + min(ahead_m, _FARTHEST_M) + _BEHIND_M, float(along[-1]))
    stations = np.linspace(begin_m, end_m, max(math.ceil((end_m - begin_m) / _SAMPLE_M), 2) + 1)
    places = np.column_stack([np.interp(stations, along, path[:, i]) for i in (0, 1)])
    ways = places[1:] - places[:-1]
    towards = np.concatenate([ways[:1], ways[1:] + ways[:-1], ways[-1:]])
    return stations, places, unwrapped(np.arctan2(towards[:, 1], towards[:, 0]))


def _nearest(places: Array, x: float, y: float) -> int:
    """Which of the places (n, 2) is nearest."""
    return int(np.argmin(np.hypot(places[:, 0] - x, places[:, 1] - y)))


def _turned(x: Array | float, y: Array | float, by_rad: Array | float) -> tuple[Array, Array]:
    c, s = np.cos(by_rad), np.sin(by_rad)
    return c * x - s * y, s * x + c * y
