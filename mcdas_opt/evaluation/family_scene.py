"""One draw from a family's ranges as a scene's document."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.evaluation.family_ranges import CutInSpread, CutOutSpread, FrontSpread, Ranges, RearSpread, SideSpread
from mcdas_opt.evaluation.spread import Number, draw

_LENGTH_M = 4.5  # of a neighbour
_WIDTH_M = 1.8
_APART_M = 1.0  # bumper to bumper at the start, at least
_DRAWS = 200
_TOP_MPS = 45.0
_QUINTIC_PEAK = 1.875  # largest speed of a quintic move over its mean
_SLOWEST_MPS = 0.1  # at which a bend that asks for so much is looked for
_SLIDE = 0.5  # sideways speed over speed along the road, at most: about 27 degrees of heading
_PASSING_M = 0.2  # between two cars that pass one another

Document = dict[str, Any]


class _ImpossibleError(Exception):
    """What was drawn cannot be: two cars in one place, or one that slides sideways."""


def document_of(ranges: Ranges, rng: np.random.Generator) -> Document | None:
    """A scene without name and seed; None for a combination that cannot be."""
    try:
        return _Draw(ranges, rng).document()
    except _ImpossibleError:
        return None


class _Draw:
    """One pass over the ranges, always in the same order."""

    def __init__(self, ranges: Ranges, rng: np.random.Generator) -> None:
        self._ranges, self._rng = ranges, rng
        self._vehicle: Vehicle = load_vehicle(ranges.host.vehicle)
        self._speed = 0.0
        road = ranges.road
        self._road: Document = {
            "lane_width_m": self._of(road.lane_width_m),
            "friction": self._of(road.friction),
            "lanes_left": int(self._of(road.lanes_left)),
            "lanes_right": int(self._of(road.lanes_right)),
        }
        self._speed = self._of(ranges.host.speed_mps)
        self._event = self._of(ranges.event_s)
        self._grip = self._road["friction"] * GRAVITY_MPS2
        self._host: Document = {"vehicle": ranges.host.vehicle, "speed_mps": self._speed}
        eager = self._of(ranges.host.eager_mps)
        if eager:
            self._host["desired_speed_mps"] = min(self._speed + eager, self._vehicle.speed_max_mps)
        bend = draw(road.bend_mps2, rng, self._speed)
        if bend:
            kappa = bend / max(self._speed, _SLOWEST_MPS) ** 2
            self._road["curvature"] = [[0.0, kappa]]
            # the heading at which the body's centre goes along the bend while the rear axle does not slip
            self._host["heading_rad"] = -math.atan(kappa * self._vehicle.centre_m)

    def document(self) -> Document:
        ranges, neighbours = self._ranges, []
        if ranges.front is not None:
            neighbours += self._ahead(ranges.front)
        if ranges.rear is not None:
            neighbours.append(self._behind(ranges.rear))
        for name, sign, lanes in (("left", 1, self._road["lanes_left"]), ("right", -1, self._road["lanes_right"])):
            if lanes:
                neighbours += self._beside(ranges.side, name, sign * self._road["lane_width_m"])
        if ranges.cut_in is not None:
            neighbours.append(self._cutting_in(ranges.cut_in))
        return {
            "duration_s": ranges.duration_s,
            "road": self._road,
            "host": self._host,
            "neighbour": neighbours,
            "sensors": dict(ranges.sensors),
        }

    def _of(self, number: Number) -> float:
        return draw(number, self._rng, self._speed)

    def _ahead(self, front: FrontSpread) -> list[Document]:
        """The front car, with whoever stands in its way or beside it."""
        v = max(self._speed - self._of(front.slower_mps), 0.0)
        if front.speed_mps is not None:
            v = self._of(front.speed_mps)
        length, width = self._of(front.length_m), self._of(front.width_m)
        s = self._between(length) + self._gap_ahead(front, v)
        car: Document = {"name": "front", "s_m": s, "speed_mps": v}
        if (length, width) != (_LENGTH_M, _WIDTH_M):
            car |= {"length_m": length, "width_m": width}
        d = self._offset(front, width)
        if d:
            car["d_m"] = d
        wanted = self._of(front.braking_mps2)
        until = v * (1.0 - self._of(front.braking_share))
        if front.until_mps is not None:
            until = self._of(front.until_mps)
        car |= self._braking(wanted, self._event, until)
        found = [car]
        if self._ranges.blockade is not None:
            stagger = self._of(self._ranges.blockade.stagger_m)
            for name, lanes, sign in (("left", self._road["lanes_left"], 1), ("right", self._road["lanes_right"], -1)):
                for lane in range(1, lanes + 1):
                    place = {"name": f"block-{name}-{lane}", "s_m": s + stagger, "d_m": sign * lane * self._road["lane_width_m"]}
                    found.append(car | place)
        if self._ranges.cut_out is not None:
            found.append(self._revealed(self._ranges.cut_out, car, length, width))
        return found

    def _gap_ahead(self, front: FrontSpread, v: float) -> float:
        if front.ttc_s is None:
            return self._distance(front.gap_m, front.headway_s, self._speed)
        if self._speed - v < 0.1:
            raise _ImpossibleError
        return self._of(front.ttc_s) * (self._speed - v)

    def _offset(self, front: FrontSpread, width_m: float) -> float:
        if front.overlap is None:
            return self._of(front.offset_m)
        overlap = self._of(front.overlap)
        apart = max(0.5 * (self._vehicle.width_m + width_m) - abs(overlap) * self._vehicle.width_m, 0.0)
        return apart if overlap < 0.0 else -apart

    def _behind(self, rear: RearSpread) -> Document:
        v = min(max(self._speed + self._of(rear.faster_mps), 0.0), _TOP_MPS)
        car: Document = {
            "name": "rear",
            "s_m": -self._between(_LENGTH_M) - self._distance(rear.gap_m, rear.headway_s, v),
            "speed_mps": v,
        }
        if rear.follows:
            reaction = self._of(rear.reaction_s)
            return car | {"behaviour": "idm"} | ({"reaction_s": reaction} if reaction != 1.0 else {})
        wanted = self._of(rear.braking_mps2)
        return car | self._braking(wanted, self._event + self._of(rear.after_s), 0.0) if wanted else car

    def _beside(self, side: SideSpread, name: str, d_m: float) -> list[Document]:
        """Cars in one lane that neither overlap now nor run through one another later: the one ahead is the faster."""
        count = int(self._of(side.cars))
        for _ in range(_DRAWS):
            places = sorted(self._of(side.ahead_m) for _ in range(count))
            if all(after - before >= _LENGTH_M + _APART_M for before, after in pairwise(places)):
                break
        else:
            places = places[:1]
        speeds = sorted(self._of(side.speed_ratio) * self._speed for _ in places)
        return [
            {"name": f"{name}-{i}", "s_m": s, "d_m": d_m, "speed_mps": v}
            for i, (s, v) in enumerate(zip(places, speeds, strict=True), start=1)
        ]

    def _cutting_in(self, cut: CutInSpread) -> Document:
        slower, gap, side = self._of(cut.slower_mps), self._of(cut.gap_m), self._of(cut.side)
        v = self._speed - slower
        begins = self._between(_LENGTH_M) + gap + slower * self._event  # at the event it is gap_m ahead
        lateral, push = self._of(cut.lateral_mps), self._of(cut.acceleration_mps2)
        piece = self._move(v, 0.0, lateral) | {"acceleration_mps2": float(np.clip(push, -self._grip, self._grip))}
        if min(v, v + push * piece["duration_s"]) < lateral / _SLIDE:
            raise _ImpossibleError
        return {"name": "cut-in", "s_m": begins, "d_m": side * self._road["lane_width_m"], "speed_mps": v, "motion": [piece]}

    def _revealed(self, cut: CutOutSpread, front: Document, length_m: float, width_m: float) -> Document:
        """Who stands there; the front car gets the script of leaving, and must be past before it would touch."""
        ahead, side, v = self._of(cut.ahead_m), self._of(cut.side), front["speed_mps"]
        piece = self._move(v, side * self._road["lane_width_m"], self._of(cut.lateral_mps))
        if v <= 0.0 or abs(side) * self._road["lane_width_m"] * _quintic(ahead / v / piece["duration_s"]) < width_m + _PASSING_M:
            raise _ImpossibleError
        front["motion"] = [piece]
        return {"name": "revealed", "s_m": front["s_m"] + v * self._event + length_m + ahead, "speed_mps": 0.0}

    def _move(self, v_mps: float, to_d_m: float, lateral_mps: float) -> Document:
        """The lateral piece, as long as its largest sideways speed asks for."""
        if v_mps < lateral_mps / _SLIDE:
            raise _ImpossibleError
        duration = _QUINTIC_PEAK * self._road["lane_width_m"] / lateral_mps
        return {"start_s": self._event, "lateral_to_m": to_d_m, "duration_s": duration}

    def _between(self, length_m: float) -> float:
        return 0.5 * (self._vehicle.length_m + length_m)

    def _distance(self, gap_m: Number | None, headway_s: Number | None, speed_mps: float) -> float:
        if gap_m is not None:
            return self._of(gap_m)
        assert headway_s is not None
        return max(self._of(headway_s) * speed_mps, 2.0)

    def _braking(self, wanted_mps2: float, start_s: float, until_mps: float) -> Document:
        """A script that brakes, never beyond the grip."""
        if wanted_mps2 == 0.0:
            return {}
        return {"motion": [{"start_s": start_s, "acceleration_mps2": -min(wanted_mps2, self._grip), "until_speed_mps": until_mps}]}


def _quintic(x: float) -> float:
    """How much of a quintic move is done after the share x of its time."""
    x = min(x, 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x)
