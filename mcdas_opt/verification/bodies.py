"""Swept bodies: the host's rectangle against every neighbour's, at and between the fine steps."""

from __future__ import annotations

import math
from collections.abc import Sequence

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
_AT_ONCE = 8  # neighbours: what is worked out of so many stays in the processor's cache

Indices = NDArray[np.intp]


def collisions(
    motion: Motion, vehicle: Vehicle, frame: FrenetFrame, bodies: Sequence[PredictedBody], rows: BodyMotion, found: Findings
) -> None:
    """One violation for each neighbour that a host's body overlaps, in the order of contact: `t_s` is the first one, `value` the deepest
    separation [m]. `rows`: where they are at `motion.every_t_s`."""
    hit = Findings(len(found.of))
    ways = np.stack([rows.s_m, rows.d_m, rows.heading_rad])
    known = _known(motion.every_t_s, bodies, ways, hit)
    for first in range(0, len(known), _AT_ONCE):
        some = known[first : first + _AT_ONCE]
        _collisions(motion, vehicle, frame, [bodies[j] for j in some], ways[:, some], hit)
    for violations, its in zip(found.of, hit.of, strict=True):
        violations += sorted(its, key=lambda one: (one.t_s, one.value))


def _known(t_s: Array, bodies: Sequence[PredictedBody], ways: Array, found: Findings) -> list[int]:
    """Who is somewhere all the time. Who is predicted to be nowhere cannot be shown to be clear."""
    lost = np.asarray(~np.isfinite(ways).all(axis=0))
    for j in np.flatnonzero(lost.any(axis=1)).tolist():
        for which in range(len(found.of)):
            found.add(which, ViolationKind.PREDICTION, t_s[int(lost[j].argmax())], lost[j].sum(), 0.0, "values", bodies[j].id)
    return np.flatnonzero(~lost.any(axis=1)).tolist()


def _collisions(
    motion: Motion, vehicle: Vehicle, frame: FrenetFrame, bodies: Sequence[PredictedBody], ways: Array, found: Findings
) -> None:
    size = np.array([(body.length_m, body.width_m) for body in bodies])
    others, hosts, steps = _near(motion, frame, ways[..., ::2], size, vehicle)
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
    x, y, yaw = frame.to_plane(*ways[:, others, 2 * steps + np.arange(3)[:, None]])
    other = corners(x, y, yaw, size[others, 0], size[others, 1])
    gap = swept_separation(host[0], host[2], other[0], other[2]) - _bow(host) - _bow(other)
    hit = gap < -_TOUCH_M
    for which, body in np.unique(np.stack([hosts, others])[:, hit], axis=1).T.tolist():
        of_it = (hosts == which) & (others == body)
        first = motion.node_t_s[steps[int((of_it & hit).argmax())]]
        found.add(which, ViolationKind.COLLISION, first, gap[of_it].min(), 0.0, "m", bodies[body].id)


def _near(motion: Motion, frame: FrenetFrame, ways: Array, size: Array, vehicle: Vehicle) -> tuple[Indices, Indices, Indices]:
    """Neighbours, hosts and fine steps in which the bodies are not plainly apart: by the circles around them, then along the host's own
    axes."""
    reach = 0.5 * (math.hypot(vehicle.length_m, vehicle.width_m) + np.hypot(size[:, 0], size[:, 1]))[:, None, None]
    close: NDArray[np.bool_] | bool = True
    if frame.road.is_straight:
        x, y, yaw = ways
    else:
        near = np.abs(ways[0, :, None] - motion.node_s_m) <= ALONG_REACHES * reach
        close = near[..., :-1] & near[..., 1:]
        # who is near nobody is put on the frame's piece of road, and left out
        x, y, yaw = frame.to_plane(np.clip(ways[0], frame.s_min_m, frame.s_max_m), ways[1], ways[2])
    apart_x, apart_y = x[:, None] - motion.node_x_m, y[:, None] - motion.node_y_m
    apart = np.hypot(apart_x, apart_y)
    moved = np.hypot(np.diff(apart_x), np.diff(apart_y))
    others, hosts, steps = np.nonzero(close & (np.minimum(apart[..., :-1], apart[..., 1:]) <= reach + moved))
    if not steps.size:
        return others, hosts, steps
    ends = np.stack([steps, steps + 1])
    host_yaw, body_yaw = motion.node_yaw_rad[hosts, ends], yaw[others, ends]
    c, s = np.cos(host_yaw[0]), np.sin(host_yaw[0])
    ahead_x, ahead_y = apart_x[others, hosts, ends], apart_y[others, hosts, ends]
    ahead, aside = c * ahead_x + s * ahead_y, c * ahead_y - s * ahead_x
    host_long, host_wide = half_extent(host_yaw - host_yaw[0], vehicle.length_m, vehicle.width_m)
    long, wide = half_extent(body_yaw - host_yaw[0], size[others, 0], size[others, 1])
    gap = np.maximum(_kept(ahead, host_long + long), _kept(aside, host_wide + wide))
    doubtful = gap < _PLAINLY_M
    return others[doubtful], hosts[doubtful], steps[doubtful]


def _kept(offset: Array, extent: Array) -> Array:
    """The gap along one axis that is kept at both ends (first index) of a step, on one and the same side."""
    return np.asarray(np.maximum((offset - extent).min(axis=0), (-offset - extent).min(axis=0)))


def _bow(shape: Array) -> Array:
    """How far a corner's way leaves its chord in a step, from corners at its start, middle, end (3, k, 4, 2): to third order the
    largest distance is that of half time."""
    off = shape[1] - 0.5 * (shape[0] + shape[2])
    return np.asarray(np.sqrt((off * off).sum(-1).max(-1)))
