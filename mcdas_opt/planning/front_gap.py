"""Who made the gap ahead too small: one that a cut-in took is won back gently, any other by more than ordinary braking."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.settings import HeadwaySettings
from mcdas_opt.planning.required_lane import LEAST_SHARE

OWED_S = 10.0  # so long a gap that a cut-in has shortened counts as made by others
TAKEN_OPENING = 0.3  # seconds a second: three times as fast as a gap that others made


@dataclass(frozen=True, slots=True, kw_only=True)
class CutIn:
    """Who came in between so near that the headway is missing, and how long ago."""

    id: str
    age_s: float = 0.0


def cut_in(
    now: Assessment, before: Assessment | None, known: CutIn | None, elapsed_s: float, *, asked_m: float, steers: bool
) -> CutIn | None:
    """The cut-in that is ahead now, nearer than the gap that is asked for, given what was `known` so long ago. Whoever is near ahead
    as a drive begins has cut in; whom a host that `steers` into another lane comes behind has not."""
    if now.front_id is None:
        return None
    if known is not None and known.id == now.front_id:
        age_s = known.age_s + elapsed_s
        return CutIn(id=known.id, age_s=age_s) if age_s < OWED_S else None
    if before is not None:
        is_same = before.front_id == now.front_id
        if steers or is_same or (before.front_id is not None and before.front_gap_m <= now.front_gap_m):
            return None
    return CutIn(id=now.front_id) if now.front_gap_m < asked_m else None


def is_too_near(now: Assessment, speed_mps: float, headway: HeadwaySettings, braking_mps2: float) -> bool:
    """Whether braking as it is won back by would leave less than the least share of the headway."""
    if now.front_id is None or now.front_speed_mps is None:
        return False
    closing = max(speed_mps - now.front_speed_mps, 0.0)
    left_m = now.front_gap_m - closing * closing / (2.0 * braking_mps2)
    return left_m < headway.standstill_m + LEAST_SHARE * headway.time_gap_s * max(speed_mps, 0.0)
