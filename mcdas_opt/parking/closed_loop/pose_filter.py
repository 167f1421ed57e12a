"""Where the car is: dead reckoning by wheel speed and steering, pulled towards noisy poses by a fixed gain."""

from __future__ import annotations

import math

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.angles import wrapped

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
