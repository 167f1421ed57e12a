"""Out of a tight place from contact to contact: every pose of a zigzag touches something, and cells are as fine as the car is free.

Arcs are at full lock, straight, or one lock and then the other. Only the last go sideways: single arcs between two contacts move the car
across no farther than its heading changes. Whole batches of equal cost are expanded at once, cheapest first, so that the first exits are
the quickest. A slot with 3 mm to spare takes a hundred and more gears, and no fixed cell is right for its ends and its middle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.path import along_arc, top_curvature
from mcdas_opt.parking.search.free_arcs import advance
from mcdas_opt.parking.search.nodes import Nodes, cheapest_of_each_cell
from mcdas_opt.parking.world import World

MARGIN_M = 2.5e-4  # more clearance than asked: millimetres are what decides here
_MAX_NODES = 300_000
_OUT_M = 1.2  # an arc longer than this has left the tight place
_BEYOND_S = 8.0  # exits that cost so much more than the first are kept
_BATCH_S = 2.0  # poses whose costs differ by less are expanded at once
_STEP_M = 0.015  # along an arc, before contact is halved in
_STEPS = 60
_HALVINGS = 7
_FREEDOM_SHRINKS = 0.7  # the freedom that a pose has is at least this share of its parent's ...
_LEAST_SHARE = 0.15  # ... and shorter arcs than this share of it lead nowhere
_LEAST_M = 1e-3
_HEADING_SHARE = 0.35  # of what the freedom lets the car turn: a cell's heading
_ALONG_SHARE = 0.3  # of the freedom: a cell's length
_ACROSS_M = (0.003, 0.05)  # half of what one lock and the other shift, but between these: a cell's width

_Rows = NDArray[np.int64]


@dataclass(slots=True)
class ContactSearch:
    """Fills `nodes` from its root outwards; `exits` are the nodes where the tight place is behind."""

    case: ParkingCase
    world: World
    nodes: Nodes
    max_nodes: int = _MAX_NODES
    exits: list[int] = field(default_factory=list)
    _cell_of: list[int] = field(default_factory=lambda: [0])
    _freedom: list[float] = field(default_factory=lambda: [1.0])
    _seen: dict[int, float] = field(default_factory=dict)
    _waiting: dict[int, list[_Rows]] = field(default_factory=dict)

    @property
    def _top(self) -> float:
        return top_curvature(self.case.vehicle)

    def run(self) -> list[int]:
        """The exits, cheapest first."""
        nodes = self.nodes
        self._waiting = {0: [np.zeros(1, dtype=np.int64)]}
        nodes.room[0] = self.world.clearance(nodes.pose[:1])[0]
        while self._waiting and nodes.count < self.max_nodes:
            number = min(self._waiting)
            if self.exits and number * _BATCH_S > nodes.g[self.exits].min() + _BEYOND_S:
                break
            rows = np.concatenate(self._waiting.pop(number))
            best = [self._seen.get(self._cell_of[int(i)], np.inf) for i in rows]
            rows = rows[nodes.g[rows] <= np.array(best) + 1e-9]
            if rows.size:
                self._expand(rows, number)
        return sorted(self.exits, key=lambda node: float(nodes.g[node]))

    def _expand(self, rows: _Rows, number: int) -> None:
        nodes = self.nodes
        parent, direction = np.repeat(rows, 2), np.tile([1.0, -1.0], rows.size)
        turns = nodes.direction[parent] != direction
        parent, direction = parent[turns], direction[turns]
        kappa = np.repeat([1.0, 0.0, -1.0], parent.size) * self._top
        parent, direction = np.tile(parent, 3), np.tile(direction, 3)
        free, touches = self._to_contact(nodes.pose[parent], kappa, direction, nodes.room[parent])
        bent = np.flatnonzero((kappa != 0.0) & touches & (free > 2.0 * _STEP_M))
        half = 0.5 * free[bent]
        middle = along_arc(nodes.pose[parent[bent]], kappa[bent], direction[bent] * half)
        on, on_touches = self._to_contact(middle, -kappa[bent], direction[bent], self.world.clearance(middle))
        none = np.zeros_like(free)
        columns = (
            np.concatenate([parent, parent[bent]]),
            np.concatenate([direction, direction[bent]]),
            np.concatenate([kappa, kappa[bent]]),
            np.concatenate([free, half]),
            np.concatenate([none, -kappa[bent]]),
            np.concatenate([none, on]),
        )
        contact = np.concatenate([touches, on_touches])
        total = columns[3] + columns[5]
        long_enough = total > np.maximum(_LEAST_M, _LEAST_SHARE * np.array(self._freedom)[columns[0]])
        long_enough[free.size :] &= on > 0.0
        parent, direction, kappa, length, then, further = (column[long_enough] for column in columns)
        self._admit(parent.astype(np.int64), direction, kappa, length, then, further, contact[long_enough], number)

    def _admit(
        self,
        parent: _Rows,
        direction: Array,
        kappa: Array,
        length: Array,
        then: Array,
        further: Array,
        contact: NDArray[np.bool_],
        number: int,
    ) -> None:
        """Take in arcs of curvature `kappa`, or of that and then of `then` for `further` metres, into the batch `number` or later ones."""
        nodes = self.nodes
        total, two = length + further, further > 0.0
        middle = along_arc(nodes.pose[parent], kappa, direction * length)
        pose = along_arc(middle, then, direction * further)
        g = nodes.g[parent] + self._seconds(parent, kappa, then, two, total)
        freedom = np.minimum(np.maximum(total, _FREEDOM_SHRINKS * np.array(self._freedom)[parent]), 1.0)
        chosen = cheapest_of_each_cell(self._cells(pose, direction, freedom), g.tolist(), self._seen)
        if not chosen:
            return
        rows = np.array(list(chosen.values()))
        halves = rows[two[rows]]
        before = nodes.count
        nothing = np.zeros(halves.size)
        nodes.add(middle[halves], parent[halves], kappa[halves], direction[halves], length[halves], g[halves], nothing, nothing)
        self._cell_of += [0] * halves.size
        self._freedom += [1.0] * halves.size
        led_by = parent.copy()
        led_by[halves] = before + np.arange(halves.size)
        ends = nodes.count + np.arange(rows.size)
        last, piece = np.where(two, then, kappa), np.where(two, further, length)
        room = self.world.clearance(pose[rows])
        nodes.add(pose[rows], led_by[rows], last[rows], direction[rows], piece[rows], g[rows], room, contact[rows])
        self._cell_of += list(chosen)
        self._freedom += freedom[rows].tolist()
        out = total[rows] > _OUT_M
        self.exits += ends[out].tolist()
        batches = np.maximum((g[rows] / _BATCH_S).astype(np.int64), number)
        for batch in np.unique(batches[~out]):
            self._waiting.setdefault(int(batch), []).append(ends[~out & (batches == batch)])

    def _seconds(self, parent: _Rows, kappa: Array, then: Array, two: NDArray[np.bool_], total: Array) -> Array:
        """Steering at standstill, and from rest to rest."""
        car = self.case.vehicle
        per = car.steering_max_rad / car.steering_rate_max_radps / self._top
        steer = np.where(self.nodes.direction[parent] == 0.0, 0.0, np.abs(kappa - self.nodes.kappa[parent]))
        steer += np.where(two, np.abs(then - kappa), 0.0)
        return np.asarray(per * steer + 2.0 * np.sqrt(total / self.case.limits.acceleration_mps2))

    def _cells(self, pose: Array, direction: Array, freedom: Array) -> Array:
        """Cells that are long along the car, thin across it, and as wide in heading as a share of what the next arc turns."""
        level = np.floor(np.log2(freedom))
        size = 2.0**level
        heading = _HEADING_SHARE * size * self._top
        across = np.clip(0.125 * size * size * self._top, *_ACROSS_M)
        turn = np.round(pose[:, 2] / heading)
        cosine, sine = np.cos(turn * heading), np.sin(turn * heading)
        along = (pose[:, 0] * cosine + pose[:, 1] * sine) / (_ALONG_SHARE * size)
        beside = (pose[:, 1] * cosine - pose[:, 0] * sine) / across
        return np.column_stack([np.round(along), np.round(beside), turn, direction, level])

    def _to_contact(self, pose: Array, kappa: Array, direction: Array, room: Array) -> tuple[Array, NDArray[np.bool_]]:
        """(free length, whether it ends in contact) of every arc; contact is halved in."""
        asked = self.case.limits.clearance_m + MARGIN_M
        free, blocked = advance(self.world, asked, pose, kappa, direction, room, step_m=_STEP_M, steps=_STEPS)
        touches = np.isfinite(blocked)
        met = np.flatnonzero(touches)
        low, high = free[met], blocked[met]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            sound = self.world.clearance(along_arc(pose[met], kappa[met], direction[met] * middle)) >= asked
            low, high = np.where(sound, middle, low), np.where(sound, high, middle)
        free[met] = low
        return free, touches
