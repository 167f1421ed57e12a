"""The gap ahead: what is asked for, and who made it too small. One that a cut-in took is won back gently, any other by more than
ordinary braking."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.settings import LEAST_SHARE, HeadwaySettings, Settings

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


@dataclass(frozen=True, slots=True, kw_only=True)
class FrontGap:
    """What is asked for of the gap ahead in a cycle, and how it stands with that.

    `is_too_near`: more than ordinary braking would leave less than the least share of the headway. `is_won_back`: by more than ordinary
    braking, since nobody else made it too small, and nobody follows closely.
    """

    headway: HeadwaySettings
    is_too_near: bool
    is_won_back: bool

    @classmethod
    def of(
        cls, now: Assessment, cut_in: CutIn | None, settings: Settings, speed_mps: float, *, is_pressed: bool, gets_past: bool
    ) -> FrontGap:
        """Less is asked for where somebody closes in from behind; the least that a gap may have while the host `gets_past` somebody into
        one in the destination's lane; the headway sooner where the host made the gap too small."""
        headway, late_mps2 = settings.headway, settings.comfort.late_braking_mps2
        is_too_near = _is_too_near(now, speed_mps, headway, late_mps2)
        is_won_back = is_too_near and cut_in is None and not gets_past and not _is_followed_closely(now, headway)
        if is_pressed:
            headway = replace(headway, time_gap_s=headway.pressed_s)
        elif gets_past:
            headway = replace(headway, time_gap_s=LEAST_SHARE * headway.time_gap_s)
        elif is_won_back:
            headway = replace(headway, opening=TAKEN_OPENING, braking_mps2=late_mps2)
        return cls(headway=headway, is_too_near=is_too_near, is_won_back=is_won_back)


def _is_too_near(now: Assessment, speed_mps: float, headway: HeadwaySettings, braking_mps2: float) -> bool:
    if now.front_id is None or now.front_speed_mps is None:
        return False
    closing = max(speed_mps - now.front_speed_mps, 0.0)
    left_m = now.front_gap_m - closing * closing / (2.0 * braking_mps2)
    return left_m < headway.gap_m(speed_mps, LEAST_SHARE)


def _is_followed_closely(now: Assessment, headway: HeadwaySettings) -> bool:
    return now.rear_id is not None and now.rear_gap_m < headway.gap_m(now.rear_speed_mps or 0.0, LEAST_SHARE)
