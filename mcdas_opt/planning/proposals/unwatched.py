"""A lane that nobody watches is not steered to."""

from __future__ import annotations

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vocabulary import Sector, Side
from mcdas_opt.planning.cycle import Cycle


def unwatched(situation: Situation, side: Side) -> str:
    """Why the next lane on a side is refused: nobody watches beside, or who comes from behind; empty where it is watched."""
    if side is Side.NONE or situation.sees_lane(side):
        return ""
    return "nobody watches behind" if situation.coverage.sees(Sector(side.value)) else f"nobody watches the {side}"


def begins_unwatched(cycle: Cycle, side: Side) -> str:
    """The same as a reason not to begin to steer there: what the last plan began goes on. A host that slows down because nobody watches
    ahead does not steer either, but out of the way of who closes in from behind: it knows no more of its own lane."""
    if side is cycle.memory.side or side is Side.NONE:
        return ""
    situation = cycle.situation
    slows = cycle.slows_blindly and not cycle.is_pressed and not situation.road.is_for_others(situation.host_lane)
    return unwatched(situation, side) or ("nobody watches ahead" if slows else "")
