"""Where a map moves all lanes sideways at once. Networks made from maps do so where a lane begins or ends: by half a lane or a whole one,
within the few metres of a junction. SUMO's vehicles jump there; no car could follow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.interop.sumo.polylines import length_m, shifted, stations_m

_STEP_M = (0.2, 4.5)  # sideways; what is less is no matter, and what is more is no step of all lanes
_SLOPE, _TURN_RAD = 0.15, 0.2  # sideways over along, at least; and the turn from the lanes before to those behind, at most
_END_M = 10.0  # of a lane tells where it leads
_LATERAL_MPS2 = 1.0  # at the speed limit, on the line that passes such a step
_SAMPLE_M = 2.0
_SMALL_M = 0.01


class _Step(NamedTuple):
    at_m: float  # along the pieces
    left_m: float
    half_m: float  # from there to where the line has passed it, and back to where it begins to

    def passed(self, at_m: Array) -> Array:
        """How far the line lies to the left of lanes that go on as before the step, then as behind it."""
        share = np.clip((at_m - self.at_m) / self.half_m, -1.0, 1.0)
        eased = 0.5 + 0.5 * (share + np.sin(math.pi * share) / math.pi)
        return np.asarray(self.left_m * (eased - (at_m > self.at_m)))


class SidewaysSteps:
    """The steps between `pieces`, the middles of one column on the edges of a route, each with its speed limit."""

    def __init__(self, pieces: Sequence[Array], limits_mps: Sequence[float]) -> None:
        self._pieces = pieces
        self._begins_m = [0.0]
        self._steps: dict[int, _Step] = {}
        for k, (piece, following) in enumerate(pairwise(pieces)):
            end_m = self._begins_m[-1] + length_m(piece)
            along_m, left_m, turn_rad = _between(piece, following)
            if abs(turn_rad) < _TURN_RAD and _STEP_M[0] < abs(left_m) < _STEP_M[1] and abs(left_m) > _SLOPE * along_m > 0.0:
                half_m = max(limits_mps[k : k + 2]) * math.sqrt(0.5 * math.pi * abs(left_m) / _LATERAL_MPS2)
                self._steps[k] = _Step(end_m + 0.5 * along_m, left_m, half_m)
            else:
                along_m = float(np.hypot(*(following[0] - piece[-1])))
            self._begins_m.append(end_m + along_m)

    def at(self, k: int) -> bool:
        """Whether there is one behind piece k."""
        return k in self._steps

    def passed(self, k: int) -> Array:
        """Piece k where a line leads that passes the steps as a car could."""
        points, at_m = self._sampled(k)
        return points if points is self._pieces[k] else shifted(points, -self._left_m(at_m)[:, None])

    def moved(self, inside: Sequence[Sequence[Array]]) -> Iterator[tuple[int, Array, Array]]:
        """(k, points, stations along piece k [m]) where that line is not with the lanes, and a little farther: of the pieces, and of the
        lanes `inside` the junction behind each, where there is a step."""
        for k in range(len(self._pieces)):
            points, at_m = self._sampled(k)
            off = np.abs(self._left_m(at_m)) > _SMALL_M
            if off.any():
                kept = off | np.append(off[1:], False) | np.append(False, off[:-1])
                yield k, points[kept], at_m[kept] - self._begins_m[k]
            if k in self._steps:
                for through in inside[k]:
                    yield k, through, np.full(len(through), self._steps[k].at_m - self._begins_m[k])

    def _sampled(self, k: int) -> tuple[Array, Array]:
        """Points and their stations along all pieces: more of them near a step."""
        piece, begin_m = self._pieces[k], self._begins_m[k]
        at_m = begin_m + stations_m(piece)
        if not any(begin_m < step.at_m + step.half_m and at_m[-1] > step.at_m - step.half_m for step in self._steps.values()):
            return piece, at_m
        inside = [np.linspace(a, b, math.ceil((b - a) / _SAMPLE_M), endpoint=False) for a, b in pairwise(at_m)]
        more = np.append(np.concatenate(inside), at_m[-1])
        return np.column_stack([np.interp(more, at_m, piece[:, i]) for i in (0, 1)]), more

    def _left_m(self, at_m: Array) -> Array:
        return np.asarray(sum((step.passed(at_m) for step in self._steps.values()), np.zeros(at_m.size)))


def _between(piece: Array, following: Array) -> tuple[float, float, float]:
    """(along, to the left, turn [rad]) from the end of one to the beginning of the next."""
    before, behind = _way(piece[::-1]), _way(following)
    before = -before
    turn_rad = math.atan2(before[0] * behind[1] - before[1] * behind[0], float(before @ behind))
    mean = (before + behind) / max(float(np.hypot(*(before + behind))), 1e-9)
    gap = following[0] - piece[-1]
    return float(mean @ gap), float(mean[0] * gap[1] - mean[1] * gap[0]), turn_rad


def _way(piece: Array) -> Array:
    """The direction (2,) from its beginning to a place some metres along it."""
    along = stations_m(piece)
    way = np.array([np.interp(_END_M, along, piece[:, i]) for i in (0, 1)]) - piece[0]
    return np.asarray(way / max(float(np.hypot(*way)), 1e-9))
