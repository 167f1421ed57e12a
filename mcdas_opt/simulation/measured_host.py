"""The host as it knows itself: its pose, what its sensors measure of its motion, and what the observer makes of the sideslip."""

from __future__ import annotations

from dataclasses import replace

from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.host_motion import MotionMeasurement, SlipEstimate
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.simulation.actuators import Applied
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.motion_sensors import MotionSensing, MotionSensors
from mcdas_opt.tracking.sideslip_observer import SideslipObserver


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
