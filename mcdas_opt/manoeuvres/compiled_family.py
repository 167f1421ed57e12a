"""The members of a family in C (`family.c`): some ten times as fast as the array operations, which say what it does."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.cost_weights import NEARNESS_M
from mcdas_opt.domain.prediction import Prediction, margins_together
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.manoeuvres import clearance, family, lane_change_profiles, phases, starts
from mcdas_opt.manoeuvres.family import Demand, Member, Scored, Scoring
from mcdas_opt.manoeuvres.lane_change_profiles import LaneChangeProfiles
from mcdas_opt.manoeuvres.phases import Phases
from mcdas_opt.native.binding import address, record

_LANES = 8  # samples come in whole lanes
_OF_PHASE, _OF_BODY, _OF_MEMBER, _OF_RESULT = 10, 7, 8, 6  # rows, as the C text numbers them
_STEEPEST_RAD = 1.5  # so far a step of the steering angle is bounded by its tangent
_NO_EDGES = np.empty((3, 0))
_Family = record("family.c", "Family")
USUAL_SAMPLES = 41
NUMBERS_IN_C = {
    "USUAL_ROW": USUAL_SAMPLES + -USUAL_SAMPLES % _LANES,  # loops of a known length take two thirds of the time of others
    "LANES": _LANES,
    "PEAK": lane_change_profiles.PEAK,
    "LEAST_SHIFT_M": lane_change_profiles.LEAST_SHIFT_M,
    "SPEED_FLOOR_MPS": lane_change_profiles.SPEED_FLOOR_MPS,
    "NEAR_M": clearance.NEAR_M,
    "EDGE_M": family.EDGE_M,
    "TICK": family.TICK,
}


class CompiledMembers:
    """What `members.InterpretedMembers` is; separations and costs to 1e-9."""

    def __init__(
        self,
        library: ctypes.CDLL,
        phase: Phases,
        profile: LaneChangeProfiles,
        times_s: Array,
        situation: Situation,
        vehicle: Vehicle,
        prediction: Prediction,
    ) -> None:
        self._prediction, self._samples = prediction, times_s.size
        host, road = situation.host, situation.road
        self._shape = phase.first_mps2.size, profile.target_d_m.size
        filled = -times_s.size % _LANES
        self._times_s = np.concatenate([times_s, np.repeat(times_s[-1:], filled)])
        row = self._times_s.size
        straight = road.is_straight
        knots = np.empty((2, 0)) if straight else road.knots
        self._bend = 0.0 if straight else clearance.BOW * float(np.abs(knots[1]).max())
        self._sample(vehicle, situation)
        self._tables = {
            "phases": np.column_stack([np.ravel(q) for q in (phase.first_mps2, phase.switch_s, phase.then_mps2)]),
            "steps": np.column_stack([np.ravel(q) for q in (profile.target_d_m, profile.lateral_mps2, profile.delay_s, profile.b)]),
            "times": self._times_s,
            "weights": np.concatenate([np.ones(times_s.size), np.zeros(filled)]),
            "bodies": self._bodies,
            "sizes": self._sizes,
            "knots": knots[0],
            "kappas": knots[1],
            "edges": _NO_EDGES if road.edges is None else road.edges.table,
            "by_phase": np.empty((self._shape[0], _OF_PHASE, row)),
            "work": np.empty((_OF_MEMBER, row)),
        }
        self._family = _Family(
            **{name: address(table) for name, table in self._tables.items()},
            count_of_phases=self._shape[0],
            count_of_steps=self._shape[1],
            samples=times_s.size,
            row=row,
            count_of_bodies=len(prediction.bodies),
            count_of_knots=knots.shape[1],
            count_of_edges=0 if road.edges is None else road.edges.table.shape[1],
            **_now(situation, vehicle, float(times_s[1] - times_s[0])),
        )
        self._at = ctypes.addressof(self._family)
        usual = row == NUMBERS_IN_C["USUAL_ROW"]
        (library.mcdas_family_speeds if usual else library.mcdas_family_speeds_any_length)(self._at)
        self._score = library.mcdas_family_score if usual else library.mcdas_family_score_any_length
        self._best = library.mcdas_family_best if usual else library.mcdas_family_best_any_length
        self._states = library.mcdas_family_states if usual else library.mcdas_family_states_any_length
        self.end_speed_mps = self._tables["by_phase"][:, 1, -1:]
        self._host, self._road = host, road

    def _sample(self, vehicle: Vehicle, situation: Situation) -> None:
        """The bodies' places at the times, and their margins."""
        bodies, road, times = self._prediction.bodies, situation.road, self._times_s
        self._bodies = np.empty((len(bodies), _OF_BODY, times.size))
        self._sizes = np.empty((len(bodies), 4))
        self._margins = np.empty((len(bodies), 2, times.size))
        if not bodies:
            return
        n, motion = self._samples, self._prediction.rows_on(times[: self._samples])
        for k, rows in enumerate((motion.s_m, motion.d_m, np.sin(motion.heading_rad), np.cos(motion.heading_rad))):
            self._bodies[:, k, :n], self._bodies[:, k, n:] = rows, rows[:, -1:]
        self._sizes[:, 2] = motion.speed_s_mps[:, -1]
        self._margins[:, 0], self._margins[:, 1] = margins_together(bodies, times)
        self._bodies[:, 4] = road.curvature_at(self._bodies[:, 0]) if self._bend else 0.0
        self._sizes[:, :2] = [(body.length_m, body.width_m) for body in bodies]
        self._sizes[:, 3] = self._bend * (self._sizes[:, 0] ** 2 + vehicle.length_m**2)

    def _set(self, scoring: Scoring) -> None:
        margins, f = scoring.margins, self._family
        for k, fixed in enumerate((margins.along_m, margins.across_m)):
            half = 0.5 * self._sizes[:, k, None] + fixed
            self._bodies[:, 5 + k] = half + margins.share_of_prediction * self._margins[:, k]
        f.clear = scoring.clear_m
        cost = family.WEIGHTS
        f.cost_acceleration, f.cost_speed, f.cost_lateral = cost.acceleration, cost.speed, cost.lateral_acceleration
        f.cost_near, f.nearness, f.cost_change = cost.nearness, NEARNESS_M, cost.lane_change
        f.cost_closing, f.end_room = cost.end_closing, cost.end_room_m

    def scored(self, scoring: Scoring) -> Scored:
        """Every member against everybody."""
        self._set(scoring)
        result = np.empty((_OF_RESULT, *self._shape))
        self._score(self._at, result)
        possible, on_road = result[3] > 0.0, result[4] > 0.0
        return Scored(
            separation_m=result[0],
            contact_s=result[1],
            contact_with=result[2].astype(np.intp),
            possible=possible,
            on_road=on_road,
            feasible=possible & on_road & (result[0] > scoring.clear_m),
            cost=result[5],
        )

    def best(self, scoring: Scoring, kinds: NDArray[np.intp]) -> list[Member]:
        """The cheapest feasible member of each kind (P, Q), without a look at those that cannot be it."""
        self._set(scoring)
        of = np.ascontiguousarray(kinds, dtype=np.int64)
        count = int(of.max()) + 1
        index, values, order = np.empty(count, dtype=np.int64), np.empty((3, count)), np.empty(self._shape[0])
        self._best(self._at, of, count, order, index, values)
        rows = zip(values[0].tolist(), index.tolist(), values[1].tolist(), values[2].tolist(), strict=True)
        return [
            Member(
                phase=i // self._shape[1],
                profile=i % self._shape[1],
                cost=cost,
                separation_m=room,
                contact_s=np.inf,
                contact_with=-1,
                feasible=True,
            )
            for _, i, cost, room in sorted(row for row in rows if row[1] >= 0)
        ]

    def states(self, phase: int, profile: int) -> Array:
        """(T, 6): s, d, psi, v, a, delta of one member."""
        x = np.empty((self._samples, 6))
        self._states(self._at, phase, profile, x)
        return x


