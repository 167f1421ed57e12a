"""The escape map's questions in C (`time_to_react.c`), which says what `evasive_profiles` and `separation` say."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import CruisingBody, PredictedBody, all_cruise
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.manoeuvres.clearance import BOW, Margins
from mcdas_opt.native.addresses import address
from mcdas_opt.native.binding import record
from mcdas_opt.time_to_react import effort, evasive_profiles, separation
from mcdas_opt.time_to_react.constant_input import EVERY, PASSES
from mcdas_opt.time_to_react.library import CLEAR_S, SHORTEST_S, EscapeSettings
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S, TURNED_STEPS, PredictedTraffic, Rows, lattice_s

_LANES, _ROOM = 8, 104  # nodes come in whole lanes, and there are at most so many
_PIECE = 16  # nodes are looked at so many at a time where a row may go wrong
CaseRecord, _Nodes = (record("time_to_react.c", name) for name in ("Case", "Nodes"))
_NO_EDGES = np.empty((3, 0))
NUMBERS = tuple(name for name, kind, *_ in CaseRecord._fields_ if kind is ctypes.c_double)


class Nodes:
    """Times (T,) of a row on the lattice, as both sides want them: whole lanes, filled up with the last one."""

    def __init__(self, steps: Rows) -> None:
        self.steps = steps
        self.times_s = np.asarray(LATTICE_S * steps, dtype=np.float64)
        missing = -steps.size % _LANES
        filled = np.concatenate([steps, np.repeat(steps[-1:], missing)]).astype(np.int64)
        times_s = np.asarray(LATTICE_S * filled, dtype=np.float64)
        middle = min(int(np.searchsorted(self.times_s, 1.0)), steps.size - 1)
        step_s = np.diff(self.times_s)
        begins = np.flatnonzero(np.abs(np.diff(step_s, prepend=0.0)) > 1e-12)
        until = np.append(begins[1:] + 1, filled.size).astype(np.int64)
        self._kept = filled, until, times_s, step_s[begins]
        self._record = _Nodes(*(q.ctypes.data for q in self._kept), filled.size, steps.size - 1, middle, begins.size)
        self.at = ctypes.addressof(self._record)


def predicted_traffic(library: ctypes.CDLL, bodies: Sequence[PredictedBody], until_s: float, margins: Margins) -> PredictedTraffic:
    """`PredictedTraffic.of`, in C where everybody moves in the one closed form and nobody is grown by the prediction's own margins."""
    if not bodies or not all_cruise(bodies) or margins.share_of_prediction:
        return PredictedTraffic.of(bodies, until_s, margins)
    times = lattice_s(round(until_s / LATTICE_S) + 1)
    begin = np.array(cruisers(bodies, margins))
    tables = np.empty((5, len(bodies), times.size))
    fade_s = bodies[0].lateral_fade_s
    library.mcdas_escape_traffic(len(bodies), times.size, begin, times, fade_s, faded(fade_s, times.size), tables)
    s, d, speed, half_length, half_width = tables
    return PredictedTraffic(s_m=s, d_m=d, speed_mps=speed, half_length_m=half_length, half_width_m=half_width)


def cruisers(bodies: Sequence[CruisingBody], margins: Margins) -> list[float]:
    """What C takes of them, one after the other: how they move, how large they are, and by how much they are grown."""
    numbers: list[float] = []
    for b in bodies:
        numbers += b.s_m, b.d_m, b.speed_s_mps, b.speed_d_mps, b.lateral_fade_s, b.lateral_swell, b.acceleration_mps2, b.changing_s
        numbers += b.length_m, b.width_m, margins.along_m, margins.across_m
    return numbers


def case_constants(
    vehicle: Vehicle, road: Road, chosen: EscapeSettings, straightening_mps2: float
) -> tuple[tuple[float, ...], Array, Array]:
    """What neither the host nor the others change of a case: its numbers, the road's knots as columns (2, K), and its edges (3, K), empty
    where they are the same all along."""
    knots, bend = _knots(road.curvature)
    grip = road.friction * GRAVITY_MPS2
    numbers = (
        *(vehicle.wheelbase_m, vehicle.centre_m, vehicle.length_m, vehicle.width_m, vehicle.jerk_min_mps3, vehicle.jerk_max_mps3),
        *(vehicle.speed_max_mps, vehicle.steering_max_rad, vehicle.steering_rate_max_radps),
        *(chosen.demand.friction * grip, chosen.demand.steering, *available_mps2(vehicle, road.friction)),
        *(road.left_edge_m, road.right_edge_m, np.inf if road.road_end_s_m is None else road.road_end_s_m),
        *(bend, chosen.clear_m, CLEAR_S, chosen.comfort_on(road.friction), SHORTEST_S, straightening_mps2),
    )
    return numbers, knots, _NO_EDGES if road.edges is None else road.edges.table


@lru_cache(maxsize=8)
def _knots(curvature: tuple[tuple[float, float], ...]) -> tuple[Array, float]:
    """A road's knots as columns (2, K), and its tightest bend."""
    return np.array(curvature).T.copy(), max(abs(kappa) for _, kappa in curvature)


@lru_cache(maxsize=8)
def faded(fade_s: float, count: int) -> Array:
    """What is left of a speed across at the lattice's first times."""
    return np.exp(-lattice_s(count) / fade_s)


