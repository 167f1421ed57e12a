"""The other half of the oracle: a proof that nobody could have avoided it.

The sets of (place, speed) that the relaxed vehicle may be in are carried forward in time, one for each answer to "where am I to
whom": behind a neighbour, ahead of it, or beside it. While a bumper cannot have got aside far enough, being neither behind nor ahead
is a collision. When every set is empty, no drive avoids everything. What is left out (neighbours that are in the way only of a car that
has moved aside, neighbours past caring) only adds drives that there are not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import PredictedBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.evaluation.relaxed_vehicle import EDGE_M, QUADRATURE_M, STEP_S, Beside, RelaxedVehicle
from mcdas_opt.evaluation.speed_sets import at_least, at_most, hull, moved, with_speed

_SLIVER = 0.8  # of its width that is still counted of a neighbour that stands at an angle
_SETS = 64  # more answers than that are not followed up


class _Where(Enum):
    """Of the host, to one neighbour; `PAST`: it can stay beside it, or the neighbour will never be in the way again."""

    UNSET = "unset"
    BEHIND = "behind"
    AHEAD = "ahead"
    BESIDE = "beside"
    PAST = "past"


_Answers = tuple[_Where, ...]


@dataclass(frozen=True, kw_only=True)
class _Passage:
    """One side of a neighbour, for one bumper: how far aside that must be over the times (T,) [m], whether it can be, and whether it
    can be from then on."""

    bumper: Beside
    needed_m: Array
    open: NDArray[np.bool_]
    stays_open: NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class _Obstacle:
    """What of a neighbour is certainly there, over the times (T,): places of its ends, whether it is in the way of a car that keeps its
    d, and whether it will be again; how the front and the rear bumper can get past."""

    rear_s_m: Array
    front_s_m: Array
    in_way: NDArray[np.bool_]
    in_way_later: NDArray[np.bool_]
    front_passages: tuple[_Passage, ...]
    rear_passages: tuple[_Passage, ...]


def closes_at(host: HostState, vehicle: Vehicle, road: Road, bodies: Sequence[PredictedBody], duration_s: float) -> float | None:
    """The time by which every drive from `host` has met one of the bodies or left the road; None where this method cannot show it. Times of
    the bodies are counted from the host's state."""
    if duration_s < STEP_S:
        return None
    car = RelaxedVehicle(host=host, vehicle=vehicle, road=road, duration_s=duration_s)
    obstacles = [it for it in (_obstacle(body, car) for body in bodies) if bool(it.in_way.any())]
    start = np.array([[host.s_m - vehicle.centre_m, host.speed_mps]])
    sets: dict[_Answers, Array] = {(_Where.UNSET,) * len(obstacles): start}
    for k in range(1, len(car.times_s)):
        if len(sets) > _SETS or any(all(where is _Where.PAST for where in answers) for answers in sets):
            return None
        sets = {answers: _moved(car, corners, k) for answers, corners in sets.items()}
        for number, obstacle in enumerate(obstacles):
            sets = _sorted_out(car, obstacle, number, sets, k)
        if not sets:
            return float(car.times_s[k])
    return None


def _moved(car: RelaxedVehicle, corners: Array, k: int) -> Array:
    least, most = float(car.braking_mps2[k - 1]), float(car.driving_mps2[k - 1])
    corners = with_speed(corners, car.weaving_mps(k))
    short = car.short_mps(k, corners[:, 1])
    return at_most(at_least(moved(corners, STEP_S, least, most, short, car.faster), 1, 0.0), 1, car.top_speed_mps)


def _sorted_out(car: RelaxedVehicle, it: _Obstacle, number: int, sets: dict[_Answers, Array], k: int) -> dict[_Answers, Array]:
    """The sets at time k, by where they are to one neighbour."""
    out: dict[_Answers, Array] = {}
    for answers, corners in sets.items():
        for where, part in _answered(car, it, answers[number], corners, k):
            if len(part):
                key = (*answers[:number], where, *answers[number + 1 :])
                out[key] = hull(np.vstack([out[key], part])) if key in out else part
    return out


