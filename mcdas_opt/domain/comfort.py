"""What a person finds comfortable while nothing threatens."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

from mcdas_opt.domain.rules import at_most, measurable, require
from mcdas_opt.errors import ParameterError

GRIP_SHARE = 0.4  # of a slippery road: what a careful driver asks of it: in bends, before them, to stop, to speed up


class ComfortLimits(NamedTuple):
    """At one speed: the most acceleration and braking [m/s^2], both positive, and the most jerk either way [m/s^3]."""

    acceleration_mps2: float
    braking_mps2: float
    jerk_mps3: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ComfortSettings:
    """Along the road the limits of ISO 15622 (2018, 6.3): above `fast_mps`, below `slow_mps` the slow ones, in between linear.

    Bends are entered so slowly that they ask for no more than `lateral_mps2` across, and are braked for by `bend_braking_mps2` on the way
    there. Who comes to a bend too fast brakes by no more than `late_braking_mps2`. A speed is aimed at with `share` of the acceleration.
    A slippery road makes less of all this comfortable.
    """

    fast_mps: float = 20.0
    slow_mps: float = 5.0
    acceleration_mps2: float = 2.0
    braking_mps2: float = 3.5
    jerk_mps3: float = 2.5
    slow_acceleration_mps2: float = 4.0
    slow_braking_mps2: float = 5.0
    slow_jerk_mps3: float = 5.0
    share: float = 0.75
    lateral_mps2: float = 2.0
    bend_braking_mps2: float = 1.5
    late_braking_mps2: float = 3.0

    def __post_init__(self) -> None:
        require(self, measurable, *self.__slots__)
        at_most("comfort.bend_braking_mps2", self.bend_braking_mps2, "comfort.late_braking_mps2", self.late_braking_mps2)
        at_most("comfort.share", self.share, "all", 1.0)
        if not self.slow_mps < self.fast_mps:
            raise ParameterError("comfort.slow_mps", self.slow_mps, f"must be less than comfort.fast_mps = {self.fast_mps:g}", "m/s")

    def on(self, grip_mps2: float) -> ComfortSettings:
        """What is comfortable in bends, and before them, where the road gives so much grip [m/s^2]."""
        most = GRIP_SHARE * grip_mps2
        if self.lateral_mps2 <= most and self.bend_braking_mps2 <= most:
            return self
        return replace(self, lateral_mps2=min(self.lateral_mps2, most), bend_braking_mps2=min(self.bend_braking_mps2, most))

    def rising_mps2(self, speed_mps: float, grip_mps2: float) -> float:
        """With what a higher speed is aimed at, from this one."""
        return min(self.share * self.limits(speed_mps).acceleration_mps2, GRIP_SHARE * grip_mps2)

    def limits(self, speed_mps: float) -> ComfortLimits:
        """What holds at this speed."""
        fast = min(max((speed_mps - self.slow_mps) / (self.fast_mps - self.slow_mps), 0.0), 1.0)
        return ComfortLimits(
            self.slow_acceleration_mps2 + fast * (self.acceleration_mps2 - self.slow_acceleration_mps2),
            self.slow_braking_mps2 + fast * (self.braking_mps2 - self.slow_braking_mps2),
            self.slow_jerk_mps3 + fast * (self.jerk_mps3 - self.slow_jerk_mps3),
        )
