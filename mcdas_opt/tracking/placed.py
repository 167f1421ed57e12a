"""Bodies by their place along the road: which of them meet another one, without asking all of them."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from typing import Generic, TypeVar

Place = tuple[float, float]  # (s, d)
Size = tuple[float, float]  # (length, width)
T = TypeVar("T")
_ROUNDING_M = 1.0


class PlacedBodies(Generic[T]):
    """Bodies aligned with the road. Two meet that are nearer than `share` of touching in both directions."""

    def __init__(self, share: float) -> None:
        self._share = share
        self._s_m: list[float] = []
        self._bodies: list[tuple[Place, Size, T]] = []
        self._longest_m = 0.0

    def add(self, body: T, place: Place, size: Size) -> None:
        at = bisect_right(self._s_m, place[0])
        self._s_m.insert(at, place[0])
        self._bodies.insert(at, (place, size, body))
        self._longest_m = max(self._longest_m, size[0])

    def meeting(self, place: Place, size: Size) -> Iterator[T]:
        """Those that meet a body there."""
        within_m = 0.5 * self._share * (self._longest_m + size[0]) + _ROUNDING_M
        for k in range(bisect_left(self._s_m, place[0] - within_m), bisect_right(self._s_m, place[0] + within_m)):
            there, other, body = self._bodies[k]
            if overlap(place, size, there, other, self._share):
                yield body


def overlap(a: Place, a_size: Size, b: Place, b_size: Size, share: float) -> bool:
    """Whether two bodies aligned with the road are nearer than `share` of touching in both directions."""
    along = 0.5 * share * (a_size[0] + b_size[0])
    across = 0.5 * share * (a_size[1] + b_size[1])
    return abs(a[0] - b[0]) < along and abs(a[1] - b[1]) < across
