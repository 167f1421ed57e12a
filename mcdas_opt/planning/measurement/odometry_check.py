"""Whether the clock goes on, and the host's place moves as its speed, its heading and the clock say."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.geometry.frenet import LEAST_STRETCH_MEASURED
from mcdas_opt.planning.measurement.standing_clock import StandingClock
from mcdas_opt.tracking.notices import another_odometry, standing_clock
from mcdas_opt.tracking.screening import clock_fault

_WITHIN_S = 3.0  # the last so many seconds are looked at
_MOST_CYCLES = 60  # and not more cycles
_OFF_M, _OFF_SHARE = 4.0, 0.3  # of the way: places are measured, and speeds, to so much at worst
_JUMP_M = 10.0  # between two cycles: the place is counted from elsewhere


class Doubt(NamedTuple):
    """Under which counter, and why. `is_anew`: what was tracked is of another time or place."""

    counter: str
    why: str
    is_anew: bool


@dataclass(slots=True)
class OdometryCheck:
    """Remembers where the host was, and how far its speed had brought it by then."""

    _past: deque[tuple[float, complex, complex]] = field(default_factory=lambda: deque(maxlen=_MOST_CYCLES))  # time, place, driven: s + i d
    _rate: complex = 0.0
    _clock: StandingClock = field(default_factory=StandingClock)

    def doubt(self, host: HostState, road: Road, now: float) -> Doubt | None:
        """Why tracks are not to be relied on in this cycle; None: all fits."""
        if self._clock.stands(now):
            self._past.clear()
            return Doubt("clock_stands", standing_clock(now), is_anew=True)
        fault = self.fault(host, road, now)
        return Doubt("odometry", fault, is_anew=len(self._past) == 1) if fault else None

    def fault(self, host: HostState, road: Road, now: float) -> str:
        """How the place moves otherwise than the speed says, in words; "" where it does not."""
        stretch = max(1.0 - host.d_m * float(road.curvature_at(host.s_m)), LEAST_STRETCH_MEASURED)
        rate = host.speed_mps * complex(math.cos(host.heading_rad) / stretch, math.sin(host.heading_rad))
        place, driven = complex(host.s_m, host.d_m), 0j
        if self._past:
            last_s, last_place, driven = self._past[-1]
            elapsed_s = now - last_s
            way = 0.5 * elapsed_s * (rate + self._rate)
            driven += way
            if elapsed_s == 0.0:
                self._past.pop()
            elif clock_fault(now, last_s) is not None:
                self._past.clear()
            elif abs(place - last_place - way) > _JUMP_M:
                self._past.clear()
                self._past.append((last_s, last_place, driven - way))
        self._rate = rate
        self._past.append((now, place, driven))
        while abs(now - self._past[0][0]) > _WITHIN_S:
            self._past.popleft()
        first_s, first_place, first_driven = self._past[0]
        moved, way = place - first_place, driven - first_driven
        if abs(moved - way) <= _OFF_M + _OFF_SHARE * max(abs(moved), abs(way)):
            return ""
        if len(self._past) == 2:
            self._past.popleft()  # a jump: from here on it may be counted from elsewhere
        return another_odometry(moved.real, way.real, now - first_s)
