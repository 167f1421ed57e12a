"""The true car under its tracker: commands, the plant's steps, measurements, contacts, and the record of the drive."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.parking.closed_loop.contact_watch import ContactWatch
from mcdas_opt.parking.closed_loop.plant import STEP_S as PLANT_STEP_S
from mcdas_opt.parking.closed_loop.plant import ParkingPlant
from mcdas_opt.parking.closed_loop.sensors import Sensors
from mcdas_opt.parking.closed_loop.settings import ParkingNoise
from mcdas_opt.parking.closed_loop.sight import Visitor
from mcdas_opt.parking.closed_loop.tracker import STEP_S, ParkingActuators, ParkingTracker, TrackingError, design_parking_tracker

ACTUATORS = ParkingActuators()


class Car:
    """`now_s` is the simulated time since the drive began; every step of control takes `STEP_S` of it."""

    def __init__(self, case: ParkingCase, truth: ParkingCase, visitors: tuple[Visitor, ...], noise: ParkingNoise, seed: int) -> None:
        self.plant = ParkingPlant(case.vehicle, case.limits, ACTUATORS, case.start, case.start_steering_rad)
        self.tracker = ParkingTracker(design_parking_tracker(ACTUATORS), ACTUATORS, case.vehicle, case.limits.acceleration_mps2)
        self.sensors = Sensors(case, noise, seed)
        self.contacts = ContactWatch(truth, visitors)
        self.now_s = 0.0
        self._rows: list[list[float]] = []
        self._record()

    def follow(self, since_s: float, hold: bool) -> None:
        """One step after the reference of the tracker at `since_s`; `hold` sets the brake once the car all but stands."""
        sensors = self.sensors
        self._move(self.tracker.command(since_s, sensors.pose, sensors.speed_mps, sensors.steering_rad), hold)

    def stand(self) -> None:
        """One step at rest."""
        self._move((0.0, self.plant.steering_rad), hold=True)

    def true_error(self, since_s: float) -> TrackingError:
        """Of the true car, against the tracker's reference at `since_s`."""
        return self.tracker.error(self.tracker.aim(since_s), self.plant.pose, self.plant.speed_mps)

    def measured_error(self, since_s: float) -> TrackingError:
        """Of the measured car, against the tracker's reference at `since_s`."""
        return self.tracker.error(self.tracker.aim(since_s), self.sensors.pose, self.sensors.speed_mps)

    @property
    def driven(self) -> ParkingTrajectory:
        """Everything that the true car has driven."""
        rows = np.array(self._rows)
        return ParkingTrajectory.from_controls(rows[:, 0], rows[:, 1:4], rows[:, 4], rows[:, 5])

    def _move(self, command: tuple[float, float], hold: bool) -> None:
        poses = []
        for _ in range(round(STEP_S / PLANT_STEP_S)):
            self.plant.step(*command, hold=hold)
            poses.append(self.plant.pose)
        self.now_s = round(self.now_s + STEP_S, 9)
        self.sensors.measure(self.plant, STEP_S)
        self._record()
        self.contacts.look(np.array(poses), self.now_s)

    def _record(self) -> None:
        self._rows.append([self.now_s, *self.plant.pose, self.plant.speed_mps, self.plant.steering_rad])
