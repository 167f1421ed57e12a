"""What the car believes of its surroundings: the case as it was given, corrected by what comes into sight."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array, non_negative, positive
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.clearance import Body, obstacle_field


@dataclass(frozen=True, slots=True, kw_only=True)
class Visitor:
    """Somebody who stands at (x, y) from `from_s` until `until_s`; a square as wide as a pedestrian with a bag."""

    x_m: float
    y_m: float
    from_s: float
    until_s: float = 1e9
    width_m: float = 0.6
    name: str = "pedestrian"

    def __post_init__(self) -> None:
        require_types(self)
        non_negative("from_s", self.from_s, "s")
        positive("width_m", self.width_m, "m")
        if not self.until_s > self.from_s:
            raise ParameterError("until_s", self.until_s, "must be later than from_s", "s")

    def outline(self, clearance_m: float = 0.0) -> Array:
        """(4, 2), counter-clockwise, `clearance_m` wider on every side."""
        half = 0.5 * self.width_m + clearance_m
        return np.array([self.x_m, self.y_m]) + half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])

    def there(self, now_s: float) -> bool:
        return self.from_s <= now_s < self.until_s


class Sight:
    """Obstacles come into sight within `range_m` of the body; with the first that is not as believed, the goal is corrected as well."""

    def __init__(self, case: ParkingCase, truth: ParkingCase, visitors: tuple[Visitor, ...], range_m: float) -> None:
        if len(case.obstacles) != len(truth.obstacles):
            raise ParameterError("truth", len(truth.obstacles), f"must have the {len(case.obstacles)} obstacles of the case, in its order")
        self.belief, self._truth, self._range = case, truth, range_m
        self._visitors, self._seen = visitors, tuple(v.there(-1.0) for v in visitors)
        self._body = Body.of(case.vehicle)
        self._hidden = [k for k, (a, b) in enumerate(zip(case.obstacles, truth.obstacles, strict=True)) if not np.array_equal(a, b)]

    def look(self, now_s: float, pose: Array) -> tuple[str, ...]:
        """What has changed in the belief, in words."""
        news: list[str] = []
        for k in tuple(self._hidden):
            both, _ = obstacle_field((self._truth.obstacles[k], self.belief.obstacles[k]))
            if both.clearance(pose[None], self._body)[0] < self._range:
                self._hidden.remove(k)
                outlines = tuple(self._truth.obstacles[i] if i == k else o for i, o in enumerate(self.belief.obstacles))
                slot = self.belief.slot if self._truth.slot == self.belief.slot else None
                self.belief = replace(self.belief, obstacles=outlines, goal=self._truth.goal, slot=slot)
                news.append(f"{self.belief.names[k]} is not where it was believed to be")
        seen = tuple(v.there(now_s) for v in self._visitors)
        for visitor, now, before in zip(self._visitors, seen, self._seen, strict=True):
            if now != before:
                news.append(f"{visitor.name} {'appears' if now else 'is gone'}")
        self._seen = seen
        return tuple(news)

    def with_visitors(self, clearance_m: float) -> ParkingCase:
        """The belief and everybody who is seen, each with a clearance."""
        return standing_by(self.belief, [v for v, seen in zip(self._visitors, self._seen, strict=True) if seen], clearance_m)


def standing_by(case: ParkingCase, visitors: list[Visitor], clearance_m: float = 0.0) -> ParkingCase:
    """The case with the visitors among its obstacles."""
    if not visitors:
        return case
    outlines = tuple(v.outline(clearance_m) for v in visitors)
    return replace(case, obstacles=(*case.obstacles, *outlines), names=(*case.names, *(v.name for v in visitors)))
