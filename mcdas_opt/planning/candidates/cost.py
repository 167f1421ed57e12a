"""What driving a candidate costs, by one measure for all."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.cost_weights import NEARNESS_M, CostWeights
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.dynamics.bicycle import lateral_acceleration
from mcdas_opt.native.library import library
from mcdas_opt.planning.candidates.nearness import Nearness, nearness
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.front.headway import missing_headway
from mcdas_opt.planning.proposals.comfortable_speed import bends_ahead
from mcdas_opt.situation.attentive_followers import line_ahead_m
from mcdas_opt.situation.passing_room import passing_gap_m


def trajectory_cost(trajectory: Trajectory, cycle: Cycle, weights: CostWeights) -> float:
    """`driving_costs` of one."""
    return driving_costs(nearness((trajectory,), cycle), cycle, weights)[0]


def driving_costs(near: Nearness, cycle: Cycle, weights: CostWeights) -> list[float]:
    """Of each of the drives the cost of discomfort, of being off the desired speed, of being near to others, and of how it leaves things
    at its end; without the cost of changing lanes."""
    drives = near.tables
    t, missing, closeness = drives[0, 0], None, None
    others = near.others
    if others.ends:
        missing = missing_headway(drives, others.motion, others.halves_m, cycle.situation.host, cycle.front_gap.headway)
        closeness = np.exp(-np.maximum(np.minimum.reduce(near.separation_m, axis=1), 0.0) / NEARNESS_M)
    rate = _rate(drives, missing, closeness, cycle, weights)
    if cycle.is_ordinary:
        allowed_mps = max(cycle.limit_mps, cycle.situation.host.speed_mps)
        if drives[:, 4].max() > allowed_mps:
            rate = rate + weights.haste * np.maximum(drives[:, 4] - allowed_mps, 0.0) ** 2
    if cycle.people:
        rate = rate + weights.people * _missing_beside_people(near, cycle) ** 2
    totals: list[float] = np.add.reduce(0.5 * (rate[:, 1:] + rate[:, :-1]) * (t[1:] - t[:-1]), axis=1).tolist()
    line_m = line_ahead_m(cycle.situation, cycle.vehicle)
    if line_m is not None:
        over = near.tables[:, 1, -1] > line_m - 0.5 * cycle.vehicle.length_m
        totals = [total + weights.stop_line * is_over for total, is_over in zip(totals, over.tolist(), strict=True)]
    if not others.ends:
        return totals
    ends, gaps = drives[:, 1:5, -1].tolist(), near.separation_m[:, :, -1].tolist()
    for i, ((end_s, end_d, _, end_v), its_gaps) in enumerate(zip(ends, gaps, strict=True)):
        for (width, s, d, speed), gap in zip(others.ends, its_gaps, strict=True):
            if abs(d - end_d) - width > weights.end_room_m:
                continue
            closing = max(end_v - speed if s > end_s else speed - end_v, 0.0)
            totals[i] += weights.end_closing * closing**2 / max(gap, 1.0)
    return totals


def _missing_beside_people(near: Nearness, cycle: Cycle) -> Array:
    """(drives, n) [m]: the most that is missing of the distance that being faster than one of them asks for."""
    asked_m = passing_gap_m(near.tables[:, np.newaxis, 4], near.others.motion.speed_s_mps[cycle.people])
    return np.asarray(np.maximum.reduce(np.maximum(asked_m - near.separation_m[:, cycle.people], 0.0), axis=1))


def _rate(drives: Array, missing: Array | None, closeness: Array | None, cycle: Cycle, weights: CostWeights) -> Array:
    """(drives, n): cost per second; in C where there is a compiler, with the same bits."""
    lateral = lateral_acceleration(drives[:, 4], drives[:, 6], cycle.vehicle.wheelbase_m, np)
    desired_mps, limits = _desired_mps(drives, cycle), cycle.settings.comfort.limits(cycle.situation.host.speed_mps)
    discomfort, compiled = weights.discomfort if cycle.is_ordinary else 0.0, library()
    if compiled is not None:
        of_time = weights.acceleration, weights.lateral_acceleration, weights.jerk, weights.speed, weights.headway, weights.nearness
        numbers = np.array((*of_time, discomfort, limits.acceleration_mps2, limits.braking_mps2, limits.jerk_mps3))
        desired, found = np.asarray(desired_mps), np.empty(lateral.shape)
        given = lateral, desired, desired.ndim > 0, missing, closeness
        compiled.mcdas_cost_rate(*lateral.shape, drives, *given, numbers, found)
        return found
    v, a, jerk = drives[:, 4], drives[:, 5], drives[:, 8]
    rate = weights.acceleration * a**2 + weights.lateral_acceleration * lateral**2 + weights.jerk * jerk**2
    rate = rate + weights.speed * (v - desired_mps) ** 2
    if discomfort > 0.0:
        along = np.maximum(a / limits.acceleration_mps2, -a / limits.braking_mps2)
        rate = rate + discomfort * np.maximum(np.maximum(along, np.abs(jerk) / limits.jerk_mps3) - 1.0, 0.0) ** 2
    if missing is not None and closeness is not None:
        rate = rate + weights.headway * missing**2
        rate = rate + weights.nearness * closeness
    return np.asarray(rate)


def _desired_mps(drives: Array, cycle: Cycle) -> Array | float:
    """The desired speed; while nothing threatens no more than is comfortable in the bends: (drives, n). Where more than gentle braking is
    called for by somebody ahead alone, being slower costs nothing down to his speed: it is put off else until there is no room left."""
    desired, ahead = cycle.situation.wanted_speed_mps, cycle.assessment
    if not cycle.is_ordinary:
        if cycle.is_pressed or ahead.front_id is None or ahead.front_speed_mps is None:
            return desired
        return np.clip(drives[:, 4], min(max(ahead.front_speed_mps, 0.0), desired), desired)
    if cycle.situation.road.is_straight:
        return desired
    bends = bends_ahead(cycle, cycle.lane_centre_m)
    return desired if bends is None else np.minimum(desired, bends.at(drives[:, 1]))
