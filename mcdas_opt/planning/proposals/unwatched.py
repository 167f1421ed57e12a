"""A side that nobody watches is not steered to."""

from __future__ import annotations

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vocabulary import Sector, Side


def unwatched(situation: Situation, side: Side) -> str:
    """Why a side that nobody watches is refused; empty for one that is watched."""
    sector = {Side.LEFT: Sector.LEFT, Side.RIGHT: Sector.RIGHT}.get(side)
    return "" if sector is None or situation.coverage.sees(sector) else f"nobody watches the {side}"
