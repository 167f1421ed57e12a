"""One lane of a road along it, where it is not as the road says of all its lanes."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from operator import attrgetter

import numpy as np

from mcdas_opt.domain.rules import FARTHEST_M, Array, finite, true_or_false, within, word
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError

Knots = tuple[tuple[float, float], ...]
WIDTHS_M = (0.0, 20.0)
SPEED_LIMITS_MPS = (0.1, 150.0)
NEAREST_KNOTS_M = 1e-6  # so that they stay apart wherever along the road one counts from
_ZERO_M = 1e-300  # a place nearer to 0 is 0: between one and the other a width has no finite slope


@dataclass(frozen=True, slots=True, kw_only=True)
class Lane:
    """`lane` counts from the host's first lane, 0, to the left.

    `width_m` holds knots (s [m], width [m]), linear in between and held at both ends; 0: there is no lane. Empty: the road's width.
    `speed_limit_mps` holds (s [m], limit [m/s]), each from there on, the first before too. Empty: the road's limit.
    `closed_m` holds stretches (from s, to s) [m] in which nobody may drive; whatever is beyond a closed lane is out of reach there.
    `oncoming`: its traffic comes towards the host; `shoulder`: it has no traffic of its own. Both are road, but no lane to change into.
    `merges` is of lane 0 alone: to which side its traffic goes where it narrows or is closed; its border to that side stays where it is.
    Without, it narrows about its middle.
    """

    lane: int
    width_m: Knots = ()
    speed_limit_mps: Knots = ()
    closed_m: Knots = ()
    oncoming: bool = False
    shoulder: bool = False
    merges: Side = Side.NONE
    _widths: Array = field(init=False, repr=False, compare=False)  # (2, n): s and width of the knots

    def __post_init__(self) -> None:
        if isinstance(self.lane, bool) or not isinstance(self.lane, int):
            raise ParameterError("lane", self.lane, "must be a whole number")
        for name, rule, pair in (
            ("width_m", lambda value: within("width_m", value, *WIDTHS_M, "m"), "[s_m, width_m]"),
            ("speed_limit_mps", lambda value: within("speed_limit_mps", value, *SPEED_LIMITS_MPS, "m/s"), "[s_m, limit_mps]"),
            ("closed_m", lambda value: _place("closed_m", value), "[from_s_m, to_s_m]"),
        ):
            object.__setattr__(self, name, _pairs(name, attrgetter(name)(self), rule, pair))
        for begin, end in self.closed_m:
            if not end - begin >= NEAREST_KNOTS_M:
                raise ParameterError("closed_m", [begin, end], f"must begin before it ends, by at least {NEAREST_KNOTS_M:g}", "m")
            if abs(end) > 2.0 * FARTHEST_M:
                raise ParameterError("closed_m", [begin, end], f"must lie within {2.0 * FARTHEST_M:g} of 0", "m")
        object.__setattr__(self, "oncoming", true_or_false("oncoming", self.oncoming))
        object.__setattr__(self, "shoulder", true_or_false("shoulder", self.shoulder))
        object.__setattr__(self, "merges", word("merges", self.merges, Side))
        if self.merges is not Side.NONE and self.lane != 0:
            raise ParameterError("merges", self.merges.value, "is said of lane 0 alone: the others give way on their outer side")
        for name, said in (("oncoming", self.oncoming), ("shoulder", self.shoulder)):
            if said and self.lane == 0:
                raise ParameterError(name, True, "must not be said of lane 0, the host's own")
        object.__setattr__(self, "_widths", np.ascontiguousarray(np.reshape(self.width_m, (-1, 2)).T))

    def differs_from(self, width_m: float, limit_mps: float) -> bool:
        """Whether anything is said that a road of such lanes, with such a limit, does not say already."""
        widths, limits = {width for _, width in self.width_m}, {limit for _, limit in self.speed_limit_mps}
        return bool(widths - {width_m} or limits - {limit_mps} or self.closed_m or self.oncoming or self.shoulder)

    def width_at(self, s_m: Array | float, usual_m: float) -> Array:
        """Its width [m] at s [m], of the shape of `s_m`."""
        if not self.width_m:
            return np.full(np.shape(s_m), usual_m)
        return np.asarray(np.interp(s_m, *self._widths))

    def ends_m(self, s_m: float, width_m: float, usual_m: float) -> float:
        """How far it goes on from s: where it is first narrower than `width_m` or closed, infinite where it never is; not at all (minus
        infinity) where it is so at s."""
        end = min((begin for begin, until in self.closed_m if until > s_m), default=math.inf)
        before, wide = s_m, float(self.width_at(s_m, usual_m))
        if end <= s_m or wide < width_m:
            return -math.inf
        places, widths = self._widths
        first = int(places.searchsorted(s_m, side="right"))
        narrower = np.flatnonzero(widths[first:] < width_m)
        if not narrower.size:
            return end
        k = first + int(narrower[0])
        if k > first:
            before, wide = float(places[k - 1]), float(widths[k - 1])
        return min(end, before + (float(places[k]) - before) * (wide - width_m) / (wide - float(widths[k])))

    def seen_from(self, s_m: float) -> Lane:
        """The same with its s counted from `s_m`; not asked again whether it is sound."""
        moved = copy.copy(self)
        places, widths = self._widths[0] - s_m, self._widths[1]
        object.__setattr__(moved, "_widths", np.array([places, widths]))
        object.__setattr__(moved, "width_m", tuple(zip(places.tolist(), widths.tolist(), strict=True)))
        object.__setattr__(moved, "speed_limit_mps", tuple((s - s_m, limit) for s, limit in self.speed_limit_mps))
        object.__setattr__(moved, "closed_m", tuple((begin - s_m, end - s_m) for begin, end in self.closed_m))
        return moved


def _pairs(name: str, given: Iterable[Iterable[float]], rule: Callable[[float], float], pair: str) -> Knots:
    """Pairs of finite numbers, their s increasing, the second by the rule."""
    try:
        pairs = tuple((_place(name, s), rule(value)) for s, value in given)
    except (TypeError, ValueError) as error:
        raise error if isinstance(error, ParameterError) else ParameterError(name, given, f"must be a list of {pair} pairs") from None
    s = [first for first, _ in pairs]
    if any(abs(one) > 2.0 * FARTHEST_M for one in s):
        raise ParameterError(name, given, f"s_m must lie within {2.0 * FARTHEST_M:g} of 0", "m")
    if any(after - before < NEAREST_KNOTS_M for before, after in pairwise(s)):
        raise ParameterError(name, given, f"s_m must increase, by at least {NEAREST_KNOTS_M:g}", "m")
    return pairs


def _place(name: str, s_m: float) -> float:
    """A finite s [m]."""
    s_m = finite(name, s_m, "m")
    return 0.0 if abs(s_m) < _ZERO_M else s_m
