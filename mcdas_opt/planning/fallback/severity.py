"""How bad a drive is where nothing passes: the equivalent speed of its first impact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.prediction import CruisingBody, PredictedBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.candidates.nearness import nearness
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage

_OFF_THE_ROAD, _THIRD_VEHICLE = 1e3, 1e2  # m/s added: worse than any impact with the vehicles that threaten
_ON_THE_EDGE_M = 0.02  # a corner so far over the road's edge is rounding
_LEAST_SHARE = 0.5
_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)  # of a lane change foretold


def severity(trajectory: Trajectory, cycle: Cycle) -> tuple[float, float]:
    """(equivalent impact speed [m/s], minus the time [s]) of the first overlap; (0, -inf) when there is none. Leaving the road is
    worst, the farther the worse.

    The equivalent speed is the relative speed times the square root of the share of the narrower body's width that overlaps: the energy is
    taken as absorbed over that share. At least a half counts: a graze is not to be bought with braking that a moment later is missed.
    Of two that are met at once the worse counts. Whoever was not in the host's lane is a third vehicle, not to be hit to spare
    oneself; the road's end is a wall.

    Who may be changing lanes is foretold to come as fast as is believed of anybody, while who brakes or accelerates is foretold to do what
    he shows. So the speed is the mean over lane changes of all shares of that one: what fails only if he comes that fast is less severe
    than what fails in any case, as braking beside him. A model of this project, to rank candidates, not to predict injuries.
    """
    return severities((trajectory,), cycle)[0]


def severity_in_words(speed_mps: float) -> str:
    """What a severity stands for."""
    if speed_mps >= _OFF_THE_ROAD:
        return "leaves the road"
    if speed_mps >= _THIRD_VEHICLE:
        return f"hits a third vehicle, equivalent to {speed_mps - _THIRD_VEHICLE:.1f} m/s"
    return f"equivalent to {speed_mps:.1f} m/s"


def severities(trajectories: Sequence[Trajectory], cycle: Cycle) -> list[tuple[float, float]]:
    """`severity` of each; those that are sampled at the same times in one go. Where the deadline is near, a lane change comes as fast as is
    believed of anybody, and no slower."""
    groups: dict[bytes, list[int]] = {}
    for i, trajectory in enumerate(trajectories):
        groups.setdefault(trajectory.t_s.tobytes(), []).append(i)
    alone = [_Alone.of(trajectory, cycle) for trajectory in trajectories]
    found: dict[int, list[tuple[float, float]]] = {}
    for supposed in [cycle.prediction] if cycle.is_late_for(Stage.FOLLOWER) else _slower_changes(cycle.prediction):
        supposing = replace(cycle, prediction=supposed)
        for group in groups.values():
            near = nearness([trajectories[i] for i in group], supposing)
            for i, separation in zip(group, near.separation_m, strict=True):
                found.setdefault(i, []).append(_severity(trajectories[i], alone[i], supposing, separation))
    each = (found[i] for i in range(len(trajectories)))
    return [(sum(speed for speed, _ in of) / len(of), of[0][1]) for of in each]


def _slower_changes(prediction: Prediction) -> list[Prediction]:
    """The prediction, and the same with everybody who may be changing lanes coming only some share as far, down to hardly at all."""
    if not any(isinstance(body, CruisingBody) and body.lateral_swell > 0.0 for body in prediction.bodies):
        return [prediction]
    return [Prediction(name=prediction.name, bodies=tuple(_slower(body, share) for body in prediction.bodies)) for share in _SHARES]


def _slower(body: PredictedBody, share: float) -> PredictedBody:
    return replace(body, lateral_swell=share * body.lateral_swell) if isinstance(body, CruisingBody) else body


class _Alone(NamedTuple):
    """What a drive meets whoever else is there: how far a corner is over the road's edge at most, and the sample at the road's end."""

    beyond_m: float
    wall: int | None

    @classmethod
    def of(cls, trajectory: Trajectory, cycle: Cycle) -> _Alone:
        vehicle, road = cycle.vehicle, cycle.situation.road
        reach = 0.5 * (vehicle.width_m * np.cos(trajectory.heading_rad) + vehicle.length_m * np.abs(np.sin(trajectory.heading_rad)))
        left, right = road.left_edge_at(trajectory.s_m), road.right_edge_at(trajectory.s_m)
        beyond = float(np.maximum(trajectory.d_m + reach - left, right - trajectory.d_m + reach).max())
        over = trajectory.s_m + 0.5 * vehicle.length_m > (math.inf if road.road_end_s_m is None else road.road_end_s_m)
        return cls(beyond, int(over.argmax()) if over.any() else None)


def _severity(trajectory: Trajectory, alone: _Alone, cycle: Cycle, separations: Array) -> tuple[float, float]:
    vehicle, road, prediction = cycle.vehicle, cycle.situation.road, cycle.prediction
    if alone.beyond_m > _ON_THE_EDGE_M:
        return (_OFF_THE_ROAD + alone.beyond_m, 0.0)
    touched = separations <= 0.0
    hits = [(int(touched[i].argmax()), i) for i in np.flatnonzero(touched.any(axis=-1)).tolist()]
    wall = alone.wall
    if wall is not None and (not hits or wall <= min(hits)[0]):
        return (float(trajectory.speed_mps[wall]), -float(trajectory.t_s[wall]))
    if not hits:
        return (0.0, float("-inf"))
    first = min(k for k, _ in hits)
    worst = max(_impact_mps(trajectory, first, prediction.bodies[i], vehicle, road) for k, i in hits if k == first)
    return (worst, -float(trajectory.t_s[first]))


def _impact_mps(trajectory: Trajectory, k: int, body: PredictedBody, vehicle: Vehicle, road: Road) -> float:
    """The equivalent speed of meeting this body at sample k."""
    motion = body.at(trajectory.t_s[k : k + 1])
    psi, v = float(trajectory.heading_rad[k]), float(trajectory.speed_mps[k])
    ds = v * np.cos(psi) - float(motion.speed_s_mps[0])
    dd = v * np.sin(psi) - float(motion.speed_d_mps[0])
    overlap = 0.5 * (vehicle.width_m + body.width_m) - abs(float(trajectory.d_m[k]) - float(motion.d_m[0]))
    share = min(max(overlap / min(vehicle.width_m, body.width_m), _LEAST_SHARE), 1.0)
    beside = abs(float(body.at(np.zeros(1)).d_m[0]) - float(trajectory.d_m[0])) - 0.5 * body.width_m
    s, d = float(trajectory.s_m[0]), float(trajectory.d_m[0])
    third = _THIRD_VEHICLE if beside > 0.5 * road.lane_width_at(road.lane_of(d, s), s) - 0.2 else 0.0
    return third + math.hypot(ds, dd) * math.sqrt(share)