def _answered(car: RelaxedVehicle, it: _Obstacle, where: _Where, corners: Array, k: int) -> Iterator[tuple[_Where, Array]]:
    """The parts of a set at time k. Nobody gets from behind to ahead but beside."""
    if where is _Where.PAST or not it.in_way[k]:
        yield (where if where is _Where.PAST else _Where.UNSET if it.in_way_later[k] else _Where.PAST), corners
        return
    vehicle, upright = car.vehicle, float(np.cos(car.heading_rad[k])) * (1.0 - car.reach_1)
    if where is not _Where.AHEAD:
        nose = (vehicle.wheelbase_m + vehicle.front_overhang_m) * upright
        yield _Where.BEHIND, at_most(corners, 0, float(it.rear_s_m[k]) - nose)
        yield from _beside(car, it.front_passages, corners, k)
    if where is not _Where.BEHIND:
        yield _Where.AHEAD, at_least(corners, 0, float(it.front_s_m[k]) + vehicle.rear_overhang_m * upright)
        yield from _beside(car, it.rear_passages, corners, k)


def _beside(car: RelaxedVehicle, passages: tuple[_Passage, ...], corners: Array, k: int) -> Iterator[tuple[_Where, Array]]:
    """The parts that may have that bumper clear of the neighbour sideways."""
    start = car.host.s_m - car.vehicle.centre_m + car.host.speed_mps * float(car.times_s[k])
    for passage in passages:
        if passage.open[k]:
            least, most = car.along_m(k, passage.bumper, float(passage.needed_m[k]))
            part = at_least(at_most(corners, 0, start + most), 0, start + least)
            yield (_Where.PAST if passage.stays_open[k] else _Where.BESIDE), part


def _obstacle(body: PredictedBody, car: RelaxedVehicle) -> _Obstacle:
    """A neighbour that stands at an angle, or on a bend, is taken for a rectangle along the road that lies inside it.

    To be clear of it, a bumper's middle must be aside by half its width and half the host's shadow: whoever is turned towards it has a
    corner farther aside than that, whoever is turned away from it another part of the flank.
    """
    motion, vehicle, road = body.at(car.times_s), car.vehicle, car.road
    tilt = np.abs(motion.heading_rad)
    sine, cosine, turned = np.sin(tilt), np.cos(tilt), tilt > 1e-6
    width = np.where(turned, _SLIVER * body.width_m, body.width_m)
    inside = np.minimum((body.width_m - width * cosine) / np.maximum(sine, 1e-6), (body.length_m - width * sine) / np.maximum(cosine, 1e-6))
    length = np.where(turned, np.maximum(inside, 0.0), body.length_m) * (1.0 - car.reach_1)
    bow = car.bend_1pm * (body.length_m**2 + vehicle.length_m**2) / (1.0 - car.reach_1)
    clear = np.maximum(0.5 * (width + vehicle.width_m * np.cos(car.heading_rad)) - bow, 0.0)
    aside = motion.d_m - car.host.d_m
    in_way = np.abs(aside) < clear
    needs = vehicle.width_m - EDGE_M - bow
    left, right = road.left_edge_m - motion.d_m - 0.5 * width >= needs, motion.d_m - 0.5 * width - road.right_edge_m >= needs
    sides = ((left, aside + clear), (right, clear - aside))

    def passages(bumper: Beside) -> tuple[_Passage, ...]:
        found = []
        for room, needed in sides:
            possible = room & (bumper.most_m >= needed)
            stays = np.logical_and.accumulate((possible | ~in_way)[::-1])[::-1]
            found.append(_Passage(bumper=bumper, needed_m=needed, open=possible, stays_open=np.asarray(stays)))
        return tuple(found)

    return _Obstacle(
        rear_s_m=motion.s_m - 0.5 * length + QUADRATURE_M,
        front_s_m=motion.s_m + 0.5 * length - QUADRATURE_M,
        in_way=in_way,
        in_way_later=np.asarray(np.logical_or.accumulate(in_way[::-1])[::-1]),
        front_passages=passages(car.front),
        rear_passages=passages(car.rear),
    )
