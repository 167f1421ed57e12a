"""Where bodies go whose rear axles are driven along and across a road, many at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle


@dataclass(frozen=True, slots=True, kw_only=True)
class Paths:
    """States of the members (..., T): body centre, heading relative to the road there, and the curvature [1/m] of the rear axle's path.

    `sine` and `cosine` are those of the heading.
    """

    s_m: Array
    d_m: Array
    heading_rad: Array
    sine: Array
    cosine: Array
    curvature_1pm: Array

    def only(self, members: Any) -> Paths:
        """Some members, by an index of their axes."""
        parts = (self.s_m, self.d_m, self.heading_rad, self.sine, self.cosine, self.curvature_1pm)
        s, d, heading, sine, cosine, curvature = (q[members] for q in parts)
        return Paths(s_m=s, d_m=d, heading_rad=heading, sine=sine, cosine=cosine, curvature_1pm=curvature)


def body_paths(s0: Array, travelled: Array, d: Array, sine: Array, cosine: Array, bend: Array, vehicle: Vehicle, road: Road) -> Paths:
    """Of rear axles that start at `s0` (..., 1) and go over the distances `travelled` (..., T) at these places across the road, sines and
    cosines of their direction and curvatures `bend` against the road's own (..., T), all but `travelled` of which it writes into.

    Exact for the bicycle's rear axle but for the integral along the road, which is a sum over the samples.
    """
    c = vehicle.centre_m
    ratio = cosine if road.is_straight else cosine / (1.0 - road.curvature_at(s0 + travelled) * d)
    s = np.empty_like(d)
    s[...] = s0
    s[..., 1:] += np.cumsum(0.5 * np.diff(travelled, axis=-1) * (ratio[..., 1:] + ratio[..., :-1]), axis=-1)
    if road.is_straight:
        d += c * sine
        s += c * cosine
        return Paths(s_m=s, d_m=d, heading_rad=np.arcsin(sine), sine=sine, cosine=cosine, curvature_1pm=bend)
    kappa = road.curvature_at(s)
    bend += kappa * cosine / (1.0 - kappa * d)
    psi = np.arcsin(sine) - kappa * c
    s += c * cosine / (1.0 - kappa * d)
    d += c * sine - 0.5 * kappa * (c * cosine) ** 2
    return Paths(s_m=s, d_m=d, heading_rad=psi, sine=np.sin(psi), cosine=np.cos(psi), curvature_1pm=bend)
