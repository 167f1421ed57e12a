"""What the host's own sensors say of its motion: wheel speeds, gyro, accelerometers, steering angle. None of them measures sideslip.

`MeasuredHost` is what is made of it each step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.host_motion import MotionMeasurement, SlipEstimate
from mcdas_opt.domain.rules import non_negative, require, within
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.simulation.actuators import Applied
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.tracking.sideslip_observer import SideslipObserver


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionSensors:
    """White noise (standard deviations, of each step) and offsets; the sign of every offset is drawn once a drive.

    `speed_share` is what wheel speeds are wrong by, of the speed: a tyre's radius.
    """

    speed_sd_mps: float = 0.0
    speed_share: float = 0.0
    yaw_rate_sd_radps: float = 0.0
    yaw_rate_offset_radps: float = 0.0
    acceleration_sd_mps2: float = 0.0
    acceleration_offset_mps2: float = 0.0
    steering_sd_rad: float = 0.0
    steering_offset_rad: float = 0.0

    def __post_init__(self) -> None:
        require(self, non_negative, "speed_sd_mps", "yaw_rate_sd_radps", "yaw_rate_offset_radps", "acceleration_sd_mps2")
        require(self, non_negative, "acceleration_offset_mps2", "steering_sd_rad", "steering_offset_rad")
        within("speed_share", self.speed_share, 0.0, 0.2)

    @property
    def is_ideal(self) -> bool:
        return self == MotionSensors()


# Yaw rate and accelerations: the resolutions (0.1 deg/s, 0.01 g) that Bosch Motorsport gives for the sensors MM5.10 and MM7.10, as standard
# deviations; steering: 0.1 deg at the wheel (Bosch LWS), over a ratio of 16. Offsets are what is left of those of the parts (lateral
# acceleration: up to 0.1 g, VTI) once stability control has zeroed them. They, and the figures of speed, are chosen: nobody publishes them.
PRODUCTION = MotionSensors(
    speed_sd_mps=0.03,
    speed_share=0.005,
    yaw_rate_sd_radps=0.00175,
    yaw_rate_offset_radps=0.0035,
    acceleration_sd_mps2=0.1,
    acceleration_offset_mps2=0.1,
    steering_sd_rad=0.00011,
    steering_offset_rad=0.001,
)
MOTION_SENSORS = {"ideal": MotionSensors(), "production": PRODUCTION}


def motion_sensors(sensors: str | MotionSensors) -> MotionSensors:
    """By name, or the record itself. Raises `ParameterError` that names the nearest known name."""
    if isinstance(sensors, MotionSensors):
        return sensors
    if not isinstance(sensors, str):
        raise ParameterError("motion_sensors", sensors, "must be a name or a MotionSensors")
    if sensors not in MOTION_SENSORS:
        raise ParameterError("motion_sensors", sensors, f"is not known; {nearest(sensors, MOTION_SENSORS)}")
    return MOTION_SENSORS[sensors]


class MotionSensing:
    """Measures a car's states, one a step. Deterministic: the same states with the same seed are measured alike."""

    def __init__(self, sensors: MotionSensors, vehicle: Vehicle, seed: int) -> None:
        self._sensors, self._chassis = sensors, Chassis.of(vehicle)
        self._random = np.random.default_rng([seed, 202])
        self._signs = self._random.choice([-1.0, 1.0], 5)
        self._before: HostState | None = None

    def measure(self, state: HostState, lateral_mps2: float) -> MotionMeasurement:
        """Of the true state, a step after the last one, and the true lateral acceleration of its centre of gravity."""
        q = self._sensors
        before, self._before = self._before or state, state
        aside, yaw_rate = state.turning(self._chassis.wheelbase_m)
        aside += self._chassis.cog_to_rear_axle_m * yaw_rate
        true = (
            state.speed_mps,
            yaw_rate,
            (state.speed_mps - before.speed_mps) / STEP_S - yaw_rate * aside,
            lateral_mps2,
            state.steering_rad,
        )
        if q.is_ideal:
            told = list(true)
        else:
            acceleration = q.acceleration_offset_mps2
            offsets = (q.speed_share * state.speed_mps, q.yaw_rate_offset_radps, acceleration, acceleration, q.steering_offset_rad)
            sd = (q.speed_sd_mps, q.yaw_rate_sd_radps, q.acceleration_sd_mps2, q.acceleration_sd_mps2, q.steering_sd_rad)
            noise = self._random.standard_normal(5)
            told = [x + s * o + e * n for x, s, o, e, n in zip(true, self._signs.tolist(), offsets, sd, noise.tolist(), strict=True)]
        return MotionMeasurement(
            speed_mps=max(told[0], 0.0) if state.speed_mps > 0.0 else 0.0,
            yaw_rate_radps=told[1],
            forward_mps2=told[2],
            lateral_mps2=told[3],
            steering_rad=math.remainder(told[4], 2.0 * math.pi),
            demand_mps2=state.acceleration_mps2,
        )


class MeasuredHost:
    """Follows a car step by step. Pose (place and heading along the road) is told as it is, motion as it is measured.

    Of a car whose tyres slip nobody is told the sideslip: `state` has the observer's, and `slip` its uncertainty. Of one that does not
    slip, with ideal sensors, `state` is the car's own.
    """

    def __init__(self, vehicle: Vehicle, start: HostState, sensors: MotionSensors, *, friction: float, seed: int) -> None:
        self._sensing, self._exact = MotionSensing(sensors, vehicle, seed), sensors.is_ideal
        self._observer = SideslipObserver(vehicle, friction, STEP_S) if isinstance(start, SlidingState) else None
        self.slip: SlipEstimate | None = None
        self.state = self._known(start, start.speed_mps * start.turning(vehicle.wheelbase_m)[1])

    def look(self, state: HostState, applied: Applied) -> None:
        """At the car's true state, a step later; `applied` is what the step did."""
        self.state = self._known(state, applied.lateral_acceleration_mps2)

    @property
    def measured_if_slips(self) -> MotionMeasurement | None:
        """The last measurement, of a car whose tyres slip."""
        return None if self.slip is None else self.measured

    def _known(self, state: HostState, lateral_mps2: float) -> HostState:
        self.measured: MotionMeasurement = self._sensing.measure(state, lateral_mps2)
        if not isinstance(state, SlidingState) or self._observer is None:
            self.slip = None
            return state if self._exact else replace(state, speed_mps=self.measured.speed_mps, steering_rad=self.measured.steering_rad)
        self.slip = self._observer.update(self.measured)
        return replace(
            state,
            speed_mps=self.measured.speed_mps,
            steering_rad=self.measured.steering_rad,
            lateral_speed_mps=self.slip.lateral_speed_mps,
            yaw_rate_radps=self.slip.yaw_rate_radps,
            lateral_speed_sd_mps=self.slip.lateral_speed_sd_mps,
        )
