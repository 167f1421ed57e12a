"""How much of its distance to the road's edges a car gives up in a bend that takes all of the road."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle

_ROUNDED, _LEAST_M = 0.006, 0.01  # of the car's length, by which `Stage.reach` may be short of the body; and what is kept besides


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


def _taken_m(kappa_1pm: Array, vehicle: Vehicle) -> Array:
    """Between the circles of the nose's outer corner and of the inner flank beside the rear axle."""
    about_m = np.sqrt(np.maximum(1.0 / np.maximum(kappa_1pm, 1e-6) ** 2 - vehicle.centre_m**2, 0.0))
    nose_m = np.hypot(about_m + 0.5 * vehicle.width_m, 0.5 * vehicle.length_m + vehicle.centre_m)
    return np.asarray(nose_m - (about_m - 0.5 * vehicle.width_m))
