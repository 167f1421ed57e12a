"""What a car measures of its own motion, and what an observer makes of it."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.rules import as_floats


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionMeasurement:
    """One instant: wheel speeds, gyro, accelerometers at the centre of gravity, and the angle of the front wheels.

    `demand_mps2` is the acceleration asked of brakes and engine: known, not measured.
    """

    speed_mps: float
    yaw_rate_radps: float
    forward_mps2: float
    lateral_mps2: float
    steering_rad: float
    demand_mps2: float

    def __post_init__(self) -> None:
        as_floats(self, tuple(self.__dataclass_fields__))


@dataclass(frozen=True, slots=True, kw_only=True)
class SlipEstimate:
    """What nobody measures: how fast the rear axle moves to the left of the body, and the friction of the road; each with its standard
    deviation. `yaw_rate_radps` is the measured one, filtered. `friction_sd` tells whether tyres worked hard enough to say something."""

    lateral_speed_mps: float
    lateral_speed_sd_mps: float
    yaw_rate_radps: float
    friction: float
    friction_sd: float
