"""The settings of parking in closed loop, apart from the case."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import non_negative, positive, require


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingNoise:
    """Standard deviations: white on every measured pose, speed and angle; once a drive for what stays wrong. Assumed figures."""

    position_m: float = 0.02
    heading_rad: float = 0.005
    speed_mps: float = 0.01
    steering_rad: float = 0.002
    speed_scale: float = 0.005  # stays
    steering_offset_rad: float = 0.002  # stays

    def __post_init__(self) -> None:
        require(self, non_negative, "position_m", "heading_rad", "speed_mps", "steering_rad", "speed_scale", "steering_offset_rad")


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowSettings:
    """A car that is `tracked_m` or more off its reference has lost it: it stops and plans anew, at most `replans` times.

    In every cycle a stop is at hand, judged to keep `stop_clearance_m`. `noise` is what is measured wrongly.
    """

    noise: ParkingNoise = field(default_factory=ParkingNoise)
    stop_clearance_m: float = 0.02
    tracked_m: float = 0.15
    replans: int = 3

    def __post_init__(self) -> None:
        require_types(self)
        non_negative("stop_clearance_m", self.stop_clearance_m, "m")
        positive("tracked_m", self.tracked_m, "m")
        non_negative("replans", self.replans)
