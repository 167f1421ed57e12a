"""The host's motion while it is driven: its speed as the radars are told it, integrated along its lane."""

from __future__ import annotations

import math
from collections import deque

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.interop.host_motion import SLOPE_S


class LiveHost:
    """Keeps to the middle of its lane, as `HostMotion` does; remembers no more than the last moments."""

    def __init__(self, road: Road, vehicle: Vehicle) -> None:
        self._road, self._vehicle = road, vehicle
        self._recent: deque[tuple[float, float]] = deque()
        self._s_m = 0.0  # at the latest speed

    @property
    def heard_s(self) -> float | None:
        """When a speed was last heard."""
        return self._recent[-1][0] if self._recent else None

    def note(self, t_s: float, speed_mps: float) -> None:
        """A speed; one that is no newer than the latest is left out."""
        if self._recent:
            last_s, last = self._recent[-1]
            if t_s <= last_s:
                return
            self._s_m += 0.5 * (last + speed_mps) * (t_s - last_s)
        self._recent.append((t_s, speed_mps))
        while len(self._recent) > 2 and self._recent[1][0] <= t_s - SLOPE_S:
            self._recent.popleft()

    def state(self, t_s: float) -> HostState:
        """At `t_s`, at or after the latest speed, which is held. The acceleration is the slope over the last half second."""
        last_s, speed = self._recent[-1]
        first_s, first = self._recent[0]
        s = self._s_m + speed * (t_s - last_s)
        slope = (speed - first) / max(last_s - first_s, SLOPE_S)
        low, high = self._vehicle.acceleration_min_mps2, self._vehicle.acceleration_max_mps2
        steering = math.atan(self._vehicle.wheelbase_m * float(self._road.curvature_at(s)))
        return HostState(s_m=s, speed_mps=speed, acceleration_mps2=min(max(slope, low), high), steering_rad=steering)
