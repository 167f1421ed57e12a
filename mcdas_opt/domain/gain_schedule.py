"""The sigmoid's parameters over speed, offset and friction."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import Array, finite, floats, positive, unit_of, vector
from mcdas_opt.errors import ParameterError

Grid = tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class GainSchedule:
    """Tables (friction, offset, speed) of a, b and y_max at the crossings of three increasing axes.

    `offset_m` is the front vehicle's, towards the side that is steered to. Between the crossings a v, b and y_max are linear in each
    axis (a v, because it is constant where lateral acceleration alone binds); beyond the ends they are held.
    """

    name: str
    speed_mps: Grid
    offset_m: Grid
    friction: Grid
    a_per_m: Array
    b: Array
    y_max_m: Array
    length_m: Array

    def __post_init__(self) -> None:
        require_types(self)
        for name, given in (("speed_mps", self.speed_mps), ("offset_m", self.offset_m), ("friction", self.friction)):
            axis = vector(name, given, unit_of(name))
            if axis.size < 1 or np.any(axis[1:] <= axis[:-1]):
                raise ParameterError(name, given, "must increase", unit_of(name))
            object.__setattr__(self, name, tuple(axis.tolist()))
        positive("speed_mps", self.speed_mps[0], "m/s")
        shape = (len(self.friction), len(self.offset_m), len(self.speed_mps))
        tables = {"a_per_m": self.a_per_m, "b": self.b, "y_max_m": self.y_max_m, "length_m": self.length_m}
        for name, filled in tables.items():
            table = floats(name, filled, f"must be a finite table of {shape}: friction, offset, speed")
            if table.shape != shape or not np.all(np.isfinite(table)):
                raise ParameterError(name, f"a table of {table.shape}", f"must be a finite table of {shape}: friction, offset, speed")
            table.setflags(write=False)
            object.__setattr__(self, name, table)
        if np.any(self.a_per_m >= 0.0):
            raise ParameterError("a_per_m", float(self.a_per_m.max()), "must be less than 0", "1/m")
        if np.any(self.b <= 1.0):
            raise ParameterError("b", float(self.b.min()), "must be greater than 1")

    def at(self, speed_mps: float, offset_m: float, friction: float) -> tuple[float, float, float]:
        """(a [1/m], b, y_max [m]) at a point; some ten multiplications, no array is made."""
        v = min(max(speed_mps, self.speed_mps[0]), self.speed_mps[-1])
        steepness = b = y_max = 0.0
        for i, share_i in _weights(self.friction, friction):
            for j, share_j in _weights(self.offset_m, offset_m):
                for k, share_k in _weights(self.speed_mps, v):
                    share = share_i * share_j * share_k
                    steepness += share * self.a_per_m.item(i, j, k) * self.speed_mps[k]
                    b += share * self.b.item(i, j, k)
                    y_max += share * self.y_max_m.item(i, j, k)
        return steepness / max(speed_mps, self.speed_mps[0]), b, y_max


def _weights(axis: Grid, at: float) -> tuple[tuple[int, float], ...]:
    """The one or two crossings around a point, with their shares."""
    finite("at", at)
    if at <= axis[0]:
        return ((0, 1.0),)
    if at >= axis[-1]:
        return ((len(axis) - 1, 1.0),)
    right = bisect_right(axis, at)
    share = (at - axis[right - 1]) / (axis[right] - axis[right - 1])
    return ((right - 1, 1.0 - share), (right, share))
