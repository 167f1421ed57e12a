"""Why there is no answer, and what would make one: proofs, the nearest attempt, and the least relief that helps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.verdict import Violation, ViolationKind
from mcdas_opt.parking.path import ArcPath
from mcdas_opt.parking.search.arc_search import SearchSettings, search
from mcdas_opt.parking.search.path_cost import PathCost
from mcdas_opt.parking.world import World

_LENGTHS_M = (0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.8)
_SHARES = (0.5, 0.2, 0.0)
_QUICK_CELL_M, _QUICK_NODES = 0.03, 12_000


def too_tight(case: ParkingCase, world: World) -> tuple[str, Violation] | None:
    """A proof that no path exists: the start or the goal itself is nearer to an obstacle than asked."""
    asked = case.limits.clearance_m
    for key, kind, pose in (("start", ViolationKind.START_CLEARANCE, case.start), ("goal", ViolationKind.GOAL_CLEARANCE, case.goal)):
        apart = world.whole.separation(pose[None], world.body)[0]
        if apart.size == 0:
            continue
        worst = int(np.argmin(apart))
        least = float(apart[worst])
        if least < asked - 1e-9:
            name = case.names[world.owner[worst]]
            text = f"proved impossible: at the {key} the body is {100 * least:.1f} cm from {name}, {100 * asked:.1f} cm asked"
            if case.slot is not None and key == "goal" and name in ("rear car", "front car"):
                text += f": {200 * (asked - least):.0f} cm more length"
            return text, Violation(kind=kind, t_s=0.0, value=least, limit=asked, unit="m", body=name)
    return None


def lengthened(case: ParkingCase, more_m: float) -> ParkingCase:
    """The case with its slot longer; the start keeps its place beside the front car, the goal its middle."""
    assert case.slot is not None
    slot = replace(case.slot, length_m=case.slot.length_m + more_m)
    shift = np.array([0.5 * more_m, 0.0, 0.0])
    return replace(
        case, slot=slot, obstacles=(*slot.obstacles, *case.obstacles[4:]), goal=case.goal + shift, start=case.start + 2.0 * shift
    )


def relief(case: ParkingCase, settings: SearchSettings, late: Callable[[], bool]) -> tuple[str, ParkingCase, ArcPath] | None:
    """The least of a few reliefs that lets a quick search through: a longer slot, else less clearance. (words, case, path)"""
    quick = replace(settings, cell_m=_QUICK_CELL_M, cell_rad=0.5 * _QUICK_CELL_M, max_nodes=_QUICK_NODES)
    quick = replace(quick, steers=(1.0, 0.0, -1.0), half_way=False)
    reliefs: list[tuple[str, ParkingCase]] = []
    if case.slot is not None:
        reliefs += [(f"{100 * more:.0f} cm more length would do", lengthened(case, more)) for more in _LENGTHS_M]
    for share in _SHARES:
        limits = replace(case.limits, clearance_m=share * case.limits.clearance_m)
        reliefs.append((f"a clearance of {100 * limits.clearance_m:.1f} cm would do", replace(case, limits=limits)))
    for text, relieved in reliefs:
        if late():
            return None
        found = search(relieved, World.of(relieved), quick, PathCost.of(relieved)).paths
        if found:
            return text, relieved, found[0]
    return None
