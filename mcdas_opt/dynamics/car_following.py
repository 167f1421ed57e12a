"""Car following: the Intelligent Driver Model, and what ISO 15622 allows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from mcdas_opt.domain.rules import positive, require


class Leader(NamedTuple):
    """What a follower sees ahead in its lane: the gap bumper to bumper, and how fast the other goes."""

    gap_m: float
    speed_mps: float


@dataclass(frozen=True, slots=True, kw_only=True)
class IdmSettings:
    """Parameters of Treiber, Hennecke, Helbing, Phys. Rev. E 62 (2000) 1805, table I; the desired speed is the driver's own.

    `braking_limit_mps2` bounds what the formula may ask for (it has no bound of its own).
    """

    headway_s: float = 1.6
    acceleration_mps2: float = 0.73
    deceleration_mps2: float = 1.67
    exponent: float = 4.0
    jam_distance_m: float = 2.0
    braking_limit_mps2: float = 8.0

    def __post_init__(self) -> None:
        require(self, positive, *self.__slots__)


def idm_acceleration(speed_mps: float, desired_mps: float, leader: Leader | None, settings: IdmSettings) -> float:
    """Acceleration [m/s^2] by eq 1-3 of the source; a gap of nothing is braked for as hard as can be."""
    s = settings
    crowd = 0.0
    if leader is not None:
        urgency = speed_mps * (speed_mps - leader.speed_mps) / (2.0 * math.sqrt(s.acceleration_mps2 * s.deceleration_mps2))
        wanted = s.jam_distance_m + max(speed_mps * s.headway_s + urgency, 0.0)
        crowd = (wanted / max(leader.gap_m, 0.01)) ** 2
    free = 1.0 - math.pow(speed_mps / desired_mps, s.exponent)
    return max(s.acceleration_mps2 * (free - crowd), -s.braking_limit_mps2)


def iso_15622_limits(speed_mps: float) -> tuple[float, float, float]:
    """(acceleration, braking [m/s^2], jerk [m/s^3]) of cruise control by ISO 15622:2018: between 5 and 20 m/s they fall linearly."""
    share = min(max((speed_mps - 5.0) / 15.0, 0.0), 1.0)
    return 4.0 - 2.0 * share, 5.0 - 1.5 * share, 5.0 - 2.5 * share
