"""Paths followed by the compiled law where there is a compiler, else by `actuation.path_following`, which says what the law is."""

from __future__ import annotations

from dataclasses import replace
from enum import IntEnum
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np

from mcdas_opt.actuation import path_following
from mcdas_opt.actuation.path_following import (
    BANDWIDTH_RADPS,
    FRICTION_SHARE,
    LIMIT_SHARE,
    PREVIEW_S,
    STEP_S,
    AccelerationLaw,
    SpeedLaw,
)
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.axle_limits import driving_mps2
from mcdas_opt.dynamics.bicycle import swept_inset_m2
from mcdas_opt.native.library import library
from mcdas_opt.reference.lane_centre import LaneCentre
from mcdas_opt.reference.offset_path import OffsetPath


class Kind(IntEnum):
    """Of a driver, as the C text knows them."""

    APPROACH = 0
    STEADY = 1
    REACTION = 2
    FOLLOWING = 3


@runtime_checkable
class CountedLaw(Protocol):
    """A driver that can be written as a list of numbers, its `Kind` first, then what the C text asks of that kind."""

    @property
    def numbers(self) -> tuple[float, ...]: ...


_NO_PATH = (0.0, -1.0, 2.0, 0.0, 0.0, 1.0)  # an offset path that goes nowhere: amplitude, a, b, bend, its place, its width


def follow(
    start: HostState,
    path: OffsetPath | LaneCentre,
    law: SpeedLaw | AccelerationLaw,
    *,
    vehicle: Vehicle,
    road: Road,
    duration_s: float,
    lateral_acceleration_mps2: float,
    begins_s: float = 0.0,
) -> Trajectory:
    """As `path_following.follow`, to 1e-9: the trajectory of the bicycle from the measured state along `path`, its times counted from
    `begins_s`.

    A driver of somebody's own, who is no `CountedLaw`, is asked step by step.
    """
    compiled, driver = library(), _driver(law)
    steps = max(2, round(duration_s / STEP_S))
    times = _times(steps, STEP_S, begins_s)
    if compiled is None or driver is None:
        drive = path_following.follow(
            start,
            path,
            law,
            vehicle=vehicle,
            road=road,
            duration_s=duration_s,
            lateral_acceleration_mps2=lateral_acceleration_mps2,
        )
        return replace(drive, t_s=times)
    states, inputs = np.empty((steps + 1, 6)), np.empty((steps, 2))
    states[0] = start.to_vector()
    car = np.array([vehicle.wheelbase_m, vehicle.centre_m, swept_inset_m2(vehicle.length_m, vehicle.centre_m)])
    rule = _law(vehicle, road, lateral_acceleration_mps2)
    bends = road.knots
    compiled.mcdas_follow(steps, STEP_S, car, bends.shape[1], bends, _path(path), rule, driver, inputs, states)
    return Trajectory.from_states(times, states, inputs)


@lru_cache(maxsize=16)
def _times(steps: int, step_s: float, begins_s: float) -> Array:
    """(steps + 1,), the same array for the same numbers: a prediction works the neighbours out once for all drives over it."""
    times = np.round(begins_s + np.round(np.arange(steps + 1) * step_s, 9), 9)
    times.setflags(write=False)
    return times


def _path(path: OffsetPath | LaneCentre) -> Array:
    if isinstance(path, LaneCentre):
        return np.array([0.0, path.d_m, *_NO_PATH])
    shape = (path.amplitude_m, path.a_per_m, path.b, path.bend_m, path.bend_s_m, path.bend_width_m)
    return np.array([path.start_s_m, path.start_d_m, *shape])


def _driver(law: SpeedLaw | AccelerationLaw) -> Array | None:
    if isinstance(law, SpeedLaw):
        return np.array([Kind.APPROACH, law.speed_mps, law.acceleration_mps2, law.start_s], dtype=np.float64)
    return np.array(law.numbers, dtype=np.float64) if isinstance(law, CountedLaw) else None


def _law(vehicle: Vehicle, road: Road, lateral_mps2: float) -> Array:
    grip, share = FRICTION_SHARE * road.friction * GRAVITY_MPS2, LIMIT_SHARE
    return np.array(
        [
            min(lateral_mps2, grip),
            grip,
            BANDWIDTH_RADPS,
            PREVIEW_S,
            share * vehicle.steering_max_rad,
            share * vehicle.steering_rate_max_radps,
            share * vehicle.jerk_min_mps3,
            share * vehicle.jerk_max_mps3,
            share * vehicle.acceleration_min_mps2,
            share * driving_mps2(vehicle, road.friction),
            0.7 * share * vehicle.jerk_max_mps3,
        ]
    )
