"""Between highway-env's frame and ours: its y grows to the right, its lanes count from the left, its headings turn clockwise.

The signs turn here and nowhere else. Its car is a kinematic bicycle of the body centre (slip angle beta, tan(beta) = tan(delta) / 2) with
axles at half its length from the centre: our bicycle of the rear axle with its length as wheelbase.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle

LENGTH_M, WIDTH_M = 5.0, 2.0  # of every car there
_BUMPER_M = 0.01  # our cars have one: the axles there stand at the very ends


def highway_vehicle(*, acceleration_mps2: float = 5.0, steering_rad: float = math.pi / 4) -> Vehicle:
    """Its car as a vehicle of ours, with the ranges of its continuous action as limits."""
    return Vehicle(
        name="highway-env",
        wheelbase_m=LENGTH_M - 2.0 * _BUMPER_M,
        front_overhang_m=_BUMPER_M,
        rear_overhang_m=_BUMPER_M,
        width_m=WIDTH_M,
        steering_max_rad=steering_rad,
        acceleration_min_mps2=-acceleration_mps2,
        acceleration_max_mps2=acceleration_mps2,
        speed_max_mps=40.0,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadSide:
    """Our road frame laid on its straight road: s = x - `x_m`, d = `y_m` - y, where `y_m` is the middle of our lane 0."""

    x_m: float
    y_m: float

    def host(self, *, x: float, y: float, heading: float, speed: float, acceleration: float, steering: float) -> HostState:
        """Its ego as our host; its speed is the body centre's, ours the rear axle's."""
        slip = math.atan(0.5 * math.tan(steering))
        return HostState(
            s_m=x - self.x_m,
            d_m=self.y_m - y,
            heading_rad=-heading,
            speed_mps=max(speed * math.cos(slip), 0.0),
            acceleration_mps2=acceleration,
            steering_rad=-steering,
        )

    def track(self, name: str, *, x: float, y: float, heading: float, speed: float) -> Track:
        """One of its cars, known exactly."""
        return Track(
            id=name,
            s_m=x - self.x_m,
            d_m=self.y_m - y,
            speed_s_mps=speed * math.cos(heading),
            speed_d_mps=-speed * math.sin(heading),
            length_m=LENGTH_M,
            width_m=WIDTH_M,
            age_s=1.0,
        )

    def action(self, acceleration_mps2: float, steering_rad: float) -> tuple[float, float]:
        """Our demands as its: (acceleration, steering)."""
        return acceleration_mps2, -steering_rad


def road_of(lanes: int, lane: int, lane_width_m: float, *, speed_limit_mps: float) -> Road:
    """Its road of `lanes`, seen from `lane` (0 is the leftmost)."""
    return Road(lane_width_m=lane_width_m, lanes_left=lane, lanes_right=lanes - 1 - lane, speed_limit_mps=speed_limit_mps)
