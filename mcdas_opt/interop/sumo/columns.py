"""Which column of a route's lanes its line follows: lane 0 of the road."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from mcdas_opt.interop.sumo.polylines import length_m
from mcdas_opt.interop.sumo.route import Edge

_AHEAD_M = 1000.0


def main_column(edges: Sequence[Edge]) -> int:
    """The column that goes along most of the route; of several the one nearest to 0."""
    along_m: Counter[int] = Counter()
    for edge in edges:
        for column in edge.columns:
            along_m[column] += round(length_m(edge.nearest(column).shape))
    return min(along_m, key=lambda column: (-along_m[column], abs(column), column))


def column_past_others(edges: Sequence[Edge], base: int) -> int:
    """`base`; but where it ends ahead, and others end between it and the nearest lane that leads on, that one, if it is better off and is
    there from the first of these edges on: a road of ours tells of the end of its lane 0, and of lanes beyond which none leads on."""
    ends_m, beyond = _end_behind_others(edges, base)
    return beyond if beyond in edges[0].columns and _end_behind_others(edges, beyond)[0] > ends_m else base


def _end_behind_others(edges: Sequence[Edge], base: int) -> tuple[float, int]:
    """How far ahead a column, or whichever beside it leads on, ends so, and the one that leads on there; infinitely far, and itself, where
    none does within a while."""
    far_m = 0.0
    for edge, following in pairwise(edges):
        far_m += length_m(edge.nearest(base).shape)
        leading = [lane.column for lane in edge.lanes if lane.goes_on and lane.column in following.columns]
        if base in edge.columns and base not in leading:
            nearest = min(leading, key=lambda column: abs(column - base), default=base)
            if abs(nearest - base) > 1:
                return far_m, nearest
            base = nearest
        if far_m > _AHEAD_M:
            break
    return math.inf, base
