"""Every setting of the tracker, with its unit."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from mcdas_opt.domain.rules import non_negative, positive, unit_of
from mcdas_opt.errors import ParameterError

REFLECTIONS = ("face", "centre")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerSettings:
    """What the tracker believes of targets and sensors, and when a track begins and ends.

    `gate` bounds the squared Mahalanobis distance of (s, d, range rate): 16.27 lets 99.9 % of true detections in (chi-square, 3).
    `reflection` is where on a body radar points lie: on the near "face", or at its "centre" (point targets, antenna to antenna).
    """

    motion: str = "car"  # a file in models/motion, or a path
    reflection: str = "face"
    gate: float = 16.27
    initial_speed_sd_mps: float = 15.0  # of a new radar track along the road, around the host's speed
    initial_lateral_speed_sd_mps: float = 3.0  # and across it, around 0
    confirm_hits: int = 3  # a track is confirmed by so many hits ...
    confirm_window: int = 4  # ... in so many scans of the sensors that have seen it
    tentative_s: float = 0.35  # a tentative track dies without a hit for this long
    coast_s: float = 1.0  # and a confirmed one for this long
    blind_s: float = 5.0  # or this long, while it is too near to its sensor to be seen and does not stand
    coasting_periods: float = 1.5  # without a hit for so many scan periods a track counts as coasting
    coverage_periods: float = 3.0  # without a scan for so many periods a sector counts as blind
    future_tolerance_s: float = 0.05  # measurements further ahead of the clock are refused
    lag_max_s: float = 0.2  # one sensor may report this much later than another
    range_max_m: float = 300.0  # beyond is no car
    speed_max_mps: float = 100.0  # no range rate, no speed exceeds this
    body_gate_m: float = 5.0  # a body of known name may be off its track by this much
    body_position_sd_m: float = 1e-3  # of an ideal sensor
    body_speed_sd_mps: float = 1e-3

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if isinstance(value, float):
                (non_negative if name == "future_tolerance_s" or name == "lag_max_s" else positive)(name, value, unit_of(name))
        if self.reflection not in REFLECTIONS:
            raise ParameterError("reflection", self.reflection, "must be one of " + ", ".join(REFLECTIONS))
        if not 1 <= self.confirm_hits <= self.confirm_window:
            raise ParameterError("confirm_hits", self.confirm_hits, f"must lie in [1, confirm_window = {self.confirm_window}]")
