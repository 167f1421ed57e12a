"""What a path demands of the car that follows it."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np

from mcdas_opt.domain.rules import Array

_SAMPLES = 20001


class Path(Protocol):
    """A lateral path over s, as the literal and the corrected one are."""

    @property
    def start_s_m(self) -> float: ...
    @property
    def length_m(self) -> float: ...
    def slope(self, s: Any) -> Array: ...
    def curvature(self, s: Any) -> Array: ...


def peak_lateral_acceleration(path: Path, speed_mps: float) -> float:
    """Largest v^2 |kappa| [m/s^2] along the path at constant path speed; the curvature exact, sampled at 20001 points (1e-7 of it)."""
    s = path.start_s_m + np.linspace(0.0, path.length_m, _SAMPLES)
    return float(speed_mps**2 * np.abs(path.curvature(s)).max())


def starting_heading_jump(path: Path) -> float:
    """Angle [rad] by which the path's heading jumps where it starts."""
    return math.atan(float(path.slope(path.start_s_m)))
