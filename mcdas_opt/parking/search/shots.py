"""Reeds-Shepp shots: words from poses of the search to the other end, as far as they are free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.path import Arc, along_arc, merged
from mcdas_opt.parking.search.nodes import Nodes, Rows
from mcdas_opt.parking.search.path_cost import PathCost
from mcdas_opt.parking.search.reeds_shepp import WORD_TURNS, reeds_shepp
from mcdas_opt.parking.world import World

_STEPS_M = (0.4, 0.05, 0.008)  # corners that pass corners dip by half a centimetre between points 5 cm apart
_LAST_PIECE = np.array([2] * 16 + [3] * 24 + [4] * 4)  # index of a word's last piece
_DEARER_S = 6.0  # dearer than the best path by this much still gets a shot
_CLOSE_LOOKS = 12  # words of a batch that are looked at closely
_WORDS = 2  # tried per pose and gear at the far end


class Shot(NamedTuple):
    """A free path from a node of the search to the target."""

    node: int
    arcs: tuple[Arc, ...]


@dataclass(frozen=True, slots=True)
class Shots:
    """Shots at one target, clear of the obstacles by `asked_m`, at curvatures up to `top`."""

    world: World
    cost: PathCost
    target: Array
    asked_m: float
    top: float

    def free(self, nodes: Nodes, batch: Rows, best: float) -> list[Shot]:
        """The free ones among the cheapest words from a batch of nodes, where the best path so far costs `best`."""
        words = reeds_shepp(nodes.pose[batch], self.target, 1.0 / self.top)
        cost = nodes.g[batch][:, None] + self.cost.words(words, nodes.direction[batch], nodes.kappa[batch])
        rows = np.arange(len(batch))[:, None]
        last = np.sign(words[rows, np.arange(words.shape[1]), _LAST_PIECE])
        order = [np.argsort(np.where(last == sign, cost, np.inf), axis=1, kind="stable")[:, :_WORDS] for sign in (1.0, -1.0)]
        choice = np.hstack(order)
        cheap = np.isfinite(cost[rows, choice]) & (cost[rows, choice] < best + _DEARER_S)
        row, column = np.nonzero(cheap)
        word = choice[row, column]
        likely = self._likely(nodes.pose[batch[row]], WORD_TURNS[word] * self.top, words[row, word])
        row, word = row[likely], word[likely]
        ranked = np.argsort(cost[row, word], kind="stable")[:_CLOSE_LOOKS]
        shots = []
        for k in ranked:
            pieces = zip(WORD_TURNS[word[k]], words[row[k], word[k]], strict=True)
            shots.append(Shot(int(batch[row[k]]), merged([Arc(float(turn * self.top), float(length)) for turn, length in pieces])))
        return self._closely(nodes, shots)

    def _likely(self, pose: Array, kappa: Array, length: Array) -> NDArray[np.bool_]:
        """Which words are free at the middle and the end of each piece: most are not, and need no closer look."""
        good = np.ones(len(pose), dtype=np.bool_)
        for piece in range(length.shape[1]):
            for share in (0.5, 1.0):
                rows = np.flatnonzero(good)
                there = along_arc(pose[rows], kappa[rows, piece], share * length[rows, piece])
                good[rows] = self.world.clearance(there) >= self.asked_m
            pose = along_arc(pose, kappa[:, piece], length[:, piece])
        return good

    def _closely(self, nodes: Nodes, shots: list[Shot]) -> list[Shot]:
        for step in _STEPS_M:
            if not shots:
                break
            poses = [_poses_along(nodes.pose[shot.node], shot.arcs, step) for shot in shots]
            sound = self.world.clearance(np.concatenate(poses)) >= self.asked_m
            cuts = np.cumsum([len(p) for p in poses])[:-1]
            shots = [shot for shot, part in zip(shots, np.split(sound, cuts), strict=True) if part.all()]
        return shots


def _poses_along(pose: Array, arcs: tuple[Arc, ...], step: float) -> Array:
    """(n, 3): poses at most `step` apart along arcs, without the first."""
    pieces = []
    for arc in arcs:
        count = max(1, int(np.ceil(abs(arc.length) / step)))
        there = along_arc(np.broadcast_to(pose, (count, 3)), np.full(count, arc.curvature), np.linspace(0.0, arc.length, count + 1)[1:])
        pieces.append(there)
        pose = there[-1]
    return np.concatenate(pieces) if pieces else np.zeros((0, 3))
