"""The true car under its tracker: commands, the plant's steps, measurements, contacts, and the record of the drive."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body, PolygonField, obstacle_field
from mcdas_opt.parking.closed_loop.plant import STEP_S as PLANT_STEP_S
from mcdas_opt.parking.closed_loop.plant import ParkingPlant
from mcdas_opt.parking.closed_loop.sensors import Sensors
from mcdas_opt.parking.closed_loop.settings import ParkingNoise
from mcdas_opt.parking.closed_loop.sight import Visitor, standing_by
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


class ContactWatch:
    """`struck` names the first obstacle or visitor that was touched; `least_m` is the least clearance so far (infinite: nothing there)."""

    def __init__(self, truth: ParkingCase, visitors: tuple[Visitor, ...]) -> None:
        self.struck: str | None = None
        self.least_m = np.inf
        self._truth, self._visitors, self._body = truth, visitors, Body.of(truth.vehicle)
        self._fields: dict[tuple[bool, ...], tuple[PolygonField, list[str]]] = {}

    def look(self, poses: Array, now_s: float) -> None:
        """Measure the body at `poses` (n, 3) against everything that is there now."""
        around, names = self._around(now_s)
        apart = around.separation(poses, self._body)
        if not apart.size:
            return
        part = int(np.argmin(apart.min(axis=0)))
        self.least_m = min(self.least_m, float(apart.min()))
        if apart.min() < 0.0:
            self.struck = names[part]

    def _around(self, now_s: float) -> tuple[PolygonField, list[str]]:
        there = tuple(visitor.there(now_s) for visitor in self._visitors)
        if there not in self._fields:
            case = standing_by(self._truth, [visitor for visitor, is_there in zip(self._visitors, there, strict=True) if is_there])
            field, owner = obstacle_field(case.obstacles)
            self._fields[there] = (field, [case.names[k] for k in owner])
        return self._fields[there]
