"""The tuned offset path: the gain schedule's sigmoid, never steeper than the closed form that proves the bound."""

from __future__ import annotations

import math

from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.rules import finite, positive
from mcdas_opt.dynamics.sigmoid import PEAK_OF_SECOND_DERIVATIVE
from mcdas_opt.reference.offset_path import LEAST_DISPLACEMENT_M, OffsetPath

_SPEED_FLOOR_MPS = 3.0


def tuned_path(
    schedule: GainSchedule,
    *,
    start_s_m: float,
    start_d_m: float,
    target_d_m: float,
    speed_mps: float,
    offset_m: float,
    friction: float,
    lateral_acceleration_mps2: float,
) -> OffsetPath:
    """From (start_s, start_d) to target_d, for speeds up to `speed_mps`; `offset_m` is towards the side that is steered to.

    a and b are the schedule's; for a displacement longer than the schedule's own, a falls with its root. Then |a| is cut at
    sqrt(6 sqrt(3) a_lat / (Y' v^2)), so that v^2 |kappa| <= v^2 |d''| <= v^2 Y' a^2 / (6 sqrt(3)) <= a_lat whatever the tables hold.
    """
    v = max(finite("speed_mps", speed_mps, "m/s"), _SPEED_FLOOR_MPS)
    amplitude = finite("target_d_m", target_d_m, "m") - finite("start_d_m", start_d_m, "m")
    across = max(abs(amplitude), LEAST_DISPLACEMENT_M)
    a, b, y_max = schedule.at(v, offset_m, friction)
    reach = max(y_max + min(max(offset_m, schedule.offset_m[0]), schedule.offset_m[-1]), LEAST_DISPLACEMENT_M)
    steepness = -a * math.sqrt(min(reach / across, 1.0))
    gain = across * (b + 1.0) / (b - 1.0)
    most = math.sqrt(positive("lateral_acceleration_mps2", lateral_acceleration_mps2, "m/s^2") / (gain * PEAK_OF_SECOND_DERIVATIVE)) / v
    return OffsetPath(
        start_s_m=start_s_m,
        start_d_m=start_d_m,
        amplitude_m=amplitude,
        a_per_m=-min(steepness, most),
        b=b,
    )
