"""A radar as its data sheet describes it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mcdas_opt.domain.rules import all_of, non_negative, positive, require, require_type, within
from mcdas_opt.errors import ParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class Beam:
    """A fan of sight around the sensor's axis: how far, and half its opening angle."""

    name: str
    range_max_m: float
    half_angle_rad: float

    def __post_init__(self) -> None:
        require_type("name", self.name, str)
        positive("range_max_m", self.range_max_m, "m")
        within("half_angle_rad", self.half_angle_rad, 1e-3, math.pi, "rad")

    def holds(self, range_m: float, azimuth_rad: float) -> bool:
        return range_m <= self.range_max_m and abs(azimuth_rad) <= self.half_angle_rad


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """Field of view (any of its beams, beyond `range_min_m`), rate, noise and reliability of a radar.

    Standard deviations are of independent white noise; `detection_probability` is that of a body in full view, per scan.
    """

    name: str
    beams: tuple[Beam, ...]
    range_min_m: float
    rate_hz: float
    range_sd_m: float
    azimuth_sd_rad: float
    range_rate_sd_mps: float
    detection_probability: float = 1.0

    def __post_init__(self) -> None:
        require_type("name", self.name, str)
        object.__setattr__(self, "beams", all_of("beams", self.beams, Beam))
        if not self.beams:
            raise ParameterError("beams", self.beams, "must hold at least one beam")
        positive("rate_hz", self.rate_hz, "1/s")
        non_negative("range_min_m", self.range_min_m, "m")
        require(self, positive, "range_sd_m", "azimuth_sd_rad", "range_rate_sd_mps")
        within("detection_probability", self.detection_probability, 0.0, 1.0)
        if self.range_max_m <= self.range_min_m:
            raise ParameterError("range_min_m", self.range_min_m, "must be less than the longest beam", "m")

    @property
    def period_s(self) -> float:
        return 1.0 / self.rate_hz

    @property
    def range_max_m(self) -> float:
        return max(beam.range_max_m for beam in self.beams)

    @property
    def blind(self) -> Beam | None:
        """The fan before the sensor, as wide as its widest beam, in which everybody is too near to be seen."""
        if self.range_min_m <= 0.0:
            return None
        return Beam(name="blind", range_max_m=self.range_min_m, half_angle_rad=max(beam.half_angle_rad for beam in self.beams))

    def sees(self, range_m: float, azimuth_rad: float) -> bool:
        """Whether a point in the sensor's own frame lies in any beam."""
        return range_m >= self.range_min_m and any(beam.holds(range_m, azimuth_rad) for beam in self.beams)
