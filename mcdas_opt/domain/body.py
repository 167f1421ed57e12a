"""A neighbour as it truly is, at one instant: what the simulation moves and what its sensors look at."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import as_floats, positive, require
from mcdas_opt.domain.vocabulary import BodyKind


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A rectangular body in the road frame.

    (s, d) is the body centre, `heading_rad` is relative to the road at s, `speed_mps` is over ground along the heading
    (negative: driving backwards).
    """

    name: str
    s_m: float
    d_m: float = 0.0
    heading_rad: float = 0.0
    speed_mps: float = 0.0
    length_m: float = 4.5
    width_m: float = 1.8
    kind: BodyKind | None = None

    def __post_init__(self) -> None:
        require_types(self)
        as_floats(self, ("s_m", "d_m", "heading_rad", "speed_mps", "length_m", "width_m"))
        require(self, positive, "length_m", "width_m")

    @property
    def speed_along_mps(self) -> float:
        """Speed over ground in the direction of the road at s; ds/dt is this divided by (1 - d kappa)."""
        return self.speed_mps * math.cos(self.heading_rad)

    @property
    def speed_across_mps(self) -> float:
        """Speed over ground to the left of the road: dd/dt."""
        return self.speed_mps * math.sin(self.heading_rad)
