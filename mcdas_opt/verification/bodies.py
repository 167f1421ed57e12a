"""Swept bodies: the host's rectangle against every neighbour's, at and between the fine steps."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import BodyMotion, PredictedBody
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners, half_extent
from mcdas_opt.geometry.sweep import swept_separation
from mcdas_opt.verification.finding import Findings
from mcdas_opt.verification.motion import Motion

# Bodies farther apart along the road than this many times their reach cannot touch on a road that keeps |d kappa| < 0.9: on an arc of
# radius R, seen at its innermost lane of radius 0.1 R, a half turn is pi R, and their chord exceeds the reach for R > 5 reaches. A road
# that turns full circle and comes back to its own place (a ramp above itself) is not a collision.
ALONG_REACHES = 16.0
_TOUCH_M = 1e-9
_PLAINLY_M = 0.05  # more than any corner's way bows out of its chord in 0.02 s (that is 1000 m/s^2)


def collisions(motion: Motion, vehicle: Vehicle, frame: FrenetFrame, bodies: Iterable[PredictedBody], found: Findings) -> None:
    """One violation for each neighbour that a host's body overlaps, in the order of contact: `t_s` is the first one, `value` the deepest
    separation [m]."""
    hit = Findings(len(found.of))
    for body in bodies:
        _collision(motion, vehicle, frame, body, hit)
    for violations, its in zip(found.of, hit.of, strict=True):
        violations += sorted(its, key=lambda one: (one.t_s, one.value))


def _collision(motion: Motion, vehicle: Vehicle, frame: FrenetFrame, body: PredictedBody, found: Findings) -> None:
    path = body.at(motion.node_t_s)
    if _unknown(range(len(found.of)), motion.node_t_s, path, body, found):
        return
    hosts, steps = _near(motion, frame, path, body, vehicle)
    if not steps.size:
        return
    x, y, yaw = (
        np.stack([node[hosts, steps], middle[hosts, steps], node[hosts, steps + 1]])
        for node, middle in (
            (motion.node_x_m, motion.middle_x_m),
            (motion.node_y_m, motion.middle_y_m),
            (motion.node_yaw_rad, motion.middle_yaw_rad),
        )
    )
    host = corners(x, y, yaw, vehicle.length_m, vehicle.width_m)
    half = body.at(motion.middle_t_s[steps])
    if _unknown(np.unique(hosts).tolist(), motion.middle_t_s[steps], half, body, found):
        return
    s, d, psi = (
        np.stack([node[steps], middle, node[steps + 1]])
        for node, middle in ((path.s_m, half.s_m), (path.d_m, half.d_m), (path.heading_rad, half.heading_rad))
    )
    x, y, yaw = frame.to_plane(s, d, psi)
    other = corners(x, y, yaw, body.length_m, body.width_m)
    gap = swept_separation(host[0], host[2], other[0], other[2]) - _bow(host) - _bow(other)
    hit = gap < -_TOUCH_M
    for which in np.unique(hosts[hit]).tolist():
        of_it = hosts == which
        first = motion.node_t_s[steps[int((of_it & hit).argmax())]]
        found.add(which, ViolationKind.COLLISION, first, gap[of_it].min(), 0.0, "m", body.id)


def _unknown(hosts: Iterable[int], t: Array, path: BodyMotion, body: PredictedBody, found: Findings) -> bool:
    """Whether a neighbour is predicted to be nowhere: it cannot be shown to be clear of these hosts."""
    lost = ~(np.isfinite(path.s_m) & np.isfinite(path.d_m) & np.isfinite(path.heading_rad))
    if not lost.any():
        return False
    for which in hosts:
        found.add(which, ViolationKind.PREDICTION, t[int(lost.argmax())], lost.sum(), 0.0, "values", body.id)
    return True


def _near(
    motion: Motion, frame: FrenetFrame, path: BodyMotion, body: PredictedBody, vehicle: Vehicle
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Hosts and fine steps in which the bodies are not plainly apart: by the circles around them, then along the host's own axes."""
    reach = 0.5 * (math.hypot(vehicle.length_m, vehicle.width_m) + math.hypot(body.length_m, body.width_m))
    yaw = path.heading_rad
    close: NDArray[np.bool_] | bool = True
    if frame.road.is_straight:
        apart_x, apart_y = path.s_m - motion.node_x_m, path.d_m - motion.node_y_m
    else:
        near = np.abs(path.s_m - motion.node_s_m) <= ALONG_REACHES * reach
        close = near[:, :-1] & near[:, 1:]
        # the others are put at the host's own s, for the sake of the frame's bounds, and left out
        x, y, yaw = frame.to_plane(np.where(near, path.s_m, motion.node_s_m), path.d_m, path.heading_rad)
        apart_x, apart_y = x - motion.node_x_m, y - motion.node_y_m
    apart = np.hypot(apart_x, apart_y)
    moved = np.hypot(np.diff(apart_x), np.diff(apart_y))
    hosts, steps = np.nonzero(close & (np.minimum(apart[:, :-1], apart[:, 1:]) <= reach + moved))
    if not steps.size:
        return hosts, steps
    ends = np.stack([steps, steps + 1])
    host_yaw, body_yaw = motion.node_yaw_rad[hosts, ends], np.broadcast_to(yaw, apart.shape)[hosts, ends]
    c, s = np.cos(host_yaw[0]), np.sin(host_yaw[0])
    x, y = apart_x[hosts, ends], apart_y[hosts, ends]
    ahead, aside = c * x + s * y, c * y - s * x
    host_long, host_wide = half_extent(host_yaw - host_yaw[0], vehicle.length_m, vehicle.width_m)
    long, wide = half_extent(body_yaw - host_yaw[0], body.length_m, body.width_m)
    gap = np.maximum(_kept(ahead, host_long + long), _kept(aside, host_wide + wide))
    doubtful = gap < _PLAINLY_M
    return hosts[doubtful], steps[doubtful]


def _kept(offset: Array, extent: Array) -> Array:
    """The gap along one axis that is kept at both ends (first index) of a step, on one and the same side."""
    return np.asarray(np.maximum((offset - extent).min(axis=0), (-offset - extent).min(axis=0)))


def _bow(shape: Array) -> Array:
    """How far a corner's way leaves its chord in a step, from corners at its start, middle, end (3, k, 4, 2): to third order the
    largest distance is that of half time."""
    off = shape[1] - 0.5 * (shape[0] + shape[2])
    return np.asarray(np.sqrt((off * off).sum(-1).max(-1)))
