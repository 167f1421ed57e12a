"""Adaptive cruise control in its textbook form: constant time gap, gains by `control`, bounds by ISO 15622.

The errors of gap and closing speed, e = (gap - standstill - time gap * v, v_front - v), move by de/dt = A e + B a while the front car keeps
its speed; the gains are the linear-quadratic regulator's (Rajamani, Vehicle Dynamics and Control, 2nd ed. 2012, ch. 6; weights by Bryson's
rule). The speed is kept in proportion to its error. Whichever asks for less acceleration is obeyed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mcdas_opt.domain.rules import positive, within
from mcdas_opt.dynamics.car_following import Leader, iso_15622_limits

_GAP_M, _CLOSING_MPS, _ACCELERATION_MPS2 = 5.0, 1.5, 1.0  # errors that cost as much as that acceleration does
_SPEED_GAIN_1PS = 0.4


@dataclass(frozen=True, slots=True, kw_only=True)
class AdaptiveCruise:
    """`time_gap_s` times the own speed, and `standstill_m`, is the gap that is kept. The gains are designed as it is made."""

    time_gap_s: float = 1.2
    standstill_m: float = 2.0

    def __post_init__(self) -> None:
        within("time_gap_s", self.time_gap_s, 0.01, 100.0, "s")
        positive("standstill_m", self.standstill_m, "m")
        _designed(self.time_gap_s)  # loads `control`, which takes seconds: not in the first cycle

    @property
    def gains(self) -> tuple[float, float]:
        """On the error of the gap [1/s^2] and on the closing speed [1/s]."""
        return _designed(self.time_gap_s)

    def wanted_mps2(self, speed_mps: float, desired_mps: float, leader: Leader | None) -> float:
        """Acceleration within what ISO 15622 allows at that speed."""
        wanted = _SPEED_GAIN_1PS * (desired_mps - speed_mps)
        if leader is not None:
            on_gap, on_closing = self.gains
            missing = leader.gap_m - self.standstill_m - self.time_gap_s * speed_mps
            wanted = min(wanted, on_gap * missing + on_closing * (leader.speed_mps - speed_mps))
        most, least, _ = iso_15622_limits(speed_mps)
        return min(max(wanted, -least), most)


@lru_cache(maxsize=16)
def _designed(time_gap_s: float) -> tuple[float, float]:
    import control

    a, b = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[-time_gap_s], [-1.0]])
    cost = np.diag([1.0 / _GAP_M**2, 1.0 / _CLOSING_MPS**2])
    gains, _, _ = control.lqr(a, b, cost, np.array([[1.0 / _ACCELERATION_MPS2**2]]))
    return -float(gains[0, 0]), -float(gains[0, 1])
