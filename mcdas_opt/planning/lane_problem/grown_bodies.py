"""Neighbours' bodies as the optimiser keeps clear of them: grown by a clearance and by the uncertainty of their estimates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.prediction import (
    CruisingBody,
    PredictedBody,
    all_cruise,
    is_free,
    is_on_foot,
    margins_together,
    sizes_on_road,
)
from mcdas_opt.domain.rules import Array
from mcdas_opt.native.library import library


def grown_bodies(
    bodies: Sequence[PredictedBody], times_s: Array, heading_rad: Array, along_m: float, across_m: float, on_foot_m: float = 0.0
) -> Array:
    """(bodies, 2, n): half of each along and across [m] at these times, headed like this (J, n), with its clearance, who is on foot with
    `on_foot_m` at least, and its margins.

    In C where there is a compiler and all of them move in the one closed form, with the same bits as the array operations.
    """
    compiled = library()
    if compiled is not None and bodies and all_cruise(bodies):
        numbers = np.array([_numbers(body, along_m, across_m) for body in bodies])
        grown = np.empty((len(bodies), 2, times_s.size))
        compiled.mcdas_grown(len(bodies), times_s.size, np.ascontiguousarray(times_s), numbers, grown)
        return grown
    if any(is_free(body) for body in bodies):  # the box around each, as it is turned then
        along, across = sizes_on_road(bodies, heading_rad)
        least = np.array([[on_foot_m if is_on_foot(body) else 0.0] for body in bodies])
        sizes = np.stack([0.5 * along + np.maximum(along_m, least), 0.5 * across + np.maximum(across_m, least)], axis=1)
    else:
        sizes = np.array([(0.5 * body.length_m + along_m, 0.5 * body.width_m + across_m) for body in bodies]).reshape(-1, 2, 1)
    return np.asarray(sizes + np.array(margins_together(bodies, times_s)).swapaxes(0, 1))


def _numbers(body: CruisingBody, along_m: float, across_m: float) -> tuple[float, ...]:
    """The record `Grown` of the C text."""
    half = 0.5 * body.length_m + along_m, 0.5 * body.width_m + across_m
    (s, s_and_speed, _, _), (_, speed_s, _, _), (_, _, d, d_and_speed), (_, _, _, speed_d) = body.covariance.tolist()
    caps = body.cap_along_m, body.cap_across_m
    return *half, body.sigmas, body.growth_s, *caps, s, d, s_and_speed, d_and_speed, speed_s, speed_d
