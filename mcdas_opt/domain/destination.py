"""Somewhere to go: a lane, a stretch of road, a time window; what of it can still be had."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import FARTHEST_M, angle, finite, integer, within
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError

_OUTERMOST_LANE = 1000
_EVER = (-math.inf, math.inf)


@dataclass(frozen=True, slots=True, kw_only=True)
class Destination:
    """The host is to be with its body's centre between two places `s_m` [m] of the road, in lane `lane`, between two offsets `d_m` [m] from
    the road's line, at some time between `time_s` [s]; and then as fast as `speed_mps` [m/s] says, from and to, and turned off the road by
    `heading_rad` [rad]. None: any. A lane alone is the lane to drive in; an exit is its lane and the stretch before it.

    Safety is never traded for it: what cannot be had any more is said (`why_unreachable`), and driven on without.
    """

    s_m: tuple[float, float] | None = None
    lane: int | None = None
    time_s: tuple[float, float] | None = None
    d_m: tuple[float, float] | None = None
    speed_mps: tuple[float, float] | None = None
    heading_rad: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.s_m is None and self.lane is None and self.time_s is None:
            raise ParameterError("destination", None, "must say where or when: s_m, lane or time_s")
        if self.lane is not None:
            object.__setattr__(self, "lane", integer("lane", self.lane))
            within("lane", self.lane, -_OUTERMOST_LANE, _OUTERMOST_LANE)
        windows = (self.s_m, "m"), (self.time_s, "s"), (self.d_m, "m"), (self.speed_mps, "m/s"), (self.heading_rad, "rad")
        for name, (given, unit) in zip(("s_m", "time_s", "d_m", "speed_mps", "heading_rad"), windows, strict=True):
            if given is None:
                continue
            try:
                begin, end = (finite(name, value, unit) for value in given)
            except (TypeError, ValueError) as error:
                raise (
                    error if isinstance(error, ParameterError) else ParameterError(name, given, "must be a pair: from, to", unit)
                ) from None
            if not begin <= end:
                raise ParameterError(name, [begin, end], "must begin before it ends", unit)
            object.__setattr__(self, name, (begin, end))
        for name, place in (("s_m", self.s_m), ("d_m", self.d_m)):
            if place is not None and max(map(abs, place)) > 2.0 * FARTHEST_M:
                raise ParameterError(name, place, f"must lie within {2.0 * FARTHEST_M:g} of 0", "m")
        for heading in self.heading_rad or ():
            angle("heading_rad", heading)

    def seen_from(self, s_m: float, time_s: float) -> Destination:
        """The same with its s counted from there, and its time from then; not asked again whether it is sound."""
        moved = copy.copy(self)
        if self.s_m is not None:
            object.__setattr__(moved, "s_m", (self.s_m[0] - s_m, self.s_m[1] - s_m))
        if self.time_s is not None:
            object.__setattr__(moved, "time_s", (self.time_s[0] - time_s, self.time_s[1] - time_s))
        return moved

    def is_reached(self, host: HostState, time_s: float, road: Road) -> bool:
        """Whether a host that is there then is where it is to be, as it is to be."""
        windows = self.s_m, self.time_s, self.d_m, self.speed_mps
        values = host.s_m, time_s, host.d_m, host.speed_mps
        there = all(window is None or window[0] <= value <= window[1] for window, value in zip(windows, values, strict=True))
        return there and self._is_turned(host.heading_rad) and (self.lane is None or road.lane_of(host.d_m, host.s_m) == self.lane)

    def _is_turned(self, heading_rad: float) -> bool:
        """Whether a heading, or the same by whole turns, is one that is asked for."""
        if self.heading_rad is None:
            return True
        begin, end = self.heading_rad
        heading = math.remainder(heading_rad, math.tau)
        return end - begin >= math.tau or any(begin <= heading + turn <= end for turn in (-math.tau, 0.0, math.tau))

    def why_unreachable(self, host: HostState, time_s: float, road: Road, vehicle: Vehicle) -> str:
        """Why it cannot be had any more; empty where it may."""
        (begin, end), (_, late) = self.s_m or _EVER, self.time_s or _EVER
        if host.s_m > end:
            return f"it lies {host.s_m - end:.3g} m behind the host"
        if time_s > late:
            return f"its time is over since {time_s - late:.3g} s"
        fastest, left_s = vehicle.speed_max_mps, max(late - time_s, 0.0)
        if math.isfinite(late) and begin - host.s_m > (most_m := _farthest_m(host.speed_mps, left_s, vehicle)):
            return f"{begin - host.s_m:.3g} m in {left_s:.3g} s are beyond the car, which comes {most_m:.3g} m far"
        if self.speed_mps is not None and self.speed_mps[0] > fastest:
            return f"{self.speed_mps[0]:.3g} m/s are beyond the car's {fastest:.3g} m/s"
        if road.road_end_s_m is not None and begin > road.road_end_s_m:
            return "the road ends before it"
        if self.lane is not None and not any(road.has_lane(self.lane, s) for s in self._places(host)):
            return f"there is no lane {self.lane} to drive in"
        return ""

    def _places(self, host: HostState) -> tuple[float, ...]:
        if self.s_m is None:
            return (host.s_m,)
        return max(self.s_m[0], host.s_m), 0.5 * (max(self.s_m[0], host.s_m) + self.s_m[1]), self.s_m[1]


def _farthest_m(speed_mps: float, within_s: float, vehicle: Vehicle) -> float:
    """How far a car comes that accelerates as hard as it can."""
    fastest = max(vehicle.speed_max_mps, speed_mps)
    rising_s = min((fastest - speed_mps) / vehicle.acceleration_max_mps2, within_s)
    return speed_mps * rising_s + 0.5 * vehicle.acceleration_max_mps2 * rising_s**2 + fastest * (within_s - rising_s)
