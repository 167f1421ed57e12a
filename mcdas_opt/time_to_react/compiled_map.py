"""The whole map in one call of C, from plain numbers: `time_to_react/answer.h`."""

from __future__ import annotations

import ctypes
import math
import struct
import threading
from array import array
from functools import lru_cache
from typing import Any

import numpy as np

from mcdas_opt.domain.escapes import Closer
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction, all_cruise
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.native.binding import address, record
from mcdas_opt.time_to_react.compiled_case import NUMBERS, CaseRecord, case_constants, cruisers, faded
from mcdas_opt.time_to_react.guess import EXACT_NODES, GUESS_NODES, KEPT_TIMES_S
from mcdas_opt.time_to_react.library import CLEAR_S, KINDS, LATEST_S, EscapeSettings, Spread, forces, spread_of
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S, PredictedTraffic, lattice_s
from mcdas_opt.time_to_react.search import Found

_CLOSERS = (Closer.FRONT, Closer.REAR, Closer.SIDE, Closer.EDGE, Closer.FRICTION, None)  # as the C numbers them; -1 is nobody
_KEPT = 16  # grounds that are remembered
_ANSWER = struct.Struct(f"{1 + len(KINDS)}d{1 + 3 * len(KINDS)}q")
_GroundRecord, _SpreadRecord = (record("time_to_react.c", name) for name in ("Ground", "Spread"))


class _Manoeuvres:
    """The members with lanes to these sides, as C takes them."""

    def __init__(self, spread: Spread) -> None:
        whole = tuple(np.ascontiguousarray(q, dtype=np.int64) for q in (spread.kind, spread.matching, spread.comfortable))
        shares = tuple(np.ascontiguousarray(q) for q in (spread.pace, spread.until_s, spread.push))
        self._kept = whole, shares
        self._record = _SpreadRecord(*map(address, whole), *map(address, shares), spread.kind.size, spread.in_lane, spread.comfortable.size)
        self.at = ctypes.addressof(self._record)


class _Ground:
    """What a car, a road and the settings make of every map. Never changed but for what it remembers of lanes that were asked for."""

    def __init__(self, vehicle: Vehicle, road: Road, chosen: EscapeSettings) -> None:
        self.vehicle, self.road, self.chosen = vehicle, road, chosen
        self.until_s = LATEST_S + CLEAR_S
        self.steps = round(self.until_s / LATTICE_S) + 1
        of_any = forces(road, HostState(), vehicle, chosen)
        self.forces = of_any if road.is_straight else None
        numbers, knots, edges = case_constants(vehicle, road, chosen, of_any.gentle)
        times_s = lattice_s(self.steps)
        self._kept = knots, edges, times_s
        bare = CaseRecord(lattice=self.steps, moments=KEPT_TIMES_S.size, half_steps=round(0.5 * CLEAR_S / LATTICE_S))
        bare.count_of_knots, bare.knots, bare.kappas = knots.shape[1], address(knots), address(knots) + knots.strides[0]
        bare.edges, bare.count_of_edges = address(edges), edges.shape[1]
        for name, number in zip(NUMBERS, numbers, strict=True):
            setattr(bare, name, number)
        near_m = 0.5 * road.lane_width_m + 0.5
        self._record = _GroundRecord(bare, address(KEPT_TIMES_S), address(times_s), GUESS_NODES.at, EXACT_NODES.at, near_m, LATEST_S)
        self.at = ctypes.addressof(self._record)
        self._lanes: dict[int, tuple[_Manoeuvres, float, float]] = {}

    def lanes(self, situation: Situation) -> tuple[_Manoeuvres, float, float]:
        """The members, and the middles of the lanes to the left and the right [m], NaN without; they depend on the host's lane alone, on a
        road whose lanes are the same all along."""
        lane = situation.host_lane
        known = None if self.road.lanes else self._lanes.get(lane)
        if known is None:
            left, right = (next_lane_m(situation, self.vehicle, side) for side in (Side.LEFT, Side.RIGHT))
            manoeuvres = _Manoeuvres(spread_of(left is not None, right is not None))
            known = manoeuvres, math.nan if left is None else left, math.nan if right is None else right
            self._lanes[lane] = known
        return known


class _Room(threading.local):
    """Numbers that a thread's calls write into before they read them, so that what was there does not matter."""

    def __init__(self) -> None:
        self.of_size(1 << 15)

    def of_size(self, size: int) -> None:
        numbers = np.full(size, math.nan)  # memory is touched now, not within the first map
        self.size, self.numbers, self.at = size, numbers.data, address(numbers)


_ROOM = _Room()
_GROUNDS: dict[tuple[int, Road, int], _Ground] = {}


def answered(library: ctypes.CDLL, situation: Situation, vehicle: Vehicle, prediction: Prediction, chosen: EscapeSettings) -> Found:
    """What `search.found` says of the same case."""
    ground, host, bodies = _ground(vehicle, situation.road, chosen), situation.host, prediction.bodies
    manoeuvres, left_m, right_m = ground.lanes(situation)
    there = ground.forces or forces(ground.road, host, vehicle, chosen)
    asked = [host.s_m, host.d_m, host.heading_rad, host.speed_mps, host.acceleration_mps2, host.steering_rad, left_m, right_m, *there]
    tables, fade, fade_s = None, None, math.nan
    if not all_cruise(bodies) or chosen.margins.share_of_prediction:
        tables = _tables(PredictedTraffic.of(bodies, ground.until_s, chosen.margins))
    elif bodies:
        fade_s = bodies[0].lateral_fade_s
        fade = _faded(fade_s, ground.steps)
        asked += cruisers(bodies, chosen.margins)
    numbers = array("d", asked)
    given = ground.at, manoeuvres.at, numbers.buffer_info()[0], len(bodies), fade_s, fade and fade.at, tables and tables.at
    wanted = library.mcdas_escape_answer(*given, _ROOM.size, _ROOM.at)
    if wanted > _ROOM.size:
        _ROOM.of_size(wanted)
        library.mcdas_escape_answer(*given, _ROOM.size, _ROOM.at)
    return _read(_ANSWER.unpack_from(_ROOM.numbers))


def _ground(vehicle: Vehicle, road: Road, chosen: EscapeSettings) -> _Ground:
    """As made before for the very same car and settings, which it keeps, so that their names stay theirs, and for such a road."""
    key = id(vehicle), road, id(chosen)
    known = _GROUNDS.get(key)
    if known is None:
        if len(_GROUNDS) >= _KEPT:
            _GROUNDS.clear()
        known = _GROUNDS[key] = _Ground(vehicle, road, chosen)
    return known


class _Table:
    """Numbers, and where they lie: to be asked for that takes longer than it seems."""

    def __init__(self, numbers: Array) -> None:
        self.numbers, self.at = numbers, address(numbers)


def _tables(traffic: PredictedTraffic) -> _Table:
    return _Table(np.array((traffic.s_m, traffic.d_m, traffic.speed_mps, traffic.half_length_m, traffic.half_width_m)))


@lru_cache(maxsize=8)
def _faded(fade_s: float, count: int) -> _Table:
    return _Table(faded(fade_s, count))


def _read(answer: tuple[Any, ...]) -> Found:
    end_s, *rest = answer
    count = len(KINDS)
    now, ender, start, easy, closers = rest[:count], rest[count], rest[count + 1 : -2 * count], rest[-2 * count : -count], rest[-count:]
    return Found(
        end_s,
        _CLOSERS[ender],
        (start, easy),
        [None if asked == math.inf else asked for asked in now],
        [_CLOSERS[who] for who in closers],
    )
