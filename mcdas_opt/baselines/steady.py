"""The simplest law of a baseline: one strength of braking, or none."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.planning.candidates.path_driving import Kind


@dataclass(frozen=True, slots=True, kw_only=True)
class SteadyLaw:
    """Brakes by `strength_mps2` until no faster than `until_mps`, then keeps its speed; as it is born, it keeps its speed at once."""

    strength_mps2: float = 0.0
    until_mps: float = 0.0

    @property
    def numbers(self) -> tuple[float, ...]:
        return (Kind.STEADY, self.strength_mps2, self.until_mps)

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        return -self.strength_mps2 if speed_mps > self.until_mps else 0.0
