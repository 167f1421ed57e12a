"""What the escape map in C (`time_to_react.c`) takes of a case: a car, a road, settings, bodies and the nodes of its lattice."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import lru_cache
from operator import attrgetter

import numpy as np

from mcdas_opt.domain.prediction import MOVING, CruisingBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.manoeuvres.clearance import BOW, Margins
from mcdas_opt.native.binding import record
from mcdas_opt.time_to_react import effort, evasive_profiles, separation
from mcdas_opt.time_to_react.constant_input import EVERY, PASSES
from mcdas_opt.time_to_react.library import CLEAR_S, SHORTEST_S, EscapeSettings
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S, TURNED_STEPS, Rows, lattice_s

_LANES, _ROOM = 8, 104  # nodes come in whole lanes, and there are at most so many
_PIECE = 16  # nodes are looked at so many at a time where a row may go wrong
CaseRecord, _Nodes = (record("time_to_react.c", name) for name in ("Case", "Nodes"))
_moving = attrgetter(*MOVING)
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


def cruisers(bodies: Sequence[CruisingBody], margins: Margins) -> list[float]:
    """What C takes of them, one after the other: how they move, how large they are, and by how much they are grown."""
    numbers: list[float] = []
    for b in bodies:
        numbers += (*_moving(b), b.length_m, b.width_m, margins.along_m, margins.across_m)
    return numbers


def case_constants(
    vehicle: Vehicle, road: Road, chosen: EscapeSettings, straightening_mps2: float
) -> tuple[tuple[float, ...], Array, Array]:
    """What neither the host nor the others change of a case: its numbers, the road's knots as columns (2, K), and its edges (3, K), empty
    where they are the same all along."""
    grip = road.grip_mps2
    numbers = (
        *(vehicle.wheelbase_m, vehicle.centre_m, vehicle.length_m, vehicle.width_m, vehicle.jerk_min_mps3, vehicle.jerk_max_mps3),
        *(vehicle.speed_max_mps, vehicle.steering_max_rad, vehicle.steering_rate_max_radps),
        *(chosen.demand.friction * grip, chosen.demand.steering, *available_mps2(vehicle, road.friction)),
        *(road.left_edge_m, road.right_edge_m, np.inf if road.road_end_s_m is None else road.road_end_s_m),
        *(road.sharpest_1pm, chosen.clear_m, CLEAR_S, chosen.comfort_on(road.friction), SHORTEST_S, straightening_mps2),
    )
    return numbers, road.knots, _NO_EDGES if road.edges is None else road.edges.table


@lru_cache(maxsize=8)
def faded(fade_s: float, count: int) -> Array:
    """What is left of a speed across at the lattice's first times."""
    return np.exp(-lattice_s(count) / fade_s)


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
