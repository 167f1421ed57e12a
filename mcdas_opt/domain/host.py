"""The measured state of the host."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.rules import Array, finite, vector


@dataclass(frozen=True, slots=True, kw_only=True)
class HostState:
    """Body centre (s, d) in the road frame, heading relative to the road at s; speed, acceleration, steering of the rear axle."""

    s_m: float = 0.0
    d_m: float = 0.0
    heading_rad: float = 0.0
    speed_mps: float = 0.0
    acceleration_mps2: float = 0.0
    steering_rad: float = 0.0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            object.__setattr__(self, name, finite(name, getattr(self, name)))

    def to_vector(self) -> Array:
        """(s, d, psi, v, a, delta)."""
        return vector(
            "host",
            [self.s_m, self.d_m, self.heading_rad, self.speed_mps, self.acceleration_mps2, self.steering_rad],
        )

    @classmethod
    def from_vector(cls, x: Array) -> HostState:
        """From (s, d, psi, v, a, delta)."""
        s, d, psi, v, a, delta = (float(value) for value in x)
        return cls(s_m=s, d_m=d, heading_rad=psi, speed_mps=v, acceleration_mps2=a, steering_rad=delta)
