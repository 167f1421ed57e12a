"""Somewhere to go: a lane, a stretch of road, a time window; what of it can still be had."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import FARTHEST_M, finite
from mcdas_opt.errors import ParameterError

_SPARE_S = 0.5  # to be there earlier than at the last moment, and not before the first
_EVER = (-math.inf, math.inf)


@dataclass(frozen=True, slots=True, kw_only=True)
class Destination:
    """The host is to be with its body's centre between two places `s_m` [m] of the road (None: anywhere), in lane `lane` (None: any), at
    some time between `time_s` [s] (None: ever). A lane alone is the lane to drive in; an exit is its lane and the stretch before it.

    Safety is never traded for it: what cannot be had any more is said (`why_unreachable`), and driven on without.
    """

    s_m: tuple[float, float] | None = None
    lane: int | None = None
    time_s: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.s_m is None and self.lane is None and self.time_s is None:
            raise ParameterError("destination", None, "must say where or when: s_m, lane or time_s")
        if self.lane is not None and (isinstance(self.lane, bool) or not isinstance(self.lane, int)):
            raise ParameterError("lane", self.lane, "must be a whole number")
        for name, given, unit in (("s_m", self.s_m, "m"), ("time_s", self.time_s, "s")):
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
        if self.s_m is not None and max(map(abs, self.s_m)) > 2.0 * FARTHEST_M:
            raise ParameterError("s_m", self.s_m, f"must lie within {2.0 * FARTHEST_M:g} of 0", "m")

    def seen_from(self, s_m: float, time_s: float) -> Destination:
        """The same with its s counted from there, and its time from then; not asked again whether it is sound."""
        moved = copy.copy(self)
        if self.s_m is not None:
            object.__setattr__(moved, "s_m", (self.s_m[0] - s_m, self.s_m[1] - s_m))
        if self.time_s is not None:
            object.__setattr__(moved, "time_s", (self.time_s[0] - time_s, self.time_s[1] - time_s))
        return moved

    def is_reached(self, s_m: float, d_m: float, time_s: float, road: Road) -> bool:
        """Whether a host that is there then is where it is to be."""
        (begin, end), (early, late) = self.s_m or _EVER, self.time_s or _EVER
        there = begin <= s_m <= end and early <= time_s <= late
        return there and (self.lane is None or road.lane_of(d_m, s_m) == self.lane)

    def why_unreachable(self, host: HostState, time_s: float, road: Road, speed_max_mps: float) -> str:
        """Why it cannot be had any more; empty where it may."""
        (begin, end), (_, late) = self.s_m or _EVER, self.time_s or _EVER
        if host.s_m > end:
            return f"it lies {host.s_m - end:.3g} m behind the host"
        if time_s > late:
            return f"its time is over since {time_s - late:.3g} s"
        if begin - host.s_m > speed_max_mps * max(late - time_s, 0.0):
            return f"{begin - host.s_m:.3g} m in {late - time_s:.3g} s are beyond the car's {speed_max_mps:.3g} m/s"
        if road.road_end_s_m is not None and begin > road.road_end_s_m:
            return "the road ends before it"
        if self.lane is not None and not any(road.has_lane(self.lane, s) for s in self._places(host)):
            return f"there is no lane {self.lane} to drive in"
        return ""

    def wanted_mps(self, host: HostState, time_s: float, desired_mps: float) -> float:
        """The speed nearest to the desired one that is there in time, and not before; as desired where there is no time or place."""
        if self.s_m is None or self.time_s is None or host.s_m >= self.s_m[1]:
            return desired_mps
        (begin, end), (early, late) = self.s_m, self.time_s
        least = max(begin - host.s_m, 0.0) / max(late - _SPARE_S - time_s, 0.1)
        most = (end - host.s_m) / max(early + _SPARE_S - time_s, 0.1)
        return min(max(desired_mps, least), max(most, 0.0))

    def _places(self, host: HostState) -> tuple[float, ...]:
        if self.s_m is None:
            return (host.s_m,)
        return max(self.s_m[0], host.s_m), 0.5 * (max(self.s_m[0], host.s_m) + self.s_m[1]), self.s_m[1]
