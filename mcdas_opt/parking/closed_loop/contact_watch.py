"""Whom the true car touches, and how near it comes to anything."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body, PolygonField, obstacle_field
from mcdas_opt.parking.closed_loop.sight import Visitor, standing_by


class ContactWatch:
    """`struck` names the first obstacle or visitor that was touched; `least_m` is the least clearance so far (infinite: nothing there)."""

    def __init__(self, truth: ParkingCase, visitors: tuple[Visitor, ...]) -> None:
        self.struck: str | None = None
        self.least_m = np.inf
        self._truth, self._visitors, self._body = truth, visitors, Body.of(truth.vehicle)
        self._fields: dict[tuple[bool, ...], tuple[PolygonField, list[str]]] = {}

    def look(self, poses: Array, now_s: float) -> None:
        """Measure the body at `poses` (n, 3) against everything that is there now."""
        around, names = self._around(now_s)
        apart = around.separation(poses, self._body)
        if not apart.size:
            return
        part = int(np.argmin(apart.min(axis=0)))
        self.least_m = min(self.least_m, float(apart.min()))
        if apart.min() < 0.0:
            self.struck = names[part]

    def _around(self, now_s: float) -> tuple[PolygonField, list[str]]:
        there = tuple(visitor.there(now_s) for visitor in self._visitors)
        if there not in self._fields:
            case = standing_by(self._truth, [visitor for visitor, is_there in zip(self._visitors, there, strict=True) if is_there])
            field, owner = obstacle_field(case.obstacles)
            self._fields[there] = (field, [case.names[k] for k in owner])
        return self._fields[there]
