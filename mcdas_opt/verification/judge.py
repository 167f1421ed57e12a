"""The judge: is this trajectory what a car can drive, from where it is, without touching anybody or leaving the road?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import PredictedBody, Prediction, together
from mcdas_opt.domain.road import Road, local_origin_m
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict, Violation
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.native.library import library
from mcdas_opt.verification.bodies import ALONG_REACHES, collisions
from mcdas_opt.verification.conservative_accept import doubtful_bodies, rows_of, rules_of
from mcdas_opt.verification.finding import Findings
from mcdas_opt.verification.limits import actuators, friction
from mcdas_opt.verification.motion import drive
from mcdas_opt.verification.record import Samples, sampling, started_elsewhere, unreadable
from mcdas_opt.verification.sideslip import sideslip
from mcdas_opt.verification.surface import on_road


def judge(
    trajectory: Trajectory,
    start: HostState | None,
    vehicle: Vehicle,
    road: Road,
    prediction: Prediction,
) -> Verdict:
    """The verdict on anybody's trajectory, by the contract's rules and tolerances; at most one violation a rule and neighbour.

    `start` is the measured state that the trajectory must begin with (None: any). `road.friction` is the friction to judge with.
    Neighbours are the bare bodies of `prediction`, times counted from the trajectory's 0. A trajectory that cannot be driven at all
    (numbers that are not finite, time that does not run) is convicted of that alone.
    """
    return judge_all((trajectory,), start, vehicle, road, prediction)[0]


def judge_all(
    trajectories: Sequence[Trajectory],
    start: HostState | None,
    vehicle: Vehicle,
    road: Road,
    prediction: Prediction,
) -> tuple[Verdict, ...]:
    """`judge` of each; what is accepted at once passes, of the rest those that are sampled at the same times in one go."""
    origin_m = _origin_m(trajectories, start)
    if origin_m:  # s is counted from near the start
        drives = [trajectory.seen_from(origin_m) for trajectory in trajectories]
        begun = None if start is None else start.seen_from(origin_m)
        return judge_all(drives, begun, vehicle, road.seen_from(origin_m), prediction.seen_from(origin_m))
    verdicts: dict[int, Verdict] = {}
    groups: list[list[int]] = []
    slides = sideslip(start, vehicle, road)
    tables = [trajectory.table for trajectory in trajectories]
    compiled, bodies = library() if slides is None else None, rows_of(prediction.bodies)
    rules = rules_of(vehicle, road, ALONG_REACHES)
    doubtful: dict[int, list[int]] = {}  # of drives with which nothing else is wrong, the bodies
    for i, one in enumerate(tables):
        found = unreadable(one)
        if found:
            verdicts[i] = Verdict(violations=tuple(found))
            continue
        if compiled is not None:
            left = doubtful_bodies(compiled, one, start, rules, bodies, _frame(one[1], vehicle, road, prediction))
            if left is not None and not left:
                verdicts[i] = Verdict()
                continue
            if left is not None:
                doubtful[i] = left
        group = next((g for g in groups if np.array_equal(tables[g[0]][0], one[0])), None)
        if group is None:
            groups.append([i])
        else:
            group.append(i)
    for group in groups:
        frame = _frame(np.array([tables[i][1] for i in group]), vehicle, road, prediction)
        examined, passed_by = [i for i in group if i not in doubtful], [i for i in group if i in doubtful]
        if examined:
            findings = _examined(Samples.of([tables[i] for i in examined]), start, vehicle, frame, prediction)
            verdicts |= _told(examined, findings, [] if slides is None else [slides])
        if passed_by:
            near = sorted({body for i in passed_by for body in doubtful[i]})
            findings = _passed_by(Samples.of([tables[i] for i in passed_by]), vehicle, frame, [prediction.bodies[body] for body in near])
            verdicts |= _told(passed_by, findings, [])
    return tuple(verdicts[i] for i in range(len(trajectories)))


def _told(drives: Sequence[int], findings: Findings, of_all: list[Violation]) -> dict[int, Verdict]:
    return {i: Verdict(violations=(*of_all, *violations)) for i, violations in zip(drives, findings.of, strict=True)}


def _origin_m(trajectories: Sequence[Trajectory], start: HostState | None) -> float:
    if start is not None:
        return local_origin_m(start.s_m)
    return local_origin_m(float(trajectories[0].s_m[0])) if trajectories and len(trajectories[0]) else 0.0


def _examined(
    samples: Samples,
    start: HostState | None,
    vehicle: Vehicle,
    frame: FrenetFrame,
    prediction: Prediction,
) -> Findings:
    """Everything that is wrong with readable trajectories of the same times."""
    found = Findings(len(samples.s_m))
    sampling(samples.t_s, found)
    if start is not None:
        started_elsewhere(samples, start, found)
    motion = drive(samples, vehicle, frame, found)
    actuators(samples, motion, vehicle, frame.road, found)
    friction(motion, vehicle, frame.road, found)
    collisions(motion, vehicle, frame, prediction.bodies, prediction.rows_on(motion.every_t_s), found)
    on_road(samples, motion, vehicle, frame, found)
    return found


def _passed_by(samples: Samples, vehicle: Vehicle, frame: FrenetFrame, bodies: Sequence[PredictedBody]) -> Findings:
    """The same of drives with which nothing can be wrong but that they touch one of these bodies."""
    found = Findings(len(samples.s_m))
    motion = drive(samples, vehicle, frame, found)
    collisions(motion, vehicle, frame, bodies, together(bodies, motion.every_t_s), found)
    return found


def _frame(s_m: Array, vehicle: Vehicle, road: Road, prediction: Prediction) -> FrenetFrame:
    """The road's frame, long enough for the host and everybody who may touch it."""
    if road.is_straight:
        return _straight(road)
    longest = max((math.hypot(b.length_m, b.width_m) for b in prediction.bodies), default=0.0)
    pad = ALONG_REACHES * 0.5 * (math.hypot(vehicle.length_m, vehicle.width_m) + longest) + 50.0
    low, high = float(s_m.min()) - pad, float(s_m.max()) + pad
    return _tabulated(road, 100 * math.floor(low / 100.0), 100 * math.ceil(high / 100.0))


@lru_cache(maxsize=32)
def _straight(road: Road) -> FrenetFrame:
    return FrenetFrame(road=road)


@lru_cache(maxsize=32)
def _tabulated(road: Road, s_min_m: int, s_max_m: int) -> FrenetFrame:
    return FrenetFrame(road=road, s_min_m=min(s_min_m, 0), s_max_m=max(s_max_m, 0))
