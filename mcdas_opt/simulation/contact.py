"""What ends a drive (contact, leaving the road), and how near the others came."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.edges import corners_beyond, knots_inside
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners, distance, separation
from mcdas_opt.geometry.window import REACH_M, frame_near

EDGE_SLACK_M = 0.02
TOUCH_WITHIN_M = 150.0
_SURELY_M = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """At each of n instants: whether each of N neighbours touches the host (N, n), and how far a corner of the host is beyond the road's
    edge or end (n,) [m], negative inside."""

    touching: NDArray[np.bool_]
    beyond_edge_m: Array


def surroundings(
    host: Array, neighbours: tuple[BodyMotion, ...], sizes: tuple[tuple[float, float], ...], vehicle: Vehicle, road: Road
) -> Surroundings:
    """Of the host's states (n, 6) against neighbours that move over the same n instants.

    Bodies touch in the plane, on a curved road too; nobody more than `TOUCH_WITHIN_M` away along the road touches (a ramp may pass over
    itself).
    """
    s = host[:, 0]
    frame = frame_near(road, float(s[0]))
    x, y, yaw = frame.to_plane(s, host[:, 1], host[:, 2])
    own = corners(x, y, yaw, vehicle.length_m, vehicle.width_m)
    places = np.array([(motion.s_m, motion.d_m, motion.heading_rad) for motion in neighbours]).reshape(-1, 3, len(s)).swapaxes(0, 1)
    lengths, widths = np.array(sizes).reshape(-1, 2).T
    apart = np.abs(places[0] - s)
    who, when = np.nonzero(apart < TOUCH_WITHIN_M)
    other_x, other_y, other_yaw = frame.to_plane(*places[:, who, when])
    reach = 0.5 * (np.hypot(lengths, widths) + math.hypot(vehicle.length_m, vehicle.width_m)) + _SURELY_M
    close = np.hypot(other_x - x[when], other_y - y[when]) <= reach[who]
    who, when = who[close], when[close]
    others = corners(other_x[close], other_y[close], other_yaw[close], lengths[who], widths[who])
    touching = np.zeros(apart.shape, dtype=np.bool_)
    touching[who, when] = separation(own[when], others) <= 0.0
    return Surroundings(touching=touching, beyond_edge_m=_beyond_edge(own, host, vehicle, road))


def is_free(host: Array, neighbours: tuple[BodyMotion, ...], sizes: tuple[tuple[float, float], ...], vehicle: Vehicle, road: Road) -> bool:
    """Whether the shadows of the bodies along and across a straight road alone rule out that anybody touches or leaves it.

    Sufficient, not necessary, and never true on a bent road, or where its edges change.
    """
    if not road.is_straight or road.edges is not None:
        return False
    s, d = host[:, 0], host[:, 1]
    turned = np.abs(host[:, 2])  # at least the sine; the cosine is at most 1
    along, across = 0.5 * (vehicle.length_m + vehicle.width_m * turned), 0.5 * (vehicle.width_m + vehicle.length_m * turned)
    if (d + across).max() > road.left_edge_m or (d - across).min() < road.right_edge_m:
        return False
    if road.road_end_s_m is not None and (s + along).max() > road.road_end_s_m:
        return False
    for motion, (length, width) in zip(neighbours, sizes, strict=True):
        other = np.abs(motion.heading_rad)
        gap = np.abs(motion.s_m - s) - along - 0.5 * (length + width * other)
        beside = np.abs(motion.d_m - d) - across - 0.5 * (width + length * other)
        if np.maximum(gap, beside).min() <= _SURELY_M:
            return False
    return True


def clearances(
    host: Array,
    turns: Sequence[int],
    neighbours: tuple[BodyMotion, ...],
    sizes: tuple[tuple[float, float], ...],
    vehicle: Vehicle,
    road: Road,
) -> Array:
    """Distance to the nearest of the neighbours (n,) over a drive whose turns began at the instants `turns`, infinite without anybody.

    Distances are those of the bodies in the plane; on a curved road somebody more than `REACH_M` away counts with the distance along it. A
    turn's instants, but for its first, are measured in the piece of road around where it began, as `surroundings` does; the drive's first
    instant belongs to its first turn.
    """
    nearest = np.full(len(host), np.inf)
    pieces: list[tuple[FrenetFrame, int]] = []
    for first in turns:
        frame = frame_near(road, float(host[first, 0]))
        if not pieces or frame is not pieces[-1][0]:
            pieces.append((frame, first + 1 if pieces else 0))
    ends = [begin for _, begin in pieces[1:]] + [len(host)]
    for (frame, begin), end in zip(pieces, ends, strict=True):
        part = slice(begin, end)
        own = corners(*frame.to_plane(*host[part, :3].T), vehicle.length_m, vehicle.width_m)
        for motion, size in zip(neighbours, sizes, strict=True):
            apart = np.abs(motion.s_m[part] - host[part, 0])
            near = apart < (np.inf if road.is_straight else REACH_M - 50.0)  # enough for the plane
            place = (column[part][near] for column in (motion.s_m, motion.d_m, motion.heading_rad))
            other = corners(*frame.to_plane(*place), *size)
            gap = apart - 0.5 * (size[0] + vehicle.length_m)
            gap[near] = distance(own[near], other)
            nearest[part] = np.minimum(nearest[part], gap)
    return nearest


def _beyond_edge(own: Array, host: Array, vehicle: Vehicle, road: Road) -> Array:
    s = host[:, 0]
    x, y = own[..., 0], own[..., 1]
    guess = np.repeat(s[:, None], 4, axis=1)
    along, across, _ = frame_near(road, float(s[0])).to_road(x, y, np.zeros_like(x), guess_s_m=guess)
    beyond = np.maximum.reduce([*corners_beyond(along, across, road), *knots_inside(s, host[:, 1], host[:, 2], vehicle, road)])
    if road.road_end_s_m is not None:
        beyond = np.maximum(beyond, along.max(axis=1) - road.road_end_s_m)
    return np.asarray(beyond)


def relative_speed(host: Array, other: BodyMotion, vehicle: Vehicle, road: Road) -> float:
    """Speed [m/s] of the host's body centre relative to another body's centre; `host` is one state (6,), `other` one instant."""
    s, _, psi, v, _, delta = (float(q) for q in host)
    frame = frame_near(road, s)
    turn = vehicle.centre_m * np.tan(delta) / vehicle.wheelbase_m
    yaw = psi + float(frame.road_heading(np.array(s)))
    own = v * np.array([np.cos(yaw) - turn * np.sin(yaw), np.sin(yaw) + turn * np.cos(yaw)])
    theta = float(frame.road_heading(other.s_m))
    along = float(other.speed_s_mps) * (1.0 - float(other.d_m) * float(road.curvature_at(other.s_m)))
    across = float(other.speed_d_mps)
    theirs = np.array([along * np.cos(theta) - across * np.sin(theta), along * np.sin(theta) + across * np.cos(theta)])
    return float(np.linalg.norm(own - theirs))
