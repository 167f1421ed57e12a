"""The road under the host: edges for all four corners, and its end for the front bumper."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.geometry.edges import corners_beyond, knots_inside
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners, half_extent
from mcdas_opt.verification.finding import Findings
from mcdas_opt.verification.motion import BETWEEN_SAMPLES_M, Motion
from mcdas_opt.verification.record import Samples
from mcdas_opt.verification.tolerances import CONTRACT


def on_road(samples: Samples, motion: Motion, vehicle: Vehicle, frame: FrenetFrame, found: Findings) -> None:
    """Every corner between the road's edges, none beyond its end, at every fine step (and the samples' own d, whatever the frame)."""
    road, slack = frame.road, CONTRACT.edge_m
    if road.edges is not None:
        _between_changing_edges(samples, motion, vehicle, frame, slack, found)
        return
    left_edge, right_edge = road.left_edge_m, road.right_edge_m
    front, left, right = _on_straight(motion, vehicle) if road.is_straight else _on_curve(motion, vehicle, frame)
    times = motion.node_t_s
    before = _counts(found)
    found.above(ViolationKind.LEFT_EDGE, times, left, left_edge, left_edge + slack, "m")
    found.below(ViolationKind.RIGHT_EDGE, times, right, right_edge, right_edge - slack, "m")
    clear = _counts(found) == before  # who was found outside is not told twice
    inside = np.where(clear[:, None], samples.d_m, 0.0)
    found.above(ViolationKind.LEFT_EDGE, samples.t_s, inside, left_edge, left_edge + slack, "m")
    found.below(ViolationKind.RIGHT_EDGE, samples.t_s, inside, right_edge, right_edge - slack, "m")
    if road.road_end_s_m is not None:
        found.above(ViolationKind.ROAD_END, times, front - road.road_end_s_m, 0.0, slack, "m")  # how far beyond it


def _between_changing_edges(
    samples: Samples, motion: Motion, vehicle: Vehicle, frame: FrenetFrame, slack_m: float, found: Findings
) -> None:
    """The same where the edges change along the road: how far a corner is beyond the edge where that corner is, or how deep a knot of an
    edge stands in the body."""
    road, times = frame.road, motion.node_t_s
    points = corners(motion.node_x_m, motion.node_y_m, motion.node_yaw_rad, vehicle.length_m, vehicle.width_m)
    if road.is_straight:
        s, d = motion.node_x_m, motion.node_y_m
        feet, offset, psi = points[..., 0], points[..., 1], motion.node_yaw_rad
    else:
        s, d = motion.node_s_m, motion.node_d_m
        guess = np.repeat(s[..., None], 4, axis=-1)
        feet, offset, _ = frame.to_road(points[..., 0], points[..., 1], np.zeros(guess.shape), guess_s_m=guess)
        psi = motion.node_yaw_rad - frame.road_heading(s)
    beyond, inside = corners_beyond(feet, offset, road), knots_inside(s, d, psi, vehicle, road)
    left, right = (np.maximum(one, other) for one, other in zip(beyond, inside, strict=True))
    before = _counts(found)
    found.above(ViolationKind.LEFT_EDGE, times, left, 0.0, slack_m, "m")
    found.above(ViolationKind.RIGHT_EDGE, times, right, 0.0, slack_m, "m")
    clear = _counts(found) == before  # who was found outside is not told twice
    own_left = np.where(clear[:, None], samples.d_m - road.left_edge_at(samples.s_m), -np.inf)
    own_right = np.where(clear[:, None], road.right_edge_at(samples.s_m) - samples.d_m, -np.inf)
    found.above(ViolationKind.LEFT_EDGE, samples.t_s, own_left, 0.0, slack_m, "m")
    found.above(ViolationKind.RIGHT_EDGE, samples.t_s, own_right, 0.0, slack_m, "m")
    if road.road_end_s_m is not None:
        found.above(ViolationKind.ROAD_END, times, feet.max(axis=-1) - road.road_end_s_m, 0.0, slack_m, "m")


def _counts(found: Findings) -> NDArray[np.intp]:
    """(trajectories,) how many violations have been found so far."""
    return np.array([len(violations) for violations in found.of])


def _on_straight(motion: Motion, vehicle: Vehicle) -> tuple[Array, Array, Array]:
    """Largest s, largest d and least d of the four corners at every fine time."""
    ahead, aside = half_extent(motion.node_yaw_rad, vehicle.length_m, vehicle.width_m)
    return motion.node_x_m + ahead, motion.node_y_m + aside, motion.node_y_m - aside


def _on_curve(motion: Motion, vehicle: Vehicle, frame: FrenetFrame) -> tuple[Array, Array, Array]:
    """The same from the corners' feet on the road, sought where a corner may lie beyond an edge or the end; elsewhere an estimate.

    A corner x ahead of the body centre lies kappa x^2 / (2 (1 - kappa d)) off the tangent's d; a road keeps kappa d < 0.9.
    """
    road = frame.road
    s, d = motion.node_s_m, motion.node_d_m
    radius = 0.5 * math.hypot(vehicle.length_m, vehicle.width_m)
    margin = 5.0 * road.sharpest_1pm * radius**2 + BETWEEN_SAMPLES_M
    ahead, aside = half_extent(motion.node_yaw_rad - frame.road_heading(s), vehicle.length_m, vehicle.width_m)
    front, left, right = s + ahead, d + aside, d - aside
    doubtful = (left > road.left_edge_m - margin) | (right < road.right_edge_m + margin)
    if road.road_end_s_m is not None:
        doubtful |= s + 10.0 * radius > road.road_end_s_m
    if doubtful.any():
        x, y, yaw = (q[doubtful] for q in (motion.node_x_m, motion.node_y_m, motion.node_yaw_rad))
        points = corners(x, y, yaw, vehicle.length_m, vehicle.width_m)
        guess = np.repeat(s[doubtful, None], 4, axis=1)
        feet, offset, _ = frame.to_road(points[..., 0], points[..., 1], np.zeros(guess.shape), guess_s_m=guess)
        front[doubtful], left[doubtful], right[doubtful] = feet.max(axis=1), offset.max(axis=1), offset.min(axis=1)
    return front, left, right
