"""A family's members: how each one moves, and what that costs against predicted bodies; in C where there is a compiler."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.manoeuvres.compiled_family import CompiledMembers
from mcdas_opt.manoeuvres.family import Member, Scored, Scoring, best_of_each, roll_out, score
from mcdas_opt.manoeuvres.lane_change_profiles import LaneChangeProfiles
from mcdas_opt.manoeuvres.phases import Phases
from mcdas_opt.native.library import library


class Members(Protocol):
    """Phases (P, 1) by lane-change profiles (1, Q) at the times (T,) of an even grid."""

    @property
    def end_speed_mps(self) -> Array: ...  # (P, 1)
    def scored(self, scoring: Scoring) -> Scored: ...  # arrays (P, Q)
    def best(self, scoring: Scoring, kinds: NDArray[np.intp]) -> list[Member]: ...  # the cheapest feasible of each kind (P, Q), in order
    def states(self, phase: int, profile: int) -> Array: ...  # (T, 6): s, d, psi, v, a, delta of one member


class InterpretedMembers:
    """The members as array operations: where there is no compiler, and the reference of the compiled ones."""

    def __init__(
        self, phases: Phases, profiles: LaneChangeProfiles, times_s: Array, situation: Situation, vehicle: Vehicle, prediction: Prediction
    ) -> None:
        self._phases, self._profiles, self._times_s = phases, profiles, times_s
        self._situation, self._vehicle, self._prediction = situation, vehicle, prediction
        self._rolled = roll_out(phases, profiles, times_s, situation.host, vehicle, situation.road)

    @property
    def end_speed_mps(self) -> Array:
        return np.asarray(self._rolled.speeds.speed_mps[..., -1])

    def scored(self, scoring: Scoring) -> Scored:
        """Every member against everybody."""
        situation, road = self._situation, self._situation.road
        lane, s_m = situation.host_lane, situation.host.s_m
        middle, half = road.lane_centre_m(lane, s_m), 0.5 * road.lane_width_at(lane, s_m)
        return score(self._rolled, self._prediction, self._vehicle, road, situation.wanted_speed_mps, middle, half, scoring)

    def best(self, scoring: Scoring, kinds: NDArray[np.intp]) -> list[Member]:
        """The cheapest feasible member of each kind."""
        scored = self.scored(scoring)
        return best_of_each(np.where(scored.feasible, scored.cost, np.inf), scored, kinds)

    def states(self, phase: int, profile: int) -> Array:
        """(T, 6) of one member, driven alone, so that it does not depend on its place among the others: it mirrors with its situation."""
        one, other = self._phases[phase : phase + 1], self._profiles[:, profile : profile + 1]
        return roll_out(one, other, self._times_s, self._situation.host, self._vehicle, self._situation.road).states((0, 0))


def members(
    phases: Phases, profiles: LaneChangeProfiles, times_s: Array, situation: Situation, vehicle: Vehicle, prediction: Prediction
) -> Members:
    """The members of phases (P, 1) and lane-change profiles (1, Q), compiled where that is possible."""
    compiled = library()
    if compiled is None:
        return InterpretedMembers(phases, profiles, times_s, situation, vehicle, prediction)
    return CompiledMembers(compiled, phases, profiles, times_s, situation, vehicle, prediction)
