"""The conservative fast accept: what the judge's C text accepts, the array operations find nothing against.

The C text keeps every limit with more than rounding to spare and only acquits, so that a verdict never depends on which of the two forms
ran: what is not accepted is examined, and its violations measured, by the array operations alone.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from functools import lru_cache
from operator import attrgetter

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import MOVING, CruisingBody, PredictedBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.axle_limits import driving_mps2
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.verification.motion import BETWEEN_SAMPLES_M, FINE_STEP_S
from mcdas_opt.verification.tolerances import CONTRACT

_as_a_row = attrgetter(*MOVING, "length_m", "width_m")
_UNKNOWN = (math.nan,) * (len(MOVING) + 2)
_HALF_STEPS = 10  # in a sample interval, at most


def doubtful_bodies(
    compiled: ctypes.CDLL, table: Array, start: HostState | None, rules: Array, bodies: Array, frame: FrenetFrame
) -> list[int] | None:
    """Which bodies a trajectory's table (9, n), contiguous, is not certainly apart from; none: nothing can be found against it. None
    where something else may be wrong with it.

    `compiled` is the native library; `rules` from `rules_of`, `bodies` from `rows_of`.
    """
    edges = (None, 0) if frame.road.edges is None else (frame.road.edges.table, frame.road.edges.table.shape[1])
    n, many = table.shape[1], len(bodies)
    work = np.empty((4, _HALF_STEPS * max(n - 1, 0) + 1))  # of each call: threads may judge at once
    doubtful = np.empty(many, dtype=np.int64)
    begun = None if start is None else start.to_vector().copy()
    found = compiled.mcdas_conservative_accept(table, n, begun, rules, bodies, many, *frame.addresses(), *edges, work, doubtful)
    left: list[int] = doubtful[: max(found, 0)].tolist()
    return None if found < 0 else left


def rows_of(bodies: Sequence[PredictedBody]) -> Array:
    """(bodies, 12) as the C text has them; of who moves otherwise than it knows, and is doubtful for that, no numbers."""
    rows = [_as_a_row(body) if type(body) is CruisingBody else _UNKNOWN for body in bodies]
    return np.array(rows, dtype=np.float64).reshape(-1, len(_UNKNOWN))


@lru_cache(maxsize=32)
def rules_of(vehicle: Vehicle, road: Road, along_reaches: float) -> Array:
    """The record `Rules` of the C text."""
    of = CONTRACT
    car: tuple[float, ...] = (vehicle.wheelbase_m, vehicle.centre_m, vehicle.length_m, vehicle.width_m, vehicle.steering_max_rad)
    car += (vehicle.steering_rate_max_radps, vehicle.acceleration_min_mps2, driving_mps2(vehicle, road.friction))
    car += (vehicle.jerk_min_mps3, vehicle.jerk_max_mps3, vehicle.speed_max_mps)
    end = math.inf if road.road_end_s_m is None else road.road_end_s_m
    ground = (road.grip_mps2 * (1.0 + of.friction), road.left_edge_m, road.right_edge_m, end, of.edge_m + BETWEEN_SAMPLES_M)
    start = (of.start_position_m, of.start_heading_rad, of.start_speed_mps, of.start_acceleration_mps2, of.start_steering_rad)
    residual = (of.residual_position_m, of.residual_heading_rad, of.residual_speed_mps, of.residual_acceleration_mps2)
    last = (of.residual_steering_rad, of.longest_step_s + of.step_rounding_s, of.largest_number, FINE_STEP_S, along_reaches)
    ends = (of.end_position_m, of.end_heading_rad)
    return np.array([*car, *ground, of.limit, of.reverse_mps, of.edge_m, *start, of.start_time_s, *ends, *residual, *last])
