"""The knobs of parking in closed loop, apart from the case."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.domain.rules import non_negative, positive, within
from mcdas_opt.parking.closed_loop.replanning import Reserve
from mcdas_opt.parking.closed_loop.tracker import ParkingActuators, TrackingWeights


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
        for name in self.__slots__:
            non_negative(name, getattr(self, name))


SILENCE = ParkingNoise(position_m=0.0, heading_rad=0.0, speed_mps=0.0, steering_rad=0.0, speed_scale=0.0, steering_offset_rad=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowSettings:
    """Everything about the loop that is not the case. `tracked_m` and beyond is no longer tracking: stop and plan anew."""

    actuators: ParkingActuators = field(default_factory=ParkingActuators)
    weights: TrackingWeights = field(default_factory=TrackingWeights)
    noise: ParkingNoise = field(default_factory=ParkingNoise)
    reserve: Reserve = field(default_factory=Reserve)
    step_s: float = 0.02
    cycle_s: float = 0.1
    pose_gain: float = 0.06
    stop_clearance_m: float = 0.02
    hard_braking_mps2: float = 4.0  # only where the case's acceleration makes no sound stop
    berth_m: float = 0.2  # kept to people besides the clearance
    sight_m: float = 1.5
    tracked_m: float = 0.15
    pause_s: float = 1.0  # at rest, while a new plan is made
    patience_s: float = 10.0  # at rest without a plan
    replans: int = 3
    longest_s: float = 900.0

    def __post_init__(self) -> None:
        for name in ("step_s", "cycle_s", "sight_m", "tracked_m", "longest_s", "hard_braking_mps2"):
            positive(name, getattr(self, name))
        for name in ("stop_clearance_m", "berth_m", "pause_s", "patience_s"):
            non_negative(name, getattr(self, name))
        within("pose_gain", self.pose_gain, 0.0, 1.0)
