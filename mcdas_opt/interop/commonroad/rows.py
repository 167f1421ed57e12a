"""The lanelets of the ego's way, row by row: which lie beside which, and which of them leads on."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.interop.commonroad.lane_middle import lane_middle

_MOST_ROWS = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Lanelets side by side: lane number to lanelet id, counted from the ego's first lane, 0, to the left, without a gap.

    `leads`: the number of the one that the road's line follows: 0 as long as that goes on.
    """

    lanelets: dict[int, int]
    leads: int


def row_of(network: Any, lanelet: Any, number: int) -> Row:
    """The lanelets of one direction beside this one, which has that number."""
    found = {number: int(lanelet.lanelet_id)}
    for side, step in ((Side.LEFT, 1), (Side.RIGHT, -1)):
        here, k = lanelet, number
        while (following := beside(network, here, side)) is not None and int(following.lanelet_id) not in found.values():
            here, k = following, k + step
            found[k] = int(here.lanelet_id)
    return Row(lanelets=dict(sorted(found.items())), leads=number)


def beside(network: Any, lanelet: Any, side: Side) -> Any | None:
    """The next lanelet of the same direction to that side."""
    left, right = (lanelet.adj_left, lanelet.adj_left_same_direction), (lanelet.adj_right, lanelet.adj_right_same_direction)
    identifier, same_direction = left if side is Side.LEFT else right
    return network.find_lanelet_by_id(identifier) if identifier is not None and same_direction else None


def rows_ahead(network: Any, own: Any, goals: set[int], far_m: float) -> list[Row]:
    """From the own lanelet on. Along the shortest way to a goal's lanelet, lane changes on the way included, else always straightest on.
    Where a lanelet leads nowhere, and one beside it does, the way goes on there."""
    way = route(network, own.lanelet_id, goals)
    rows, length, seen = [row_of(network, own, 0)], float(own.distance[-1]), {own.lanelet_id}
    while length < far_m and len(rows) < _MOST_ROWS:
        last = rows[-1]
        found = None
        for number in sorted(last.lanelets, key=lambda k: (abs(k - last.leads), k)):
            here = network.find_lanelet_by_id(last.lanelets[number])
            options = [network.find_lanelet_by_id(identifier) for identifier in here.successor if identifier not in seen]
            if options:
                found = number, _best(network, options, way)
                break
        if found is None:
            break
        number, following = found
        seen.add(following.lanelet_id)
        rows.append(row_of(network, following, number))
        length += float(following.distance[-1])
    return rows


def rows_behind(network: Any, own: Any, far_m: float) -> list[Row]:
    """What led to the own lanelet, straightest, the farthest first."""
    rows: list[Row] = []
    here, length, seen = own, 0.0, {own.lanelet_id}
    while length < far_m and len(rows) < _MOST_ROWS:
        options = [network.find_lanelet_by_id(identifier) for identifier in here.predecessor if identifier not in seen]
        if not options:
            break
        here = min(options, key=bend)
        seen.add(here.lanelet_id)
        rows.insert(0, row_of(network, here, 0))
        length += float(here.distance[-1])
    return rows


def _best(network: Any, options: list[Any], way: set[int]) -> Any:
    """One on the way, else one beside the way, else any; of these the straightest."""
    for chosen in (
        [one for one in options if one.lanelet_id in way],
        [one for one in options if way & set(row_of(network, one, 0).lanelets.values())],
    ):
        if chosen:
            return min(chosen, key=bend)
    return min(options, key=bend)


def route(network: Any, begin: int, goals: Iterable[int]) -> set[int]:
    """The lanelets of a shortest way, by the number of lanelets and lane changes; empty where no goal can be reached."""
    wanted = set(goals)
    before: dict[int, int | None] = {begin: None}
    queue = deque([begin])
    while queue:
        here = queue.popleft()
        if here in wanted:
            found: set[int] = set()
            step: int | None = here
            while step is not None:
                found.add(step)
                step = before[step]
            return found
        lanelet = network.find_lanelet_by_id(here)
        sides = [beside(network, lanelet, side) for side in (Side.LEFT, Side.RIGHT)]
        for following in [*lanelet.successor, *(one.lanelet_id for one in sides if one is not None)]:
            if following not in before:
                before[following] = here
                queue.append(following)
    return set()


def bend(lanelet: Any) -> tuple[float, int]:
    """How far a lanelet turns in all [rad]."""
    points, _ = lane_middle(lanelet)
    first, last = points[1] - points[0], points[-1] - points[-2]
    turn = np.arctan2(first[0] * last[1] - first[1] * last[0], first @ last)
    return abs(float(turn)), int(lanelet.lanelet_id)
