"""What the car measures of itself: speed and steering angle with noise, and the pose that a filter makes of them and of noisy poses."""

from __future__ import annotations

import math

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.angles import wrapped
from mcdas_opt.parking.closed_loop.plant import ParkingPlant
from mcdas_opt.parking.closed_loop.settings import ParkingNoise

_GAIN = 0.06


class PoseFilter:
    """`pose` is (x, y, heading) of the rear axle's midpoint. A fixed share of a measured deviation is believed at once: the gain.

    White noise of a pose comes through by sqrt(gain / (2 - gain)); an error of the dead reckoning dies out by 1 - gain a sample.
    """

    def __init__(self, pose: Array, wheelbase_m: float) -> None:
        self.pose = np.array(pose, dtype=np.float64)
        self._wheelbase = wheelbase_m

    def update(self, speed_mps: float, steering_rad: float, dt_s: float, measured: Array) -> Array:
        """Move on by `dt_s` on the arc of speed and steering, then correct by the pose measured there."""
        distance = speed_mps * dt_s
        turn = distance * math.tan(steering_rad) / self._wheelbase
        x, y, psi = (float(q) for q in self.pose)
        middle, chord = psi + 0.5 * turn, distance * float(np.sinc(0.5 * turn / math.pi))
        reckoned = np.array([x + chord * math.cos(middle), y + chord * math.sin(middle), psi + turn])
        off = np.asarray(measured) - reckoned
        off[2] = wrapped(off[2])
        self.pose = reckoned + _GAIN * off
        return self.pose


class Sensors:
    """`speed_mps`, `steering_rad` and `pose` as measured. Noise comes from the seed alone."""

    def __init__(self, case: ParkingCase, noise: ParkingNoise, seed: int) -> None:
        self.speed_mps, self.steering_rad = 0.0, case.start_steering_rad
        self._noise, self._random = noise, np.random.default_rng(seed)
        self._scale = 1.0 + noise.speed_scale * float(self._random.standard_normal())
        self._offset = noise.steering_offset_rad * float(self._random.standard_normal())
        self._filter = PoseFilter(case.start, case.vehicle.wheelbase_m)

    @property
    def pose(self) -> Array:
        return self._filter.pose

    def measure(self, plant: ParkingPlant, dt_s: float) -> None:
        """Measure the plant, `dt_s` after the last time."""
        noise = self._noise
        draw = self._random.standard_normal(5)
        speed_before, steering_before = self.speed_mps, self.steering_rad
        standing = plant.speed_mps == 0.0  # wheel pulses do not tick
        self.speed_mps = 0.0 if standing else self._scale * plant.speed_mps + noise.speed_mps * float(draw[3])
        self.steering_rad = plant.steering_rad + self._offset + noise.steering_rad * float(draw[4])
        measured = plant.pose + np.array([noise.position_m, noise.position_m, noise.heading_rad]) * draw[:3]
        mean = 0.0 if standing else 0.5 * (speed_before + self.speed_mps)
        self._filter.update(mean, 0.5 * (steering_before + self.steering_rad), dt_s, measured)
