"""The middle of a lane, as a path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneCentre:
    """d(s) = d everywhere [m]; for numbers, where an `OffsetPath` would evaluate its curve for nothing."""

    d_m: float

    def d(self, s: Any) -> float:
        return self.d_m

    def slope(self, s: Any) -> float:
        return 0.0

    def curvature(self, s: Any) -> float:
        return 0.0
