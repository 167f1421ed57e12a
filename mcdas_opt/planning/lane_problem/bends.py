"""Bends as the lane problem knows them: how the road bends from the body's middle to its ends, and how much of its distance to the edges a
car gives up where a bend takes all of the road."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle

_ROUNDED, _LEAST_M = 0.006, 0.01  # of the car's length, by which `Stage.reach` may be short of the body; and what is kept besides
_LOOKED_M = 25.0  # ahead, by a host that does not go on
_GAUSS = ((0.1550510257216822, 0.6360827634879543), (0.6449489742783178, 0.3639172365120457))  # shares of the way, and their weights


def mean_curvature(road: Road, s_m: Array, way_m: float) -> Array:
    """Of the circle that leaves the tangent at s as far as the road does, so much further on [1/m]: the mean with a weight that falls to 0
    there, by Gauss's rule of two points, which is exact where the curvature is a cubic of s."""
    return np.asarray(sum(weight * road.curvature_at(s_m + share * way_m) for share, weight in _GAUSS))


def given_up_m(road: Road, s_m: Array, width_m: Array | float, asked_m: float, vehicle: Vehicle) -> Array | float:
    """At each edge, at places s of a road that is so wide there: as much as a car that turns steadily, in the sharpest bend within its
    length, leaves too little of what is asked for; but no more than the bend makes it wider, nor than leaves the least that must be
    kept [m]."""
    if np.min(width_m) >= _taken_m(np.array(road.sharpest_1pm), vehicle) + 2.0 * asked_m:
        return 0.0
    kappa = np.abs(road.curvature_at(s_m + vehicle.length_m * np.array([[-1.0], [-0.5], [0.0], [0.5], [1.0]]))).max(axis=0)
    taken_m, spare_m = _taken_m(kappa, vehicle), asked_m - _ROUNDED * vehicle.length_m - _LEAST_M
    most_m = np.minimum(0.5 * (taken_m - vehicle.width_m), max(spare_m, 0.0))
    return np.clip(asked_m - 0.5 * (width_m - taken_m), 0.0, most_m)


def too_tight_bend(road: Road, s_m: float, vehicle: Vehicle) -> tuple[float, float, float] | None:
    """The way to where a car that turns steadily, and keeps the least distance, is first wider than the road; how much it takes there, and
    how much there is [m]. None where it fits as far as is looked at."""
    if road.is_straight:
        return None
    way = np.arange(0.0, _LOOKED_M, 0.5)
    taken_m = _taken_m(np.abs(road.curvature_at(s_m + way)), vehicle)
    width_m = np.broadcast_to(road.left_edge_at(s_m + way) - road.right_edge_at(s_m + way), way.shape)
    short = np.flatnonzero(taken_m + 2.0 * (_ROUNDED * vehicle.length_m + _LEAST_M) > width_m)
    if not short.size:
        return None
    worst = int(short[np.argmax((taken_m - width_m)[short])])
    return float(way[short[0]]), float(taken_m[worst]), float(width_m[worst])


def _taken_m(kappa_1pm: Array, vehicle: Vehicle) -> Array:
    """Between the circles of the nose's outer corner and of the inner flank beside the rear axle."""
    about_m = np.sqrt(np.maximum(1.0 / np.maximum(kappa_1pm, 1e-6) ** 2 - vehicle.centre_m**2, 0.0))
    nose_m = np.hypot(about_m + 0.5 * vehicle.width_m, 0.5 * vehicle.length_m + vehicle.centre_m)
    return np.asarray(nose_m - (about_m - 0.5 * vehicle.width_m))
