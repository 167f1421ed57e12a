"""Out of a tight place from contact to contact: every pose of a zigzag touches something, and cells are as fine as the car is free.

Full lock, straight, or one lock and then the other (the only way to go sideways: single arcs between two contacts move the car across no
farther than its heading changes). Whole batches of equal cost are expanded at once, cheapest first, so that the first ways out are the
quickest; a slot with 3 mm to spare takes a hundred and more gears, and no fixed cell is right for its ends and its middle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.search.nodes import Nodes, cheapest_of_each_cell
from mcdas_opt.parking.search.reeds_shepp import along_arc
from mcdas_opt.parking.world import World

_Rows = NDArray[np.int64]
_WAY = np.array([1_000_003, 7_919_000_017, 104_395_303_000_009, 15_485_863, 32_452_843])


@dataclass(frozen=True, slots=True, kw_only=True)
class CrawlSettings:
    """Caps are counts. Distances in metres."""

    max_nodes: int = 300_000
    out_m: float = 1.2  # an arc longer than this has left the tight place
    beyond_s: float = 8.0  # ways out that cost so much more than the first are kept
    margin_m: float = 2.5e-4  # more clearance than asked: millimetres are what decides here
    batch_s: float = 2.0  # poses whose costs differ by less are expanded at once
    step_m: float = 0.015  # along an arc, before contact is halved in
    steps: int = 60
    halvings: int = 7
    reach_m: float = 3.0
    shrinks: float = 0.7  # the freedom that a pose has is at least this share of its parent's ...
    least_share: float = 0.15  # ... and shorter arcs than this share of it lead nowhere
    least_m: float = 1e-3
    heading_share: float = 0.35  # of what the freedom lets the car turn: a cell's heading
    along_share: float = 0.3  # of the freedom: a cell's length
    across_m: tuple[float, float] = (0.003, 0.05)  # half of what one lock and the other shift, but between these: a cell's width


@dataclass(slots=True)
class Crawl:
    """Fills `nodes` from its root outwards; `ways_out` are the nodes where the tight place is behind."""

    case: ParkingCase
    world: World
    nodes: Nodes
    settings: CrawlSettings = field(default_factory=CrawlSettings)
    ways_out: list[int] = field(default_factory=list)
    _key: list[int] = field(default_factory=lambda: [0])
    _free: list[float] = field(default_factory=lambda: [1.0])
    _seen: dict[int, float] = field(default_factory=dict)
    _waiting: dict[int, list[_Rows]] = field(default_factory=dict)

    @property
    def _top(self) -> float:
        return float(np.tan(self.case.vehicle.steering_max_rad)) / self.case.vehicle.wheelbase_m

    def run(self) -> list[int]:
        """The ways out, cheapest first."""
        nodes, s = self.nodes, self.settings
        self._waiting = {0: [np.zeros(1, dtype=np.int64)]}
        nodes.room[0] = self.world.clearance(nodes.pose[:1])[0]
        while self._waiting and nodes.count < s.max_nodes:
            number = min(self._waiting)
            if self.ways_out and number * s.batch_s > nodes.g[self.ways_out].min() + s.beyond_s:
                break
            rows = np.concatenate(self._waiting.pop(number))
            best = [self._seen.get(self._key[int(i)], np.inf) for i in rows]
            rows = rows[nodes.g[rows] <= np.array(best) + 1e-9]
            if rows.size:
                self._expand(rows, number)
        return sorted(self.ways_out, key=lambda node: float(nodes.g[node]))

    def _expand(self, rows: _Rows, number: int) -> None:
        nodes, s = self.nodes, self.settings
        parent, way = np.repeat(rows, 2), np.tile([1.0, -1.0], rows.size)
        turns = nodes.way[parent] != way
        parent, way = parent[turns], way[turns]
        kappa = np.repeat([1.0, 0.0, -1.0], parent.size) * self._top
        parent, way = np.tile(parent, 3), np.tile(way, 3)
        free, touches = self._walk(nodes.pose[parent], kappa, way, nodes.room[parent])
        bent = np.flatnonzero((kappa != 0.0) & touches & (free > 2.0 * s.step_m))
        half = 0.5 * free[bent]
        middle = along_arc(nodes.pose[parent[bent]], kappa[bent], way[bent] * half)
        on, on_touches = self._walk(middle, -kappa[bent], way[bent], self.world.clearance(middle))
        none = np.zeros_like(free)
        columns = (
            np.concatenate([parent, parent[bent]]),
            np.concatenate([way, way[bent]]),
            np.concatenate([kappa, kappa[bent]]),
            np.concatenate([free, half]),
            np.concatenate([none, -kappa[bent]]),
            np.concatenate([none, on]),
        )
        contact = np.concatenate([touches, on_touches])
        total = columns[3] + columns[5]
        long_enough = total > np.maximum(s.least_m, s.least_share * np.array(self._free)[columns[0]])
        long_enough[free.size :] &= on > 0.0
        parent, way, kappa, length, then, further = (column[long_enough] for column in columns)
        self._admit(parent.astype(np.int64), way, kappa, length, then, further, contact[long_enough], number)

    def _admit(
        self, parent: _Rows, way: Array, kappa: Array, length: Array, then: Array, further: Array, contact: NDArray[np.bool_], number: int
    ) -> None:
        nodes, s = self.nodes, self.settings
        total, two = length + further, further > 0.0
        middle = along_arc(nodes.pose[parent], kappa, way * length)
        pose = along_arc(middle, then, way * further)
        g = nodes.g[parent] + self._seconds(parent, kappa, then, two, total)
        free = np.minimum(np.maximum(total, s.shrinks * np.array(self._free)[parent]), 1.0)
        chosen = cheapest_of_each_cell(self._cells(pose, way, free), g.tolist(), self._seen)
        if not chosen:
            return
        rows = np.array(list(chosen.values()))
        halves = rows[two[rows]]
        before = nodes.count
        nothing = np.zeros(halves.size)
        nodes.add(middle[halves], parent[halves], kappa[halves], way[halves], length[halves], g[halves], nothing, nothing)
        self._key += [0] * halves.size
        self._free += [1.0] * halves.size
        led_by = parent.copy()
        led_by[halves] = before + np.arange(halves.size)
        ends = nodes.count + np.arange(rows.size)
        last, piece = np.where(two, then, kappa), np.where(two, further, length)
        room = self.world.clearance(pose[rows])
        nodes.add(pose[rows], led_by[rows], last[rows], way[rows], piece[rows], g[rows], room, contact[rows])
        self._key += list(chosen)
        self._free += free[rows].tolist()
        out = total[rows] > s.out_m
        self.ways_out += ends[out].tolist()
        batches = np.maximum((g[rows] / s.batch_s).astype(np.int64), number)
        for batch in np.unique(batches[~out]):
            self._waiting.setdefault(int(batch), []).append(ends[~out & (batches == batch)])

    def _seconds(self, parent: _Rows, kappa: Array, then: Array, two: NDArray[np.bool_], total: Array) -> Array:
        """Steering at standstill, and from rest to rest."""
        car = self.case.vehicle
        per = car.steering_max_rad / car.steering_rate_max_radps / self._top
        steer = np.where(self.nodes.way[parent] == 0.0, 0.0, np.abs(kappa - self.nodes.kappa[parent]))
        steer += np.where(two, np.abs(then - kappa), 0.0)
        return np.asarray(per * steer + 2.0 * np.sqrt(total / self.case.limits.acceleration_mps2))

    def _cells(self, pose: Array, way: Array, free: Array) -> list[int]:
        """Keys of cells that are long along the car, thin across it, and as wide in heading as a share of what the next arc turns."""
        s = self.settings
        level = np.floor(np.log2(free))
        size = 2.0**level
        heading = s.heading_share * size * self._top
        across = np.clip(0.125 * size * size * self._top, *s.across_m)
        turn = np.round(pose[:, 2] / heading)
        cosine, sine = np.cos(turn * heading), np.sin(turn * heading)
        along = (pose[:, 0] * cosine + pose[:, 1] * sine) / (s.along_share * size)
        beside = (pose[:, 1] * cosine - pose[:, 0] * sine) / across
        keys: list[int] = (np.column_stack([np.round(along), np.round(beside), turn, way, level]).astype(np.int64) @ _WAY).tolist()
        return keys

    def _walk(self, pose: Array, kappa: Array, way: Array, room: Array) -> tuple[Array, NDArray[np.bool_]]:
        """(free length, whether it ends in contact) of every arc: advanced as far as is safe or a small step, then halved to contact."""
        s = self.settings
        asked = self.case.limits.clearance_m + s.margin_m
        stretch = 1.0 + np.abs(kappa) * self.world.body.reach
        free, beyond = np.zeros(len(pose)), np.full(len(pose), np.inf)
        active = np.arange(len(pose))
        slack = room - asked
        for _ in range(s.steps):
            ahead = np.minimum(free[active] + np.maximum(slack / stretch[active], s.step_m), s.reach_m)
            slack = self.world.clearance(along_arc(pose[active], kappa[active], way[active] * ahead)) - asked
            sound = slack >= 0.0
            free[active[sound]] = ahead[sound]
            beyond[active[~sound]] = ahead[~sound]
            going = sound & (ahead < s.reach_m - 1e-9)
            active, slack = active[going], slack[going]
            if active.size == 0:
                break
        met = np.flatnonzero(np.isfinite(beyond))
        low, high = free[met], beyond[met]
        for _ in range(s.halvings):
            middle = 0.5 * (low + high)
            sound = self.world.clearance(along_arc(pose[met], kappa[met], way[met] * middle)) >= asked
            low, high = np.where(sound, middle, low), np.where(sound, high, middle)
        free[met] = low
        return free, np.isfinite(beyond)
