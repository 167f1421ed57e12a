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
    """The same as a reason not to begin to steer there: what the last plan began goes on."""
    return "" if side is cycle.memory.side else unwatched(cycle.situation, side)