def _now(situation: Situation, vehicle: Vehicle, step_s: float) -> dict[str, Any]:
    """Where the car is, what it can do, and the road: what no scoring changes."""
    host, road, demand = situation.host, situation.road, Demand()
    s0, d0, sine0, bend0 = (np.asarray(q).item() for q in starts.rear_axle(host, vehicle, road))
    turn = min(demand.steering * vehicle.steering_rate_max_radps * step_s, _STEEPEST_RAD)
    return {
        "s0": s0,
        "d0": d0,
        "sine0": sine0,
        "bend0": bend0,
        "speed0": host.speed_mps,
        "acceleration0": host.acceleration_mps2,
        "join": max(lane_change_profiles.JOIN_S * host.speed_mps, lane_change_profiles.JOIN_LEAST_M),
        "centre": vehicle.centre_m,
        "wheelbase": vehicle.wheelbase_m,
        "length": vehicle.length_m,
        "width": vehicle.width_m,
        "rise": phases.SHARE * vehicle.jerk_max_mps3,
        "fall": phases.SHARE * vehicle.jerk_min_mps3,
        "top": max(phases.SHARE * vehicle.speed_max_mps, host.speed_mps),
        "grip_squared": (demand.friction * road.friction * GRAVITY_MPS2) ** 2,
        "curvature_max": np.tan(demand.steering * vehicle.steering_max_rad) / vehicle.wheelbase_m,
        "turn_max": np.tan(turn) / vehicle.wheelbase_m,
        "left": road.left_edge_m,
        "right": road.right_edge_m,
        "end": np.inf if road.road_end_s_m is None else road.road_end_s_m,
        "wanted": situation.wanted_speed_mps,
        "lane_d": road.lane_centre_m(situation.host_lane, host.s_m),
        "half_lane": 0.5 * road.lane_width_at(situation.host_lane, host.s_m),
        "reach": 0.5 * np.hypot(vehicle.length_m, vehicle.width_m),
    }
