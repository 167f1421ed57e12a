"""What sensors say: scans of detections."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from mcdas_opt.domain.rules import all_of, angle, positive, require_numbers, require_type, true_or_false, word
from mcdas_opt.domain.sensor import Beam
from mcdas_opt.domain.vocabulary import BodyKind, Sector

_OF_A_POINT = ("range_m", "azimuth_rad", "range_rate_mps", "range_sd_m", "azimuth_sd_rad", "range_rate_sd_mps")
_OF_A_BODY = ("s_m", "d_m", "speed_s_mps", "speed_d_mps", "length_m", "width_m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounting:
    """Pose of a sensor on the host: from the body centre, x forward, y left, yaw counter-clockwise (pi = looking back)."""

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0

    def __post_init__(self) -> None:
        require_numbers(self, ("x_m", "y_m", "yaw_rad"))
        if math.isfinite(self.yaw_rad):  # else the tracker refuses the scan
            angle("yaw_rad", self.yaw_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class RadarDetection:
    """A radar point in the sensor's own frame. Azimuth is counter-clockwise positive (ISO 8855), range rate positive when opening.

    Standard deviations are the sensor's own claim. Values may be anything a sensor says, NaN included: the tracker gates them.
    """

    range_m: float
    azimuth_rad: float
    range_rate_mps: float
    range_sd_m: float = 0.25
    azimuth_sd_rad: float = math.radians(0.5)
    range_rate_sd_mps: float = 0.12

    def __post_init__(self) -> None:
        require_numbers(self, _OF_A_POINT)


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyDetection:
    """What an ideal sensor says of a neighbour: body centre (s, d) and velocity over ground in the road frame, its size, and, where it can
    tell, its heading relative to the road and what it is."""

    name: str
    s_m: float
    d_m: float
    speed_s_mps: float
    speed_d_mps: float
    length_m: float
    width_m: float
    heading_rad: float | None = None
    kind: BodyKind | None = None

    def __post_init__(self) -> None:
        require_type("name", self.name, str)
        require_numbers(self, _OF_A_BODY if self.heading_rad is None else (*_OF_A_BODY, "heading_rad"))
        if self.kind is not None and type(self.kind) is not BodyKind:
            object.__setattr__(self, "kind", word("kind", self.kind, BodyKind))


@dataclass(frozen=True, slots=True, kw_only=True)
class Scan:
    """Everything one sensor saw at one instant, `t_s` [s], by the clock that `now` of a `step` shows.

    `working` false: the sensor is there and dead, its sector is not covered.
    `period_s` [s] is from one of its scans to the next: after three of them without one its sector is not covered any more.
    `blind` is where it looks and yet sees nobody, being too near; None: it does not say.
    """

    sensor: str
    sector: Sector
    t_s: float
    mounting: Mounting = field(default_factory=Mounting)
    radar: tuple[RadarDetection, ...] = ()
    bodies: tuple[BodyDetection, ...] = ()
    working: bool = True
    period_s: float = 0.1
    blind: Beam | None = None

    def __post_init__(self) -> None:
        require_type("sensor", self.sensor, str)
        if type(self.sector) is not Sector:
            object.__setattr__(self, "sector", word("sector", self.sector, Sector))
        require_type("mounting", self.mounting, Mounting)
        object.__setattr__(self, "radar", all_of("radar", self.radar, RadarDetection))
        object.__setattr__(self, "bodies", all_of("bodies", self.bodies, BodyDetection))
        if self.blind is not None:
            require_type("blind", self.blind, Beam)
        true_or_false("working", self.working)
        positive("period_s", self.period_s, "s")
        require_numbers(self, ("t_s", "period_s"))
