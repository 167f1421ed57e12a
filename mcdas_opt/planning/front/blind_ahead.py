"""Where nobody watches ahead: for how long, who is supposed to be there, and where the host has to be able to stop."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import MOST_TRACKS, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.planning.front.headway import ORDINARY_MPS2

_BLIP_S = 0.3  # a sensor that is back by then has not been missed
_LONG_S = 4.0  # by then the driver has to act
_ROUNDING_S = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class BlindAhead:
    """Nobody has watched ahead for `age_s`. `supposed` are those ahead whom nobody tells of any more: they go on as they did. Who was next
    ahead in the lane when it began, and has braked fully since, stands with his rear bumper at `free_to_m`; infinite: nobody was."""

    age_s: float
    supposed: tuple[Track, ...] = ()
    free_to_m: float = math.inf

    @classmethod
    def of(
        cls,
        situation: Situation,
        told: Sequence[Track],
        settings: Settings,
        before: BlindAhead | None,
        seen: Sequence[Track] | None,
        elapsed_s: float,
    ) -> BlindAhead | None:
        """None where somebody watches. `told` is who is told of, believed or not. `before` is the same, and `seen` who was told of,
        `elapsed_s` ago; None seen: there was no plan, and nobody has ever watched."""
        host = situation.host
        if situation.coverage.front:
            return None
        there = {track.id for track in (*situation.tracks, *told)}
        known = [*(seen or ()), *(() if before is None else before.supposed)]
        expected = (track.later(elapsed_s) for track in known if track.id not in there)
        supposed = _nearest((track for track in expected if track.s_m > host.s_m), MOST_TRACKS - len(situation.tracks))
        if before is not None:
            return replace(before, age_s=before.age_s + elapsed_s, supposed=supposed)
        braking = min(settings.safe_end.front_braking_mps2, situation.road.grip_mps2)
        ahead = [track for track in (*situation.tracks, *supposed) if situation.shares_lane(track) and track.s_m > host.s_m]
        ends = (track.s_m - 0.5 * track.along_m + max(track.speed_s_mps, 0.0) ** 2 / (2.0 * braking) for track in ahead)
        return cls(age_s=_BLIP_S if seen is None else 0.0, supposed=supposed, free_to_m=min(ends, default=math.inf))

    @property
    def slows(self) -> bool:
        """Whether the host slows down for it."""
        return self.age_s >= _BLIP_S - _ROUNDING_S

    @property
    def is_long(self) -> bool:
        """Whether the driver has to act."""
        return self.age_s >= _LONG_S

    def driven_in(self, situation: Situation, settings: Settings) -> Situation:
        """With who is supposed to be there; slowing down, with a desired speed that ordinary braking reaches within the horizon."""
        wanted = situation.wanted_speed_mps
        if self.slows:
            wanted = min(wanted, max(situation.host.speed_mps - ORDINARY_MPS2 * float(settings.grid.times_s[-1]), 0.0))
        return replace(situation, tracks=situation.tracks + self.supposed, desired_speed_mps=wanted)

    def seen_from(self, s_m: float) -> BlindAhead:
        """The same with its places counted from `s_m`."""
        return replace(self, supposed=tuple(track.seen_from(s_m) for track in self.supposed), free_to_m=self.free_to_m - s_m)


def _nearest(ahead: Iterable[Track], most: int) -> tuple[Track, ...]:
    """All of them, or the next so many ahead: a situation holds no more."""
    found = tuple(ahead)
    return found if len(found) <= most else tuple(sorted(found, key=attrgetter("s_m"))[:most])
