"""Whether the host's measured state can be; where it cannot, what is believed instead."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import FARTHEST_M
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.situation.host_faults import host_faults

_ROLLING_MPS = 0.5  # backwards: a car that stands, or rolls back a little
_MEMORY_S = 1.0  # an older state or plan says nothing of this one


class HostPlausibility:
    """Remembers the last state that was measured, and the last that was believed."""

    def __init__(self) -> None:
        self._time_s = -math.inf
        self._speeds_mps: tuple[float, ...] = ()  # as measured, and as believed
        self._since_s: float | None = None  # when the first of the faulty states came that are the last ones
        self._last: tuple[HostState, float, Road, tuple[HostState, str]] | None = None  # what was asked, and the answer

    def faulty_s(self, now: float) -> float:
        """For how long [s] no state has been one that can be; 0 at the first such."""
        return 0.0 if self._since_s is None else now - self._since_s

    def plausible_state(self, host: HostState, now: float, road: Road, vehicle: Vehicle, previous: Plan | None) -> tuple[HostState, str]:
        """The measured state and "", or one that can be and what is wrong with the measured one, in words.

        A quantity that no car has, or that has jumped, is replaced by that of the `previous` plan at this time; without one by the nearest
        that the car can have. A speed that is measured twice is believed. Asked the same again, or about its own answer, it gives the same
        answer.
        """
        if self._last is not None and self._last[1] == now and self._last[2] is road and host in (self._last[0], self._last[3][0]):
            return self._last[3]
        elapsed_s = now - self._time_s
        speeds_mps = self._speeds_mps if 0.0 < elapsed_s <= _MEMORY_S else ()
        standing = replace(host, speed_mps=0.0) if -_ROLLING_MPS <= host.speed_mps < 0.0 else host
        faults = host_faults(standing, road, speeds_mps, elapsed_s, vehicle)
        believed = _replaced(standing, tuple(faults), now, road, vehicle, previous) if faults else standing
        if not faults or not 0.0 < elapsed_s <= _MEMORY_S:
            self._since_s = None
        if faults and self._since_s is None:
            self._since_s = now
        self._time_s, self._speeds_mps = now, (host.speed_mps, believed.speed_mps)
        answer = believed, "; ".join(faults.values())
        self._last = host, now, road, answer
        return answer


def _replaced(host: HostState, names: tuple[str, ...], now: float, road: Road, vehicle: Vehicle, previous: Plan | None) -> HostState:
    grip_mps2, speed_mps = road.grip_mps2, min(max(host.speed_mps, 0.0), vehicle.speed_max_mps)
    most_rad = min(vehicle.steering_max_rad, math.atan2(vehicle.wheelbase_m * grip_mps2, speed_mps**2))
    within = {
        "s_m": min(max(host.s_m, -FARTHEST_M), FARTHEST_M),
        "d_m": min(max(host.d_m, float(road.right_edge_at(host.s_m))), float(road.left_edge_at(host.s_m))),
        "heading_rad": 0.0,
        "speed_mps": speed_mps,
        "acceleration_mps2": min(max(host.acceleration_mps2, vehicle.acceleration_min_mps2), vehicle.acceleration_max_mps2),
        "steering_rad": min(max(host.steering_rad, -most_rad), most_rad),
    }
    expected = None if previous is None else _on_the_way(previous, now)
    if expected is not None and not host_faults(expected, road, (), 0.0, vehicle):
        within.update((name, getattr(expected, name)) for name in within)
    without_slip = HostState.from_vector(host.to_vector())
    return replace(without_slip, **{name: within[name] for name in names})


def _on_the_way(plan: Plan, now: float) -> HostState | None:
    """Where a plan that is still driven has the car by `now`."""
    driven, age_s = plan.trajectory, now - plan.time_s
    if not 0.0 < age_s <= min(_MEMORY_S, float(driven.t_s[-1])) or not np.isfinite(driven.table).all():
        return None
    s, d, psi, v, a, delta = (float(np.interp(age_s, driven.t_s, column)) for column in driven.table[1:7])
    return HostState(s_m=s, d_m=d, heading_rad=psi, speed_mps=max(v, 0.0), acceleration_mps2=a, steering_rad=delta)
