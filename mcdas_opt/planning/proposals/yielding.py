"""Who crosses the host's way is let through where both would be there one soon after the other, and braking for him is comfortable."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.prediction import PredictedBody
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import CROSSING_MPS, Track
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.planning.cycle import Cycle

_TIMES_S = np.linspace(0.0, 8.0, 81)  # looked ahead
_LEAD_S, _LAG_S = 1.0, 0.5  # the host goes first if it is past so long before he comes, and after him so long after he has gone
_SOON_S = 3.0  # a vehicle that comes later may turn off or stop before
_ASIDE_M, _BEFORE_M, _LEAST_M = 0.5, 2.0, 0.3  # kept from him across, along, and along at least
_BEGINS_MPS2, _HARDER = 0.8, 1.15  # what needs less may wait; what is needed by now is braked with so many times over
_UNHURRIED_MPS2 = 0.5  # who may accelerate by more until he has gone is not held back
_SLOWEST_MPS = 0.1
_TURNING_RADPS = 0.1


class Yielding(NamedTuple):
    """Who is let through, and how fast the host is at most meanwhile, at each node of the grid [m/s]."""

    track: Track
    speeds_mps: Array


def yielding(cycle: Cycle, d_m: float) -> list[Yielding]:
    """To everybody who goes straight across the way along the offset d. Whoever cannot be braked for comfortably any more is left to the
    optimiser, and so is who turns, unless his lane is known: where he will be is too little known."""
    crossing = {track.id: track for track in cycle.situation.tracks if _crosses(track)}
    if not crossing:
        return []
    bodies = (body for body in cycle.prediction.bodies if body.id in crossing)
    found = ((crossing[body.id], _speeds(crossing[body.id], body, d_m, cycle)) for body in bodies)
    return [Yielding(track, speeds) for track, speeds in found if speeds is not None]


def _crosses(track: Track) -> bool:
    is_foreseen = abs(track.turn_rate_radps) < _TURNING_RADPS or track.lane_path_m is not None
    return not track.follows_road and abs(track.speed_d_mps) > CROSSING_MPS and is_foreseen


def _speeds(track: Track, body: PredictedBody, d_m: float, cycle: Cycle) -> Array | None:
    """How fast at most; None where he need not be let through, or not comfortably."""
    host, vehicle, times_s = cycle.situation.host, cycle.vehicle, cycle.settings.grid.times_s
    motion, speed = body.at(_TIMES_S), max(host.speed_mps, _SLOWEST_MPS)
    in_way = np.abs(motion.d_m - d_m) < 0.5 * (track.across_m + vehicle.width_m) + _ASIDE_M
    in_way &= motion.s_m > host.s_m
    if not in_way.any():
        return None
    comes = int(in_way.argmax())
    goes = comes + int((~in_way[comes:]).argmax()) if not in_way[comes:].all() else in_way.size
    place, lengths = motion.s_m[comes:goes], 0.5 * (track.along_m + vehicle.length_m)
    before_m, past_m = float(place.min()) - host.s_m - lengths, float(place.max()) - host.s_m + lengths
    farthest_s = math.inf if track.kind in (BodyKind.PEDESTRIAN, BodyKind.BICYCLE) else _SOON_S
    if before_m <= 0.0 or past_m / speed + _LEAD_S <= _TIMES_S[comes] or _TIMES_S[comes] > farthest_s:
        return None
    after_s = _TIMES_S[goes] + _LAG_S if goes < in_way.size else math.inf
    most = cycle.settings.comfort.limits(host.speed_mps).braking_mps2
    if math.isfinite(after_s):
        rate = 2.0 * (host.speed_mps * after_s - (before_m - _BEFORE_M)) / after_s**2  # comes there as he has gone
        if rate < -_UNHURRIED_MPS2:
            return None
        if rate <= most and rate * after_s < host.speed_mps:
            return np.where(times_s <= after_s, host.speed_mps - rate * times_s, math.inf)
    needed, nearer = (host.speed_mps**2 / (2.0 * max(before_m - kept_m, _LEAST_M)) for kept_m in (_BEFORE_M, _LEAST_M))
    if nearer > most or needed < _BEGINS_MPS2:
        return None
    return np.asarray(np.maximum(host.speed_mps - min(max(_HARDER * needed, _BEGINS_MPS2), most) * times_s, 0.0))
