"""A steering manoeuvre that is followed from cycle to cycle until it is finished."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.reference.offset_path import OffsetPath

_SETTLED_M, _SETTLED_RAD = 0.25, 0.03  # from the target, and askew
_PAST_S = 0.5  # of driving beyond the path's end


@dataclass(frozen=True, slots=True, kw_only=True)
class Manoeuvre:
    """Its side, its path, the lateral position where it ends and the speed that it drives towards. `mode` is what it is while nothing
    presses: evading, or cruising into another lane."""

    side: Side
    path: OffsetPath
    target_d_m: float
    speed_mps: float
    mode: Mode = Mode.EVADE

    def seen_from(self, s_m: float) -> Manoeuvre:
        """The same with its s counted from `s_m`."""
        if s_m == 0.0:
            return self
        path = replace(self.path, start_s_m=self.path.start_s_m - s_m, bend_s_m=self.path.bend_s_m - s_m)
        return replace(self, path=path)

    def finished(self, situation: Situation) -> bool:
        """Past the path's end, or settled on its target."""
        host = situation.host
        past = host.s_m > self.path.start_s_m + self.path.length_m + host.speed_mps * _PAST_S
        settled = abs(host.d_m - self.target_d_m) < _SETTLED_M and abs(host.heading_rad) < _SETTLED_RAD
        return past or settled

    def half_done(self, situation: Situation) -> bool:
        """The body centre is in the lane that it ends in."""
        road, host = situation.road, situation.host
        return situation.host_lane == road.lane_of(self.target_d_m, host.s_m)
