"""The measured state of the host."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from mcdas_opt.domain.rules import Array, as_floats, non_negative


@dataclass(frozen=True, slots=True, kw_only=True)
class HostState:
    """Body centre (s, d) in the road frame, heading relative to the road at s; speed, acceleration, steering of the rear axle.

    What was measured, and so any finite number: a planner answers a state that no car can have by a plan, and says so
    (`planning/measurement/host_plausibility.py`). `sideslip_rad` is by how much the rear axle moves aside of the car's axis, or at most
    moves as far as is known; 0 without slip. Plans are made as if it were 0, and hold only while the rear tyres do
    (`verification/sideslip.py`).
    """

    s_m: float = 0.0
    d_m: float = 0.0
    heading_rad: float = 0.0
    speed_mps: float = 0.0
    acceleration_mps2: float = 0.0
    steering_rad: float = 0.0
    sideslip_rad: float = 0.0

    def __post_init__(self) -> None:
        as_floats(self, tuple(self.__dataclass_fields__))
        non_negative("sideslip_rad", self.sideslip_rad, "rad")

    def to_vector(self) -> Array:
        """(s, d, psi, v, a, delta)."""
        x = np.array((self.s_m, self.d_m, self.heading_rad, self.speed_mps, self.acceleration_mps2, self.steering_rad))
        x.setflags(write=False)
        return x

    def seen_from(self, s_m: float) -> Self:
        """The same with its s counted from `s_m`."""
        return self if s_m == 0.0 else replace(self, s_m=self.s_m - s_m)

    def turning(self, wheelbase_m: float) -> tuple[float, float]:
        """(speed of the rear axle to the left of the body [m/s], yaw rate [rad/s]): 0 and v tan(delta) / L without slip."""
        return 0.0, self.speed_mps * math.tan(self.steering_rad) / wheelbase_m

    def without_slip(self, wheelbase_m: float, point_m: float = 0.0) -> HostState:
        """The state of the no-slip bicycle that moves as this car does now: itself, where nothing slips."""
        return self

    @classmethod
    def from_vector(cls, x: Array) -> HostState:
        """From (s, d, psi, v, a, delta)."""
        s, d, psi, v, a, delta = (float(value) for value in x)
        return cls(s_m=s, d_m=d, heading_rad=psi, speed_mps=v, acceleration_mps2=a, steering_rad=delta)


@dataclass(frozen=True, slots=True, kw_only=True)
class SlidingState(HostState):
    """A host whose tyres slip: `steering_rad` is the angle of the wheels, and the rear axle moves sideways too.

    `lateral_speed_mps` is the rear axle's, to the left of the body; without slip it is 0 and the yaw rate is v tan(delta) / L. Where it is
    an estimate it has a standard deviation. `sideslip_rad` follows from both: one standard deviation beyond the estimate.
    """

    lateral_speed_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    lateral_speed_sd_mps: float = 0.0

    def __post_init__(self) -> None:
        HostState.__post_init__(self)
        aside = abs(self.lateral_speed_mps) + non_negative("lateral_speed_sd_mps", self.lateral_speed_sd_mps, "m/s")
        object.__setattr__(self, "sideslip_rad", math.atan2(aside, abs(self.speed_mps)))

    def turning(self, wheelbase_m: float) -> tuple[float, float]:
        """As `HostState.turning`; both are in the state."""
        return self.lateral_speed_mps, self.yaw_rate_radps

    def without_slip(self, wheelbase_m: float, point_m: float = 0.0) -> HostState:
        """The state of the no-slip bicycle that moves as this car does now: the heading is the course of the point so far ahead of the
        rear axle, where that bicycle has its own; the steering the one that turns the car at its yaw rate. At rest, the state itself."""
        v = self.speed_mps
        if v <= 0.0:
            return HostState.from_vector(self.to_vector())
        return HostState(
            s_m=self.s_m,
            d_m=self.d_m,
            heading_rad=self.heading_rad + math.atan2(self.lateral_speed_mps + point_m * self.yaw_rate_radps, v),
            speed_mps=v,
            acceleration_mps2=self.acceleration_mps2,
            steering_rad=math.atan(wheelbase_m * self.yaw_rate_radps / v),
            sideslip_rad=self.sideslip_rad,
        )