class CompiledCase:
    """One situation. `table` (6, H) is contiguous: `constant_input` writes into it. `columns` (5, M): of the members; `curvature` (2, K):
    knots; `edges` (3, K)."""

    def __init__(
        self,
        library: ctypes.CDLL,
        traffic: PredictedTraffic,
        table: Array,
        columns: Array,
        curvature: Array,
        edges: Array,
        numbers: tuple[float, ...],
        *,
        in_lane: int,
        half_steps: int,
    ) -> None:
        self._library = library
        bodies, lattice = traffic.s_m.shape
        blocks = (
            traffic.s_m,
            traffic.d_m,
            traffic.speed_mps,
            traffic.half_length_m,
            traffic.half_width_m,
            np.maximum.reduce(traffic.half_length_m, -1),
        )
        self._kept = tuple(map(np.ascontiguousarray, (*blocks, table, columns, curvature, edges)))
        *tables, of_members, of_road, of_edges = (address(block) for block in self._kept)
        self.bodies, self.held_count, self.members = bodies, table.shape[1], columns.shape[1]
        self._case = CaseRecord(
            *tables,
            *range(of_members, of_members + columns.nbytes, columns.strides[0]),
            *(of_road, of_road + curvature.strides[0], of_edges),
            *(bodies, lattice, self.held_count, self.members, in_lane, half_steps, curvature.shape[1], edges.shape[1]),
            *numbers,
        )
        self._at = ctypes.addressof(self._case)

    def constant_input(self, begin: Array, times_s: Array) -> None:
        """Fills the table with what a host does that keeps its inputs from this state (6,) on, at times (H,)."""
        path = np.empty((2, times_s.size))
        self._library.mcdas_escape_constant_input(self._at, begin, times_s, self._case.table, path)

    def needs(self, anchors: Rows, nodes: Nodes) -> tuple[Array, Array, Array]:
        """Below and above which distances (J, K, M) everybody is met by members begun at the anchors (K,); their slack (3, K, M)."""
        shape = anchors.size, self.members
        low, high = np.empty((self.bodies, *shape)), np.empty((self.bodies, *shape))
        slack = np.empty((3, *shape))
        begin = np.ascontiguousarray(anchors, dtype=np.int64)
        self._library.mcdas_escape_needs(self._at, anchors.size, begin, nodes.at, low, high, slack)
        return low, high, slack

    def guess(self, starts_s: Array, weights: Array, apart_m: Array, needs: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        """The last of the starts (N,) in between, by weights (N, K) and distances (J, N), at which members are open; and comfortable.
        And by how many metres they are open at the first of them."""
        size = self.members
        now, last, known = np.empty(size), np.empty((2, size)), np.empty((weights.shape[1], size), dtype=np.uint8)
        given = starts_s, weights, np.ascontiguousarray(apart_m), *needs
        self._library.mcdas_escape_guess(self._at, weights.shape[1], starts_s.size, *given, known, now, last)
        return last[0], last[1], now

    def sound(self, members: Rows, starts: Rows, nodes: Nodes) -> tuple[NDArray[np.bool_], Array]:
        """Which members from these starts (R,) are escapes, and what they ask of the tyres [m/s^2]."""
        good, demand = np.empty(members.size, dtype=np.bool_), np.empty(members.size)
        member, start = np.ascontiguousarray(members, dtype=np.int64), np.ascontiguousarray(starts, dtype=np.int64)
        self._library.mcdas_escape_sound(self._at, members.size, member, start, nodes.at, good, demand)
        return good, demand

    def met(self, clock: Rows, places: Array) -> tuple[int, int]:
        """When (as an index) a host that goes through these places (4, T): s, d, sine, cosine: first meets somebody, and whom; or -1."""
        moments, where = np.ascontiguousarray(clock, dtype=np.int64), np.ascontiguousarray(places)
        whom = ctypes.c_longlong(-1)
        step = self._library.mcdas_escape_met(self._at, clock.size, moments, where, ctypes.byref(whom))
        return int(step), whom.value


NUMBERS_IN_C = {
    "LANES": _LANES,
    "ROOM": _ROOM,
    "PIECE": _PIECE,
    "SHARE": evasive_profiles.SHARE,
    "SLOWEST_MPS": evasive_profiles.SLOWEST_MPS,
    "STEEPEST": evasive_profiles.STEEPEST,
    "LEAST_M": evasive_profiles.LEAST_M,
    "GENTLE_S": evasive_profiles.GENTLE_S,
    "CURVIEST_1PM": evasive_profiles.CURVIEST_1PM,
    "ROUNDS": evasive_profiles.ROUNDS,
    "PASSES": PASSES,
    "EDGE_M": evasive_profiles.EDGE_M,
    "ROOM_SHARE": separation.ROOM_SHARE,
    "NOWHERE_M": separation.NOWHERE_M,
    "STEP_REACH_M": separation.STEP_REACH_M,
    "BOW": BOW,
    "ARRIVED_M": separation.ARRIVED_M,
    "CONSTANT_STEPS": EVERY,
    "TURNED_STEPS": TURNED_STEPS,
    "ABILITY_M": separation.ABILITY_M,
    "LATTICE_S": LATTICE_S,
    **{name: value for name, value in vars(effort).items() if name.isupper()},
}
