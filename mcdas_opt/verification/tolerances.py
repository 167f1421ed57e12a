"""What the judge forgives, as data."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.rules import non_negative, require_every


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """Tolerances of the contract; where it is silent, the judge's own, with the reason.

    The start's speed, acceleration and steering must be the measured ones to what a sensor's or a file's rounding leaves. The
    residual of one interval is a fifth of what the contract allows the whole re-integrated drive: above the rounding of a file with
    three decimals (1 mrad over one sample of 0.1 s at 30 m/s is 3 mm), far below any motion that tyres cannot do.
    """

    limit: float = 0.01  # share of a vehicle's limit
    friction: float = 0.02  # share of mu g
    reverse_mps: float = 0.01  # a share of the limit 0 m/s is nothing: an absolute slack instead
    edge_m: float = 0.01  # a corner beyond the road's edge or end; covers its bow between fine steps (below 2 mm)

    start_position_m: float = 0.02
    start_heading_rad: float = 0.01
    start_speed_mps: float = 0.05
    start_acceleration_mps2: float = 0.1
    start_steering_rad: float = 0.005
    start_time_s: float = 1e-6

    end_position_m: float = 0.05
    end_heading_rad: float = 0.005

    residual_position_m: float = 0.01
    residual_heading_rad: float = 0.001
    residual_speed_mps: float = 0.02
    residual_acceleration_mps2: float = 0.05
    residual_steering_rad: float = 0.001

    longest_step_s: float = 0.1
    step_rounding_s: float = 1e-6
    largest_number: float = 1e5  # no column of a trajectory reaches it, and nothing below it overflows

    def __post_init__(self) -> None:
        require_every(self, non_negative)


CONTRACT = Tolerances()
