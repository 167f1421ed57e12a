"""From the road into the plane and back, as `FrenetFrame`; in C where there is a compiler, with other last bits."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.native.library import library


def to_plane(frame: FrenetFrame, s: Array, d: Array, psi: Array) -> tuple[Array, Array, Array]:
    """(x, y, yaw) of (s, d, psi), each (n,)."""
    compiled = library()
    if compiled is not None and not frame.road.is_straight:
        x, y, yaw = np.empty((3, s.size))
        if compiled.mcdas_to_plane(s.size, s, d, psi, *frame.addresses(), x, y, yaw) == 0:
            return x, y, yaw
    return frame.to_plane(s, d, psi)


def to_road(frame: FrenetFrame, x: Array, y: Array, yaw: Array, near_s_m: float) -> tuple[Array, Array, Array]:
    """(s, d, psi) of (x, y, yaw), each (n,), within 300 m of a place; unless somebody is beyond a bend's centre, in C."""
    compiled = library()
    if compiled is not None and not frame.road.is_straight:
        s, d = np.empty((2, x.size))
        if compiled.mcdas_to_road(x.size, x, y, near_s_m, *frame.addresses(), s, d) == 0:
            psi = yaw - frame.road_heading(s)
            return s, d, np.arctan2(np.sin(psi), np.cos(psi))
    return frame.to_road(x, y, yaw, near_s_m=near_s_m)
