"""Which candidates are open over the paper's own two quantities: the gap to the car ahead and how fast the one behind closes in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import chain, count

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.variant import names_of
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.situation.table1 import literal_rows
from mcdas_opt.time_to_react.escapes import escapes
from mcdas_opt.time_to_react.library import KINDS

REAR_GAP_M = 20.0  # where nobody follows
SAME_MPS = 0.3  # a measured front car within this of the host's speed counts as one of the same speed: Table 1 asks for equalities


@dataclass(frozen=True, slots=True, kw_only=True)
class EscapeSweep:
    """Front gaps (G,) [m] by rear closing speeds (C,) [m/s]; for each kind of `KINDS` the last moment (4, C, G) [s], NaN when closed, and
    the row of Table 1 (C, G), 0 where it has none. Other neighbours stay where they are."""

    front_gap_m: Array
    closing_mps: Array
    rear_gap_m: float
    host_mps: float
    front_mps: float
    last_moment_s: Array
    table1_row: NDArray[np.int8]


def swept(
    situation: Situation,
    vehicle: Vehicle,
    *,
    front_gap_m: Array | None = None,
    closing_mps: Array | None = None,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> EscapeSweep:
    """The situation with the car ahead put at each gap, and the one behind given each closing speed at the gap that it has.

    Where nobody is ahead in the lane somebody at the host's speed is put there; where nobody is behind, at 20 m. `progress(done, of)` is
    called for every closing speed.
    """
    gaps = np.linspace(3.0, 60.0, 39) if front_gap_m is None else front_gap_m
    closings = np.linspace(0.0, 16.0, 33) if closing_mps is None else closing_mps
    host, half = situation.host, 0.5 * situation.road.lane_width_m
    mine = [track for track in situation.tracks if abs(track.d_m - host.d_m) < half]
    ahead = min((t for t in mine if t.s_m > host.s_m), key=lambda t: t.s_m, default=None)
    behind = max((t for t in mine if t.s_m <= host.s_m), key=lambda t: t.s_m, default=None)
    others = tuple(track for track in situation.tracks if track is not ahead and track is not behind)
    front = ahead or Track(id=_free_id("front", situation), s_m=0.0, d_m=host.d_m, speed_s_mps=host.speed_mps)
    if abs(front.speed_s_mps - host.speed_mps) <= SAME_MPS:
        front = replace(front, speed_s_mps=host.speed_mps)
    rear = behind or Track(id=_free_id("rear", situation), s_m=0.0, d_m=host.d_m, speed_s_mps=host.speed_mps)
    rear_gap = REAR_GAP_M if behind is None else host.s_m - behind.s_m - 0.5 * (behind.length_m + vehicle.length_m)
    rear_s = host.s_m - rear_gap - 0.5 * (rear.length_m + vehicle.length_m)
    last = np.full((len(KINDS), closings.size, gaps.size), np.nan)
    for c, closing in enumerate(closings):
        progress(c, closings.size)
        follower = replace(rear, s_m=rear_s, speed_s_mps=host.speed_mps + float(closing))
        for g, gap in enumerate(gaps):
            leader = replace(front, s_m=host.s_m + float(gap) + 0.5 * (front.length_m + vehicle.length_m))
            one = replace(situation, tracks=(*others, leader, follower))
            for k, candidate in enumerate(escapes(one, vehicle).candidates):
                if candidate.last_moment_s is not None:
                    last[k, c, g] = candidate.last_moment_s
    row = literal_rows(True, gaps, front.speed_s_mps, True, rear_gap, host.speed_mps + closings[:, None], host.speed_mps)
    return EscapeSweep(
        front_gap_m=gaps,
        closing_mps=closings,
        rear_gap_m=rear_gap,
        host_mps=host.speed_mps,
        front_mps=front.speed_s_mps,
        last_moment_s=last,
        table1_row=row,
    )


def _free_id(wanted: str, situation: Situation) -> str:
    """The wanted id, with a number behind it where a track has it, or is named so in predictions."""
    taken = {name for track in situation.tracks for name in names_of(track.id)}
    numbered = (f"{wanted} {k}" for k in count(2))
    return next(one for one in chain((wanted,), numbered) if taken.isdisjoint(names_of(one)))
