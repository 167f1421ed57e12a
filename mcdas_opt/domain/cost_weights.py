"""What a candidate is charged for; the sampled family, which looks for candidates, is charged the same."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.rules import non_negative, require_every

NEARNESS_M = 0.7


@dataclass(frozen=True, slots=True, kw_only=True)
class CostWeights:
    """Per second of plan, except where noted."""

    acceleration: float = 0.04  # per (m/s^2)^2
    lateral_acceleration: float = 0.08  # per (m/s^2)^2
    jerk: float = 0.001  # per (m/s^3)^2
    speed: float = 0.03  # per (m/s)^2 off the desired speed
    haste: float = 0.3  # in ordinary driving, per (m/s)^2 beyond the speed limit
    discomfort: float = 1.0  # in ordinary driving, per (share of acceleration, braking or jerk beyond what is comfortable)^2
    lane_change: float = 2.0  # once
    other_side: float = 0.3  # once, for steering to the side that is not preferred
    delayed: float = 1.5  # once, for a candidate that begins later: what is open now may close
    off_destination: float = 4.0  # once, for steering out away from the destination's lane
    unneeded_lane_change: float = 1.5  # once, for steering out where the selector finds braking or accelerating enough
    inconsiderate: float = 6.0  # once, where that asks a follower for more braking than manners allow
    headway: float = 1.0  # per (share of the front distance asked for that is missing)^2
    stop_line: float = 40.0  # once, for driving over the line at which the host has to wait
    people: float = 100.0  # per (metre missing of the distance that being faster than people asks for)^2
    nearness: float = 6.0  # per exp(-gap / NEARNESS_M)
    end_closing: float = 4.0  # once, per (m/s)^2 of closing speed at the end, over the gap then in metres
    end_room_m: float = 0.5  # whoever ends less than this beside the host's flank counts as before or behind it
    persistence: float = 0.5  # factor on what was chosen before
    replanning_ratio: float = 1.25  # the active manoeuvre goes on alone up to so many times its cost when candidates were last compared
    notable: float = 0.04  # where nothing threatens, what is driven without an optimiser must be cheaper by so much

    def __post_init__(self) -> None:
        require_every(self, non_negative)
