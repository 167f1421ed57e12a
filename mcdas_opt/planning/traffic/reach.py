"""Who can matter: bodies that come within the reach of a host that brakes or accelerates as it can. Whoever cannot costs nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import BodyMotion, CruisingBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.native.library import library
from mcdas_opt.verification.bodies import ALONG_REACHES

AFTERWARDS_S = 20.0  # no plan with its continuation is longer, nor does any manoeuvre of a time to react end later
_AFTERWARDS = np.linspace(0.0, AFTERWARDS_S, 21)
_AFTERWARDS.setflags(write=False)
_AWAY_M = 150.0  # room that is left besides when everything is over: to stop, to follow, and between the times
_STRETCH = 0.1  # of a distance along the road: on a bend a lane is longer or shorter than the road


@dataclass(frozen=True, slots=True, kw_only=True)
class Room:
    """What counts as near: so far from body to body [m], and so many seconds of the host's speed and of closing speed more."""

    standstill_m: float
    time_gap_s: float = 0.0
    closing_s: float = 0.0


def in_reach(
    motion: BodyMotion, lengths_m: Array, times_s: Array, host: HostState, vehicle: Vehicle, road: Road, room: Room
) -> NDArray[np.bool_]:
    """(J,) of bool: which bodies (rows of `motion`, at these times) come near, at one of the times, to where the host can be by then.

    The host's reach is the interval from full braking to full acceleration, both at once: no drive that it can drive leaves it. In C where
    there is a compiler, with the same bits.
    """
    brake, accelerate = available_mps2(vehicle, road.friction)
    rate, v = max(accelerate, host.acceleration_mps2), host.speed_mps
    top = max(vehicle.speed_max_mps, v)
    compiled = library()
    if compiled is not None:
        near = np.empty(len(lengths_m), dtype=np.bool_)
        s_m, speed_mps = np.ascontiguousarray(motion.s_m), np.ascontiguousarray(motion.speed_s_mps)
        wanted = room.standstill_m, room.time_gap_s, room.closing_s
        numbers = np.array((host.s_m, v, vehicle.length_m, brake, rate, top, *wanted, _STRETCH))
        compiled.mcdas_in_reach(near.size, times_s.size, times_s, s_m, speed_mps, lengths_m, numbers, near)
        return near
    slowest, fastest = np.maximum(v - brake * times_s, 0.0), np.minimum(v + rate * times_s, top)
    stopping, rising = np.minimum(times_s, v / brake), np.minimum(times_s, (top - v) / rate)
    low = host.s_m + stopping * (v - 0.5 * brake * stopping)
    high = host.s_m + rising * (v + 0.5 * rate * rising) + top * (times_s - rising)
    apart = 0.5 * (lengths_m[:, None] + vehicle.length_m) + room.standstill_m + _STRETCH * np.abs(motion.s_m - host.s_m)
    ahead = apart + room.time_gap_s * fastest + room.closing_s * np.maximum(fastest - motion.speed_s_mps, 0.0)
    behind = apart + room.closing_s * np.maximum(motion.speed_s_mps - slowest, 0.0)
    comes = (motion.s_m - high < ahead) & (low - motion.s_m < behind)
    return np.asarray(comes.any(axis=-1), dtype=np.bool_)


def in_reach_ever(prediction: Prediction, host: HostState, vehicle: Vehicle, road: Road) -> Prediction:
    """The prediction of those that can matter to any plan and what comes after it. On a bent road bodies as large as a bend may meet a host
    that is far from them along the road: whoever the judge looks at is there."""
    if all(isinstance(body, CruisingBody) and abs(body.s_m - host.s_m) <= _AWAY_M for body in prediction.bodies):
        return prediction  # all of them are near now
    lengths = np.array([body.length_m for body in prediction.bodies])
    if not road.is_straight:
        across = np.array([math.hypot(body.length_m, body.width_m) for body in prediction.bodies])
        judged_m = 0.5 * ALONG_REACHES * (across + math.hypot(vehicle.length_m, vehicle.width_m))
        lengths = np.maximum(lengths, 2.0 * (judged_m - _AWAY_M) - vehicle.length_m)
    motion = prediction.rows_on(_AFTERWARDS)
    near = in_reach(motion, lengths, _AFTERWARDS, host, vehicle, road, Room(standstill_m=_AWAY_M, time_gap_s=2.0, closing_s=5.0))
    if near.all():
        return prediction
    return Prediction(name=prediction.name, bodies=tuple(prediction.bodies[i] for i in np.flatnonzero(near).tolist()))
