"""Searches of ever finer cells, from the tighter end first, until one of them finds a path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.path import ArcPath, reversed_path
from mcdas_opt.parking.search.arc_search import SearchSettings, free_lengths, search
from mcdas_opt.parking.search.contact_search import CrawlSettings
from mcdas_opt.parking.search.path_cost import PathCost
from mcdas_opt.parking.world import World, turned_round


class Level(NamedTuple):
    """One search: its cells [m] (half as many radians), its cap on nodes, and whether it goes from contact to contact at full lock

    only, which needs a tenth of the nodes and is what zigzags in tight slots look like anyway. `wide` ones see a whole alley or yard
    before their cap bites, where finer cells fill the place that they began in; out of a slot they lead nowhere.
    """

    cell_m: float
    nodes: int
    contacts_only: bool
    crawls: bool = False  # out of the tight end first, in cells as fine as the car is free
    wide: bool = False  # for cases that are no slot


LEVELS = (
    Level(0.03, 15_000, True),
    Level(0.04, 30_000, False),
    Level(0.2, 15_000, True, wide=True),
    Level(0.15, 30_000, False, wide=True),
    Level(0.03, 30_000, True, crawls=True),
    Level(0.02, 60_000, True),
    Level(0.01, 150_000, True),
    Level(0.01, 220_000, False),
)


@dataclass(slots=True)
class Climb:
    """What the ladder cost: poses, searches, whether the last one saw every cell that it could reach, how near one came, from which end."""

    nodes: int = 0
    searches: int = 0
    finest_m: float = np.inf
    exhausted: bool = False
    left_m: float = np.inf
    ends: tuple[str, str] = ("goal", "start")


def climb(
    case: ParkingCase,
    world: World,
    levels: tuple[Level, ...],
    settings: SearchSettings,
    many: int,
    offer: Callable[[ArcPath], bool],
    late: Callable[[], bool],
) -> Climb:
    """Offer paths as they are found; `offer` says whether a path is sound.

    Every level searches from the tighter end, and from the other one when that finds nothing. A path with more than `many` gear changes
    asks for one finer level more.
    """
    done = Climb()
    sound: list[int] = []
    sides = [_Side(case, world, backwards) for backwards in _order(case, world)]
    asked_again = False
    for number, level in enumerate(levels):
        if beyond_the_wall(case) and (level.crawls or number == len(levels) - 1):
            continue
        if level.wide and (asked_again or case.slot is not None):
            continue
        if asked_again and (level.crawls or not level.contacts_only):
            continue
        steps = replace(settings, cell_m=level.cell_m, cell_rad=0.5 * level.cell_m, max_nodes=level.nodes)
        if level.contacts_only:
            steps = replace(steps, steers=(1.0, 0.0, -1.0), half_way=False)
        if level.crawls:
            steps = replace(steps, crawl=CrawlSettings(), margin_m=CrawlSettings().margin_m)
        for side in sides:
            done.exhausted = side.search(steps, offer, sound, done)
            if sound or late():
                break
        if late() or (sound and (min(sound) <= many or asked_again or level.crawls)):
            break
        asked_again = bool(sound)
    return done


def beyond_the_wall(case: ParkingCase) -> bool:
    """A slot in which not even a car that turns on the spot would find room: only vanishing zigzags are left there."""
    car = case.vehicle
    return case.slot is not None and case.slot.length_m < float(np.hypot(car.length_m, car.width_m)) + 2.0 * case.limits.clearance_m - 1e-3


class _Side:
    """The search from one end: from the goal, or from the start of the case turned round."""

    def __init__(self, case: ParkingCase, world: World, backwards: bool) -> None:
        self.world, self.backwards = world, backwards
        self.case = turned_round(case) if backwards else case
        self.cost: PathCost | None = None

    def search(self, steps: SearchSettings, offer: Callable[[ArcPath], bool], sound: list[int], done: Climb) -> bool:
        if self.cost is None:
            self.cost = PathCost.of(self.case)
            if self.world.whole.polygons:
                self.cost.learn_detours(self.case, self.world.whole, self.world.body)

        def report(path: ArcPath) -> None:
            if offer(reversed_path(path) if self.backwards else path):
                sound.append(path.gear_changes)

        outcome = search(self.case, self.world, steps, self.cost, report)
        done.nodes += outcome.nodes
        done.searches += 1
        done.finest_m = min(done.finest_m, steps.cell_m)
        if outcome.left_m < done.left_m:
            done.left_m, done.ends = outcome.left_m, ("start", "goal") if self.backwards else ("goal", "start")
        return outcome.exhausted


def _order(case: ParkingCase, world: World) -> tuple[bool, bool]:
    """Backwards or not, the tighter end first: the one from which less way is free."""

    def room(pose: Array) -> float:
        return float(free_lengths(case, world, pose).sum())

    tight_start = room(case.start) < 0.7 * room(case.goal)
    return tight_start, not tight_start
