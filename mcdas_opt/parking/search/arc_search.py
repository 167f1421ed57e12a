"""Search over arcs, from the tight end outwards, a whole batch of poses at a time, with Reeds-Shepp shots at the other end.

After hybrid A* (Dolgov, Thrun, Montemerlo and Diebel, IJRR 2010). Here every arc is followed until contact by conservative
advancement, so that a successor is collision-free all along it and the contact itself is one of them. Cells are coarse where there is
room. The cheapest path for each number of gear changes is kept.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array, positive, require
from mcdas_opt.geometry.angles import wrapped
from mcdas_opt.parking.path import ArcPath, along_arc, backwards, merged, top_curvature
from mcdas_opt.parking.search.contact_search import MARGIN_M as CONTACT_MARGIN_M
from mcdas_opt.parking.search.contact_search import ContactSearch
from mcdas_opt.parking.search.free_arcs import LOOKAHEAD, MARGIN_M, STEERING_SHARES, advance, arcs_both_ways
from mcdas_opt.parking.search.nodes import Frontier, Nodes, Rows, cheapest_of_each_cell
from mcdas_opt.parking.search.path_cost import PathCost
from mcdas_opt.parking.search.shots import Shot, Shots
from mcdas_opt.parking.world import World

_FULL_LOCK = (1.0, 0.0, -1.0)  # steering shares of a search of contacts only
_ROOM_M, _COARSE = 0.4, 6.0  # clearance beyond which cells are so many times as large
_ROUNDS_AFTER_FIRST = 5  # and as many again as it took to the first, at most twice this
_GREED = 1.3  # weight of the estimate
_TURNED_M, _OUTWARD_S = 3.0, 0.4  # a radian counts as so many metres; a second of cost as so many metres back
_FIXED_M = (0.3, 0.8, 1.8)  # successors along an arc, besides contact and half of it ...
_FIXED_BEFORE_M = 0.15  # ... so far before its end


@dataclass(frozen=True, slots=True, kw_only=True)
class Resolution:
    """Everything is capped by counts: the same case gives the same path.

    A search of `contacts_only` goes from contact to contact at full lock only. It needs a tenth of the nodes, and zigzags in tight slots
    look like that anyway. One with a `contact_search` first leaves the tight end in cells as fine as the car is free. `wide` ones see a
    whole alley or yard before their cap ends them, where finer cells fill the place that they began in; out of a slot they lead nowhere.
    """

    cell_m: float = 0.04
    max_nodes: int = 60_000
    contacts_only: bool = False
    contact_search: bool = False
    wide: bool = False

    def __post_init__(self) -> None:
        require_types(self)
        require(self, positive, "cell_m", "max_nodes")

    @property
    def cell_rad(self) -> float:
        """Half as many radians as metres."""
        return 0.5 * self.cell_m


@dataclass(frozen=True, slots=True)
class SearchOutcome:
    """Paths, cheapest first, one for each number of gear changes; `exhausted` when every cell was seen and none leads home.

    `left_m` is how near to the other end [m] a pose came, a radian counted as 3 m.
    """

    paths: tuple[ArcPath, ...]
    nodes: int
    exhausted: bool
    left_m: float


def search(
    case: ParkingCase, world: World, resolution: Resolution, cost: PathCost, report: Callable[[ArcPath], None] | None = None
) -> SearchOutcome:
    """Arc paths from the case's start to its goal; searched from the goal to the start, hence driven in reverse order.

    `report` is called with every path that is kept, as soon as there is one.
    """
    return _Search(case, world, resolution, cost, report).run()


class _Search:
    def __init__(
        self, case: ParkingCase, world: World, resolution: Resolution, cost: PathCost, report: Callable[[ArcPath], None] | None
    ) -> None:
        self.case, self.world, self.resolution, self.cost, self.report = case, world, resolution, cost, report
        asked_m = case.limits.clearance_m + (CONTACT_MARGIN_M if resolution.contact_search else MARGIN_M)
        self.shots = Shots(world, cost, case.start, asked_m, top_curvature(case.vehicle))
        self.nodes = Nodes(case.goal)
        self.frontier = Frontier()
        self.seen: dict[int, float] = {}
        self.found: dict[tuple[int, bool], tuple[float, ArcPath]] = {}  # by gear changes and first gear

    def run(self) -> SearchOutcome:
        left, rounds = -1, 0
        if self.resolution.contact_search:
            self._leave_the_tight_end()
        most = self.resolution.max_nodes + self.nodes.count
        while self.nodes.count < most and left != 0:
            batch = self.frontier.pop(self.nodes)
            if batch.size == 0:
                break
            best = min((value for value, _ in self.found.values()), default=np.inf)
            for shot in self.shots.free(self.nodes, batch, best):
                self._arrive(shot)
            if self.found and left < 0:
                left = _ROUNDS_AFTER_FIRST + min(rounds, _ROUNDS_AFTER_FIRST)
            self._expand(batch)
            rounds += 1
            left -= left > 0
        ranked = sorted(self.found.values(), key=lambda entry: entry[0])
        off = self.nodes.pose[: self.nodes.count] - self.case.start
        left_m = 0.0 if ranked else float((np.hypot(off[:, 0], off[:, 1]) + _TURNED_M * np.abs(wrapped(off[:, 2]))).min())
        return SearchOutcome(tuple(path for _, path in ranked), self.nodes.count, not self.frontier and not self.found, left_m)

    def _leave_the_tight_end(self) -> None:
        exits = ContactSearch(self.case, self.world, self.nodes).run()
        values = np.zeros(0)
        if exits:
            values = self.nodes.g[exits] + _GREED * self.cost.estimate(self.nodes.pose[exits], self.case.start)
        self.frontier.restart(values, exits)

    def _expand(self, batch: Rows) -> None:
        nodes = self.nodes
        kappas, directions = arcs_both_ways(_FULL_LOCK if self.resolution.contacts_only else STEERING_SHARES, self.shots.top)
        parent = np.repeat(batch, kappas.size)
        kappa, direction = np.tile(kappas, batch.size), np.tile(directions, batch.size)
        back = (nodes.direction[parent] == -direction) & (nodes.kappa[parent] == kappa)
        on = nodes.contact[parent] & (nodes.direction[parent] == direction) & (nodes.kappa[parent] == kappa)
        keep = ~(back | on)
        parent, kappa, direction = parent[keep], kappa[keep], direction[keep]
        step_m = 0.25 * self.resolution.cell_m
        free, blocked = advance(
            self.world, self.shots.asked_m, nodes.pose[parent], kappa, direction, nodes.room[parent], step_m=step_m, steps=LOOKAHEAD
        )
        stopped = np.isfinite(blocked)
        choices = [(free, stopped)]
        if not self.resolution.contacts_only:
            choices.append((0.5 * free, np.zeros_like(stopped)))
        choices += [(np.full_like(free, fixed), np.zeros_like(stopped)) for fixed in _FIXED_M]
        length = np.concatenate([c for c, _ in choices])
        contact = np.concatenate([k for _, k in choices])
        usable = length <= np.tile(free, len(choices)) + 1e-12
        fixed_from = (len(choices) - len(_FIXED_M)) * free.size
        usable[fixed_from:] &= length[fixed_from:] < np.tile(free, len(_FIXED_M)) - _FIXED_BEFORE_M
        usable &= length > 0.5 * self.resolution.cell_m
        rows = np.flatnonzero(usable)
        pick = rows % free.size
        self._admit(parent[pick], kappa[pick], direction[pick], length[rows], contact[rows])

    def _admit(self, parent: Array, kappa: Array, direction: Array, length: Array, contact: Array) -> None:
        nodes = self.nodes
        parent = parent.astype(np.int64)
        pose = along_arc(nodes.pose[parent], kappa, direction * length)
        g = nodes.g[parent] + self.cost.step(nodes.direction[parent], nodes.kappa[parent], direction, kappa, length)
        room = self.world.clearance(pose)
        chosen = cheapest_of_each_cell(self._cells(pose, direction, room), g.tolist(), self.seen)
        if not chosen:
            return
        rows = np.array(list(chosen.values()))
        h = self.cost.estimate(pose[rows], self.case.start)
        first = nodes.count
        nodes.add(pose[rows], parent[rows], kappa[rows], direction[rows], length[rows], g[rows], room[rows], contact[rows])
        come = pose[rows] - self.case.goal
        away = np.hypot(come[:, 0], come[:, 1]) + _TURNED_M * np.abs(come[:, 2])
        self.frontier.push(first, g[rows] + _GREED * h, _OUTWARD_S * g[rows] - away, room[rows] <= _ROOM_M)

    def _cells(self, pose: Array, direction: Array, room: Array) -> Array:
        """Cells of position, heading and direction, coarse where there is room."""
        scale = np.where(room > _ROOM_M, _COARSE, 1.0)
        return np.column_stack(
            [
                np.round(pose[:, 0] / (self.resolution.cell_m * scale)),
                np.round(pose[:, 1] / (self.resolution.cell_m * scale)),
                np.round((pose[:, 2] % (2.0 * np.pi)) / (self.resolution.cell_rad * scale)),
                direction,
                scale,
            ]
        )

    def _arrive(self, shot: Shot) -> None:
        arcs = backwards(merged([*self.nodes.trail(shot.node), *shot.arcs]))
        path = ArcPath(self.case.start, arcs)
        value = self.cost.path(arcs)
        kind = (path.gear_changes, bool(arcs) and arcs[0].length > 0.0)
        known = self.found.get(kind)
        if known is None or value < known[0]:
            self.found[kind] = (value, path)
            if self.report is not None:
                self.report(path)
