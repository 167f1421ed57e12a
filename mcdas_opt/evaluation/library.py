"""The library of the witness half of the oracle: some thousands of manoeuvres, as sets that are tried one after another."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.manoeuvres.lane_change_profiles import LaneChangeProfiles
from mcdas_opt.manoeuvres.phases import Phases

_DODGES_M = (2.1, 2.7)  # past a body in the middle of its lane, without going all the way
_LATERAL = (0.2, 0.35, 0.5, 0.65, 0.8, 0.92)  # of mu g
_DELAYS_S = (0.0, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 2.5, 3.0)
_SOFTNESS = (50.0, 12.0)
_BRAKING = (0.2, 0.4, 0.6, 0.8, 0.97)
_ACCELERATING = (0.35, 0.97)
_SWITCH_S = (0.5, 1.0, 1.6, 2.5, 3.5)


def targets_m(road: Road, vehicle: Vehicle, d_m: float) -> tuple[float, ...]:
    """Ends of lane-change profiles from d: next lanes' centres, dodges, the middle of shoulders; what the body fits."""
    lane = road.lane_of(d_m, 0.0)
    wanted = [road.lane_centre_m(lane + side, 0.0) for side in (1, -1) if road.has_lane(lane + side, 0.0)]
    wanted += [d_m + side * dodge for side in (1, -1) for dodge in _DODGES_M]
    wanted += [road.left_edge_m - 0.5 * road.shoulder_left_m] if road.shoulder_left_m else []
    wanted += [road.right_edge_m + 0.5 * road.shoulder_right_m] if road.shoulder_right_m else []
    half = 0.5 * vehicle.width_m + 0.05
    return tuple(d for d in wanted if road.right_edge_m + half < d < road.left_edge_m - half and abs(d - d_m) > 0.5)


def library(road: Road, vehicle: Vehicle, d_m: float) -> Iterator[tuple[Phases, LaneChangeProfiles]]:
    """Sets (P, 1) x (1, Q): one phase and every lane-change profile; two phases and every second one."""
    grip = road.grip_mps2
    brake, accelerate = min(-vehicle.acceleration_min_mps2, grip), min(vehicle.acceleration_max_mps2, grip)
    levels = [0.0, *(-share * brake for share in _BRAKING), *(share * accelerate for share in _ACCELERATING)]
    ends = targets_m(road, vehicle, d_m)
    yield _one_phase(levels), _lane_changes(ends, _LATERAL, _DELAYS_S, _SOFTNESS, grip, d_m)
    rows = [(a, t, then) for a, t, then in itertools.product(levels, _SWITCH_S, levels) if a != then]
    coarse = _lane_changes(ends, _LATERAL[1::2], _DELAYS_S[::2], _SOFTNESS[:1], grip, d_m)
    for part in range(0, len(rows), 70):
        yield _two_phases(rows[part : part + 70]), coarse


def _one_phase(levels: list[float]) -> Phases:
    return _two_phases([(a, 0.0, a) for a in levels])


def _two_phases(rows: list[tuple[float, float, float]]) -> Phases:
    first, switch, then = np.array(rows).T[..., None]
    return Phases(first_mps2=first, switch_s=switch, then_mps2=then)


def _lane_changes(
    ends: tuple[float, ...],
    lateral: tuple[float, ...],
    delays: tuple[float, ...],
    softness: tuple[float, ...],
    grip: float,
    keep_d_m: float,
) -> LaneChangeProfiles:
    rows = [
        (keep_d_m, 1.0, 0.0, 50.0),
        *((d, share * grip, delay, b) for d, share, delay, b in itertools.product(ends, lateral, delays, softness)),
    ]
    target, push, delay, b = np.array(rows).T[:, None, :]
    return LaneChangeProfiles(target_d_m=target, lateral_mps2=push, delay_s=delay, b=b)
