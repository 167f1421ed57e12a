"""What a person finds comfortable while nothing threatens."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.rules import at_most, positive, require


@dataclass(frozen=True, slots=True, kw_only=True)
class ComfortSettings:
    """Bends are entered so slowly that they ask for no more than `lateral_mps2` across, and are braked for by `bend_braking_mps2` on the
    way there. Who comes to a bend too fast brakes by no more than `late_braking_mps2`."""

    lateral_mps2: float = 2.0
    bend_braking_mps2: float = 1.5
    late_braking_mps2: float = 3.0

    def __post_init__(self) -> None:
        require(self, positive, "lateral_mps2", "bend_braking_mps2", "late_braking_mps2")
        at_most("comfort.bend_braking_mps2", self.bend_braking_mps2, "comfort.late_braking_mps2", self.late_braking_mps2)
