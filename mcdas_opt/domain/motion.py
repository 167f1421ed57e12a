"""How hard a kind of road user may manoeuvre: the process noise of a constant-velocity target."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.rules import positive, require, require_type


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetMotion:
    """Standard deviations of the acceleration that a constant-velocity model leaves out, along and across the road."""

    name: str
    acceleration_along_mps2: float
    acceleration_across_mps2: float

    def __post_init__(self) -> None:
        require_type("name", self.name, str)
        require(self, positive, "acceleration_along_mps2", "acceleration_across_mps2")
