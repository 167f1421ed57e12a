"""A case whose members are asked in C which of them are escapes: brute force asks so many that numpy takes too long."""

from __future__ import annotations

import ctypes

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.native.binding import address
from mcdas_opt.time_to_react.compiled_case import CaseRecord, Nodes, case_constants
from mcdas_opt.time_to_react.guess import EXACT_NODES, Case
from mcdas_opt.time_to_react.library import CLEAR_S, SIDEWAYS, EscapeSettings, Members
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S, Rows


class CompiledCase(Case):
    """As `Case`, with `sound` in C."""

    def __init__(
        self,
        library: ctypes.CDLL,
        situation: Situation,
        vehicle: Vehicle,
        prediction: Prediction,
        chosen: EscapeSettings,
        among: Members | None = None,
    ) -> None:
        super().__init__(situation, vehicle, prediction, chosen, among)
        self._library, of, traffic = library, self.members, self.traffic
        columns = np.array((of.level_mps2, of.until_s, of.until_mps, of.target_d_m, of.lateral_mps2))
        numbers, knots, edges = case_constants(vehicle, situation.road, chosen, of.straightening_mps2)
        tables = traffic.s_m, traffic.d_m, traffic.speed_mps, traffic.half_length_m, traffic.half_width_m
        longest, widest = (half.max(-1) for half in (traffic.half_length_m, traffic.half_width_m))
        sides = traffic.d_m.min(-1) - widest, traffic.d_m.max(-1) + widest
        self._kept = tuple(map(np.ascontiguousarray, (*tables, longest, *sides, self.table, columns, knots, edges)))
        *at, of_members, of_road, of_edges = (address(block) for block in self._kept)
        bodies, lattice = traffic.s_m.shape
        in_lane, half_steps = int(of.kind.searchsorted(SIDEWAYS)), round(0.5 * CLEAR_S / LATTICE_S)
        self._record = CaseRecord(
            *at,
            *range(of_members, of_members + columns.nbytes, columns.strides[0]),
            *(of_road, of_road + knots.strides[0], of_edges),
            *(bodies, lattice, self.times_s.size, of.kind.size, in_lane, half_steps, knots.shape[1], edges.shape[1]),
            *numbers,
        )

    def sound(self, member: Rows, starts: Rows, nodes: Nodes = EXACT_NODES) -> tuple[NDArray[np.bool_], Array]:
        good, demand = np.empty(member.size, dtype=np.bool_), np.empty(member.size)
        asked, begin = np.ascontiguousarray(member, dtype=np.int64), np.ascontiguousarray(starts, dtype=np.int64)
        self._library.mcdas_escape_sound(ctypes.addressof(self._record), member.size, asked, begin, nodes.at, good, demand)
        return good, demand
