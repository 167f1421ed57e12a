"""Search over arcs, from the tight end outwards, a whole batch of poses at a time, with Reeds-Shepp shots at the other end.

After hybrid A* (Dolgov, Thrun, Montemerlo and Diebel, IJRR 2010). Here every arc is walked until contact by conservative
advancement, so that a successor is collision-free all the way and the contact itself is one of them; cells are coarse where there is
room; the cheapest path for each number of gear changes is kept.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.path import Arc, ArcPath, merged
from mcdas_opt.parking.search.contact_search import Crawl, CrawlSettings
from mcdas_opt.parking.search.nodes import Nodes, cheapest_of_each_cell
from mcdas_opt.parking.search.path_cost import PathCost
from mcdas_opt.parking.search.reeds_shepp import WORD_TURNS, along_arc, reeds_shepp
from mcdas_opt.parking.world import World

_SHOT_STEPS_M = (0.4, 0.05, 0.008)  # corners that pass corners dip by half a centimetre between points 5 cm apart
_LOOKAHEAD = 14  # advancement steps along one arc
_LAST_PIECE = np.array([2] * 16 + [3] * 24 + [4] * 4)  # index of a word's last piece
_SHARES = (0.6, 0.15, 0.25)  # of a batch, for the three queues
_TURNED_M, _OUTWARD_S = 3.0, 0.4  # a radian counts as so many metres of way; a second of cost as so many metres of way back
_WORTH_S = 6.0  # dearer than the best path by this much is still worth a shot
_FIXED_M = (0.3, 0.8, 1.8)  # successors on the way, besides contact and half way


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchSettings:
    """Everything is capped by counts: the same case gives the same path."""

    cell_m: float = 0.04
    cell_rad: float = 0.02
    room_m: float = 0.4  # clearance beyond which cells are `coarse` times as large
    coarse: float = 6.0
    batch: int = 64
    max_nodes: int = 60_000
    rounds_after_first: int = 5  # and as many again as it took to the first, at most twice this
    reach_m: float = 3.0
    margin_m: float = 1e-3  # more clearance than asked
    steers: tuple[float, ...] = (1.0, 0.5, 0.0, -0.5, -1.0)  # shares of the largest curvature
    half_way: bool = True  # half of each free arc is a successor too
    greed: float = 1.3  # weight of the estimate
    shots: int = 12  # words of a batch that are looked at closely
    words: int = 2  # Reeds-Shepp words tried per shot and gear at the far end
    crawl: CrawlSettings | None = None  # out of the tight end from contact to contact first, then on from the ways out


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
    case: ParkingCase, world: World, settings: SearchSettings, cost: PathCost, report: Callable[[ArcPath], None] | None = None
) -> SearchOutcome:
    """Arc paths from the case's start to its goal; searched from the goal to the start, hence driven the other way round.

    `report` is called with every path that is kept, as soon as there is one.
    """
    return _Search(case, world, settings, cost, report).run()


def free_lengths(case: ParkingCase, world: World, pose: Array) -> Array:
    """(10,) how far [m] every arc leads from a pose before it comes too near to something."""
    probe = _Search(case, world, SearchSettings(), PathCost.of(case), None)
    count = probe.curvature.size
    room = np.full(count, float(world.clearance(pose[None])[0]))
    free, _ = probe.walk(np.tile(pose, (count, 1)), probe.curvature, probe.direction, probe.stretch, room)
    return free


class _Search:
    def __init__(
        self, case: ParkingCase, world: World, settings: SearchSettings, cost: PathCost, report: Callable[[ArcPath], None] | None
    ) -> None:
        self.case, self.world, self.settings, self.cost, self.report = case, world, settings, cost, report
        self.asked = case.limits.clearance_m + settings.margin_m
        self.top = float(np.tan(case.vehicle.steering_max_rad)) / case.vehicle.wheelbase_m
        steers = np.array(settings.steers)
        self.curvature = np.tile(steers * self.top, 2)
        self.direction = np.repeat([1.0, -1.0], steers.size)
        self.stretch = 1.0 + np.abs(self.curvature) * world.body.reach  # how far a body point moves per metre, at most
        self.nodes = Nodes(case.goal)
        # Three queues share a batch: by cost and estimate; tight poses by how far they have come from the root, which leads out of a slot
        # that the estimate knows nothing of; roomy poses by cost and estimate, so that those who came out are not starved by those inside.
        self.queues: tuple[list[tuple[float, int]], ...] = ([(0.0, 0)], [], [])
        self.seen: dict[int, float] = {}
        self.found: dict[tuple[int, bool], tuple[float, ArcPath]] = {}  # by gear changes and first gear

    def run(self) -> SearchOutcome:
        s = self.settings
        left, rounds = -1, 0
        if s.crawl is not None:
            self._crawl(s.crawl)
        most = s.max_nodes + self.nodes.count
        while self.nodes.count < most and left != 0:
            batch = self._pop()
            if batch.size == 0:
                break
            self._shoot(batch)
            if self.found and left < 0:
                left = s.rounds_after_first + min(rounds, s.rounds_after_first)
            self._expand(batch)
            rounds += 1
            left -= left > 0
        ranked = sorted(self.found.values(), key=lambda entry: entry[0])
        off = self.nodes.pose[: self.nodes.count] - self.case.start
        turn = np.abs((off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi)
        left_m = 0.0 if ranked else float((np.hypot(off[:, 0], off[:, 1]) + _TURNED_M * turn).min())
        return SearchOutcome(tuple(path for _, path in ranked), self.nodes.count, not any(self.queues) and not self.found, left_m)

    def _crawl(self, settings: CrawlSettings) -> None:
        out = Crawl(self.case, self.world, self.nodes, settings).run()
        for queue in self.queues:
            queue.clear()
        if out:
            h = self.cost.estimate(self.nodes.pose[out], self.case.start)
            for value, node in zip((self.nodes.g[out] + self.settings.greed * h).tolist(), out, strict=True):
                heapq.heappush(self.queues[0], (value, node))

    def _pop(self) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
        batch: list[int] = []
        for queue, share in zip(self.queues, _SHARES, strict=True):
            room = len(batch) + int(share * self.settings.batch)
            while queue and len(batch) < room:
                _, node = heapq.heappop(queue)
                if not self.nodes.closed[node]:
                    self.nodes.closed[node] = True
                    batch.append(node)
        return np.array(batch, dtype=np.int64)

    def _expand(self, batch: np.ndarray[tuple[int], np.dtype[np.int64]]) -> None:
        nodes, arcs = self.nodes, self.curvature.size
        parent = np.repeat(batch, arcs)
        kappa = np.tile(self.curvature, batch.size)
        way = np.tile(self.direction, batch.size)
        stretch = np.tile(self.stretch, batch.size)
        back = (nodes.way[parent] == -way) & (nodes.kappa[parent] == kappa)
        on = nodes.contact[parent] & (nodes.way[parent] == way) & (nodes.kappa[parent] == kappa)
        keep = ~(back | on)
        parent, kappa, way, stretch = parent[keep], kappa[keep], way[keep], stretch[keep]
        free, stopped = self.walk(nodes.pose[parent], kappa, way, stretch, nodes.room[parent])
        choices = [(free, stopped)]
        if self.settings.half_way:
            choices.append((0.5 * free, np.zeros_like(stopped)))
        choices += [(np.full_like(free, fixed), np.zeros_like(stopped)) for fixed in _FIXED_M]
        length = np.concatenate([c for c, _ in choices])
        contact = np.concatenate([k for _, k in choices])
        usable = length <= np.tile(free, len(choices)) + 1e-12
        fixed_from = (len(choices) - len(_FIXED_M)) * free.size
        usable[fixed_from:] &= length[fixed_from:] < np.tile(free, len(_FIXED_M)) - 0.15
        usable &= length > 0.5 * self.settings.cell_m
        rows = np.flatnonzero(usable)
        pick = rows % free.size
        self._admit(parent[pick], kappa[pick], way[pick], length[rows], contact[rows])

    def walk(self, pose: Array, kappa: Array, way: Array, stretch: Array, room: Array) -> tuple[Array, NDArray[np.bool_]]:
        """(free length, whether it ends in contact) of every arc."""
        s = self.settings
        step_min = 0.25 * s.cell_m
        free = np.zeros(len(pose))
        stopped = np.zeros(len(pose), dtype=np.bool_)
        active = np.arange(len(pose))
        slack = room - self.asked
        for _ in range(_LOOKAHEAD):
            ahead = np.minimum(free[active] + np.maximum(slack / stretch[active], step_min), s.reach_m)
            there = along_arc(pose[active], kappa[active], way[active] * ahead)
            slack = self.world.clearance(there) - self.asked
            sound = slack >= 0.0
            free[active[sound]] = ahead[sound]
            stopped[active[~sound]] = True
            going = sound & (ahead < s.reach_m - 1e-9)
            active, slack = active[going], slack[going]
            if active.size == 0:
                break
        return free, stopped

    def _admit(self, parent: Array, kappa: Array, way: Array, length: Array, contact: Array) -> None:
        nodes, s = self.nodes, self.settings
        parent = parent.astype(np.int64)
        pose = along_arc(nodes.pose[parent], kappa, way * length)
        g = nodes.g[parent] + self.cost.step(nodes.way[parent], nodes.kappa[parent], way, kappa, length)
        room = self.world.clearance(pose)
        scale = np.where(room > s.room_m, s.coarse, 1.0)
        cells = np.column_stack(
            [
                np.round(pose[:, 0] / (s.cell_m * scale)),
                np.round(pose[:, 1] / (s.cell_m * scale)),
                np.round((pose[:, 2] % (2.0 * np.pi)) / (s.cell_rad * scale)),
                way,
                scale,
            ]
        ).astype(np.int64)
        keys = (cells @ np.array([1_000_003, 7_919_000_017, 104_395_303_000_009, 15_485_863, 32_452_843])).tolist()
        chosen = cheapest_of_each_cell(keys, g.tolist(), self.seen)
        if not chosen:
            return
        rows = np.array(list(chosen.values()))
        h = self.cost.estimate(pose[rows], self.case.start)
        first = nodes.count
        nodes.add(pose[rows], parent[rows], kappa[rows], way[rows], length[rows], g[rows], room[rows], contact[rows])
        come = pose[rows] - self.case.goal
        away = np.hypot(come[:, 0], come[:, 1]) + _TURNED_M * np.abs(come[:, 2])
        outward = _OUTWARD_S * g[rows] - away
        tight = room[rows] <= s.room_m
        for offset, (f, out, inside) in enumerate(zip((g[rows] + s.greed * h).tolist(), outward.tolist(), tight.tolist(), strict=True)):
            heapq.heappush(self.queues[0], (f, first + offset))
            heapq.heappush(self.queues[1 if inside else 2], (out if inside else f, first + offset))

    def _shoot(self, batch: np.ndarray[tuple[int], np.dtype[np.int64]]) -> None:
        """Reeds-Shepp words from the batch to the case's start; whatever is free is an answer."""
        s, nodes = self.settings, self.nodes
        words = reeds_shepp(nodes.pose[batch], self.case.start, 1.0 / self.top)
        price = nodes.g[batch][:, None] + self.cost.words(words, nodes.way[batch], nodes.kappa[batch])
        rows = np.arange(len(batch))[:, None]
        last = np.sign(words[rows, np.arange(words.shape[1]), _LAST_PIECE])
        order = [np.argsort(np.where(last == sign, price, np.inf), axis=1, kind="stable")[:, : s.words] for sign in (1.0, -1.0)]
        choice = np.hstack(order)
        best = min((value for value, _ in self.found.values()), default=np.inf)
        worth = np.isfinite(price[rows, choice]) & (price[rows, choice] < best + _WORTH_S)
        row, column = np.nonzero(worth)
        word = choice[row, column]
        likely = self._likely(nodes.pose[batch[row]], WORD_TURNS[word] * self.top, words[row, word])
        row, word = row[likely], word[likely]
        ranked = np.argsort(price[row, word], kind="stable")[: s.shots]
        shots = []
        for k in ranked:
            lengths = words[row[k], word[k]]
            arcs = merged([Arc(float(t * self.top), float(q)) for t, q in zip(WORD_TURNS[word[k]], lengths, strict=True)])
            shots.append((nodes.pose[batch[row[k]]], arcs, int(batch[row[k]])))
        free = self._free([(pose, arcs) for pose, arcs, _ in shots])
        for (_, arcs, node), good in zip(shots, free, strict=True):
            if good:
                self._arrive(node, arcs)

    def _likely(self, pose: Array, kappa: Array, length: Array) -> NDArray[np.bool_]:
        """Which words are free at the middle and the end of each piece: most are not, and need no closer look."""
        good = np.ones(len(pose), dtype=np.bool_)
        for piece in range(length.shape[1]):
            for share in (0.5, 1.0):
                rows = np.flatnonzero(good)
                there = along_arc(pose[rows], kappa[rows, piece], share * length[rows, piece])
                good[rows] = self.world.clearance(there) >= self.asked
            pose = along_arc(pose, kappa[:, piece], length[:, piece])
        return good

    def _free(self, shots: list[tuple[Array, tuple[Arc, ...]]]) -> list[bool]:
        alive = list(range(len(shots)))
        for step in _SHOT_STEPS_M:
            if not alive:
                break
            poses = [_poses_along(*shots[k], step) for k in alive]
            sound = self.world.clearance(np.concatenate(poses)) >= self.asked
            cuts = np.cumsum([len(p) for p in poses])[:-1]
            alive = [k for k, part in zip(alive, np.split(sound, cuts), strict=True) if part.all()]
        return [k in set(alive) for k in range(len(shots))]

    def _arrive(self, node: int, shot: tuple[Arc, ...]) -> None:
        outwards = merged([*self.nodes.trail(node), *shot])
        arcs = tuple(Arc(arc.curvature, -arc.length) for arc in reversed(outwards))
        path = ArcPath(self.case.start, arcs)
        value = self.cost.path(arcs)
        kind = (path.gear_changes, bool(arcs) and arcs[0].length > 0.0)
        known = self.found.get(kind)
        if known is None or value < known[0]:
            self.found[kind] = (value, path)
            if self.report is not None:
                self.report(path)


def _poses_along(pose: Array, arcs: tuple[Arc, ...], step: float) -> Array:
    """(n, 3): poses at most `step` apart along arcs, without the first."""
    pieces = []
    for arc in arcs:
        count = max(1, int(np.ceil(abs(arc.length) / step)))
        there = along_arc(np.broadcast_to(pose, (count, 3)), np.full(count, arc.curvature), np.linspace(0.0, arc.length, count + 1)[1:])
        pieces.append(there)
        pose = there[-1]
    return np.concatenate(pieces) if pieces else np.zeros((0, 3))
