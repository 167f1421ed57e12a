"""Searches of ever finer cells, from the tighter end first, until one of them finds a path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.case_variants import turned_round
from mcdas_opt.parking.path import ArcPath, reversed_path
from mcdas_opt.parking.search.arc_search import Resolution, search
from mcdas_opt.parking.search.free_arcs import total_free_length
from mcdas_opt.parking.search.path_cost import Detours, PathCost
from mcdas_opt.parking.world import World

MANY = 14  # a path with more gear changes asks for one finer search more
RESOLUTIONS = (
    Resolution(cell_m=0.03, max_nodes=15_000, contacts_only=True),
    Resolution(cell_m=0.04, max_nodes=30_000),
    Resolution(cell_m=0.2, max_nodes=15_000, contacts_only=True, wide=True),
    Resolution(cell_m=0.15, max_nodes=30_000, wide=True),
    Resolution(cell_m=0.03, max_nodes=30_000, contacts_only=True, contact_search=True),
    Resolution(cell_m=0.02, max_nodes=60_000, contacts_only=True),
    Resolution(cell_m=0.01, max_nodes=150_000, contacts_only=True),
    Resolution(cell_m=0.01, max_nodes=220_000),
)


@dataclass(slots=True)
class Searched:
    """What the searches took and saw.

    `exhausted`: the last one saw every cell that it could reach. `left_m` is how near one came, `ends` from which end to which.
    """

    nodes: int = 0
    searches: int = 0
    finest_m: float = np.inf
    exhausted: bool = False
    left_m: float = np.inf
    ends: tuple[str, str] = ("goal", "start")


def refine(
    case: ParkingCase, world: World, resolutions: tuple[Resolution, ...], offer: Callable[[ArcPath], bool], late: Callable[[], bool]
) -> Searched:
    """Offer paths as they are found; `offer` says whether a path is sound, `late` whether time is up.

    Every resolution is searched from the tighter end, and from the other one when that finds nothing. A path with more than `MANY` gear
    changes asks for one finer resolution more.
    """
    done = Searched()
    sound: list[int] = []
    sides = [_Side(case, world, backwards) for backwards in _tighter_end_first(case, world)]
    asked_again = False
    for number, resolution in enumerate(resolutions):
        if shorter_than_diagonal(case) and (resolution.contact_search or number == len(resolutions) - 1):
            continue
        if resolution.wide and (asked_again or case.slot is not None):
            continue
        if asked_again and (resolution.contact_search or not resolution.contacts_only):
            continue
        for side in sides:
            done.exhausted = side.search(resolution, offer, sound, done)
            if sound or late():
                break
        if late() or (sound and (min(sound) <= MANY or asked_again or resolution.contact_search)):
            break
        asked_again = bool(sound)
    return done


def shorter_than_diagonal(case: ParkingCase) -> bool:
    """A slot in which not even a car that turns on the spot would find room: only vanishing zigzags are left there."""
    return case.slot is not None and case.slot.length_m < turning_length_m(case) - 1e-3


def turning_length_m(case: ParkingCase) -> float:
    """The shortest slot in which a car that turns on the spot has its clearance: the body's diagonal and two clearances."""
    return float(np.hypot(case.vehicle.length_m, case.vehicle.width_m)) + 2.0 * case.limits.clearance_m


class _Side:
    """The search from one end: from the goal, or from the start of the case turned round."""

    def __init__(self, case: ParkingCase, world: World, backwards: bool) -> None:
        self.world, self.backwards = world, backwards
        self.case = turned_round(case) if backwards else case
        self.cost: PathCost | None = None

    def search(self, resolution: Resolution, offer: Callable[[ArcPath], bool], sound: list[int], done: Searched) -> bool:
        """Whether every cell was seen; the gear changes of sound paths go into `sound`, what was seen into `done`."""
        if self.cost is None:
            self.cost = PathCost.of(self.case, Detours.of(self.case, self.world) if self.world.whole.polygons else None)

        def report(path: ArcPath) -> None:
            if offer(reversed_path(path) if self.backwards else path):
                sound.append(path.gear_changes)

        outcome = search(self.case, self.world, resolution, self.cost, report)
        done.nodes += outcome.nodes
        done.searches += 1
        done.finest_m = min(done.finest_m, resolution.cell_m)
        if outcome.left_m < done.left_m:
            done.left_m, done.ends = outcome.left_m, ("start", "goal") if self.backwards else ("goal", "start")
        return outcome.exhausted


def _tighter_end_first(case: ParkingCase, world: World) -> tuple[bool, bool]:
    """Backwards or not, the tighter end first: the one from which arcs are less free."""

    def room(pose: Array) -> float:
        return total_free_length(case, world, pose)

    tight_start = room(case.start) < 0.7 * room(case.goal)
    return tight_start, not tight_start
