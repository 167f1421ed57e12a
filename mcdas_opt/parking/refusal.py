"""Why there is no answer, and what would make one: proofs, the nearest attempt, and the least relief that helps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.verdict import Violation, ViolationKind
from mcdas_opt.parking.case_variants import lengthened
from mcdas_opt.parking.path import ArcPath
from mcdas_opt.parking.search.arc_search import Resolution, search
from mcdas_opt.parking.search.path_cost import PathCost
from mcdas_opt.parking.world import World

_LENGTHS_M = (0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.8)
_SHARES = (0.5, 0.2, 0.0)
_QUICK = Resolution(cell_m=0.03, max_nodes=12_000, contacts_only=True)


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
            elif case.slot is not None and key == "goal" and name == "kerb":
                deep = math.ceil(100.0 * (case.slot.depth_m + 2.0 * (asked - least)) - 1e-6) / 100.0
                text += f": the slot's depth_m must be {deep:.2f} instead of {case.slot.depth_m:.2f}"
            return text, Violation(kind=kind, t_s=0.0, value=least, limit=asked, unit="m", body=name)
    return None


def relief(case: ParkingCase, late: Callable[[], bool]) -> tuple[str, ParkingCase, ArcPath] | None:
    """The least of a few reliefs that lets a quick search through: a longer slot, else less clearance. (words, case, path)"""
    reliefs: list[tuple[str, ParkingCase]] = []
    if case.slot is not None:
        reliefs += [(f"{100 * more:.0f} cm more length would do", lengthened(case, more)) for more in _LENGTHS_M]
    for share in _SHARES:
        limits = replace(case.limits, clearance_m=share * case.limits.clearance_m)
        reliefs.append((f"a clearance of {100 * limits.clearance_m:.1f} cm would do", replace(case, limits=limits)))
    for text, relieved in reliefs:
        if late():
            return None
        found = search(relieved, World.of(relieved), _QUICK, PathCost.of(relieved)).paths
        if found:
            return text, relieved, found[0]
    return None
