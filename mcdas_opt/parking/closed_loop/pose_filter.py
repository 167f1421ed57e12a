"""Where the car is: dead reckoning by wheel speed and steering, pulled towards noisy poses by a fixed gain."""

from __future__ import annotations

import math

import numpy as np

from mcdas_opt.domain.rules import Array, within


class PoseFilter:
    """`pose` is (x, y, heading) of the rear axle's midpoint. The gain is the share of a measured deviation that is believed at once.

    White noise of a pose comes through by sqrt(gain / (2 - gain)); an error of the dead reckoning dies out by 1 - gain a sample.
    """

    def __init__(self, pose: Array, wheelbase_m: float, gain: float = 0.06) -> None:
        self.pose = np.array(pose, dtype=np.float64)
        self._wheelbase, self._gain = wheelbase_m, within("gain", gain, 0.0, 1.0)

    def update(self, speed_mps: float, steering_rad: float, dt_s: float, measured: Array) -> Array:
        """Move on by `dt_s` on the arc of speed and steering, then correct by the pose measured there."""
        distance = speed_mps * dt_s
        turn = distance * math.tan(steering_rad) / self._wheelbase
        x, y, psi = (float(q) for q in self.pose)
        middle, chord = psi + 0.5 * turn, distance * float(np.sinc(0.5 * turn / math.pi))
        reckoned = np.array([x + chord * math.cos(middle), y + chord * math.sin(middle), psi + turn])
        off = np.asarray(measured) - reckoned
        off[2] = (off[2] + math.pi) % (2.0 * math.pi) - math.pi
        self.pose = reckoned + self._gain * off
        return self.pose
