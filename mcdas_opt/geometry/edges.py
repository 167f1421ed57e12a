"""Bodies against the road's edges: how far one reaches beyond them."""

from __future__ import annotations

import math

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle

_REACHES = 5.0  # of a body's diagonal: a road keeps 1 - d kappa above 0.1, so that no edge's knot further off along it is in the body


def beyond_edges(s_m: Array, right_m: Array, left_m: Array, vehicle: Vehicle, road: Road) -> Array:
    """How far bodies at s reach beyond the edges [m], negative inside: their flanks at these d, from tail to nose. An estimate where the
    edges change along the road: looked at below tail, middle and nose."""
    if road.edges is None:
        return np.maximum(left_m - road.left_edge_m, road.right_edge_m - right_m)
    half = 0.5 * vehicle.length_m
    places = s_m[..., None] + np.array([-half, 0.0, half])
    over, under = left_m[..., None] - road.edges.left(places), road.edges.right(places) - right_m[..., None]
    return np.asarray(np.maximum(over, under).max(axis=-1))


def corners_beyond(along: Array, across: Array, road: Road) -> tuple[Array, Array]:
    """How far corners (..., 4) at s and d reach beyond the left and the right edge (...) [m], negative inside."""
    left, right = across - road.left_edge_at(along), road.right_edge_at(along) - across
    return np.asarray(left.max(axis=-1)), np.asarray(right.max(axis=-1))


def knots_inside(s_m: Array, d_m: Array, psi_rad: Array, vehicle: Vehicle, road: Road) -> tuple[Array, Array]:
    """How deep knots of the left and of the right edge stand in bodies with their centres at (s, d), turned by psi from the road (...) [m]:
    what no corner shows. Not positive where none does.

    A knot's place in the body is that on the tangent at the body's centre, bent by the road's curvature there.
    """
    nothing = np.full(np.shape(s_m), -np.inf)
    if road.edges is None:
        return nothing, nothing
    s, *sides = road.edges.table
    reach_m = _REACHES * math.hypot(vehicle.length_m, vehicle.width_m)
    near = (s > float(np.min(s_m)) - reach_m) & (s < float(np.max(s_m)) + reach_m)
    found = []
    kappa = road.curvature_at(s_m)[..., None]
    for side in sides:
        ds, dd = s[near] - s_m[..., None], side[near] - d_m[..., None]
        ahead = ds * (1.0 - kappa * side[near])
        aside = dd + 0.5 * kappa * ds * ds * (1.0 - kappa * side[near])
        c, n = np.cos(psi_rad)[..., None], np.sin(psi_rad)[..., None]
        x, y = c * ahead + n * aside, c * aside - n * ahead
        depth = np.minimum(0.5 * vehicle.length_m - np.abs(x), 0.5 * vehicle.width_m - np.abs(y))
        found.append(np.where(np.abs(ds) < reach_m, depth, -np.inf).max(axis=-1, initial=-np.inf))
    return found[0], found[1]
