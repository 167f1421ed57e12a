"""Whether the tracks can all be true: no bodies that overlap, no cars that jump or are too fast."""

from __future__ import annotations

import math

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle

_SIGMAS = 3.0
_OVERLAP_M = 0.5  # bodies that overlap by more, beyond their uncertainty, cannot both be there
_JUMP_M, _JUMP_MPS = 3.0, 8.0  # farther from where it was going, within a cycle, no car gets
_AGAINST_MPS, _AGAINST_SIGMAS = 2.0, 2.0  # who differ in speed by both move against one another
_HARDEST_MPS2 = 12.0
_FASTEST_MPS = 100.0
_MEMORY_S = 1.0  # an older situation says nothing of this one


def contradiction(situation: Situation, before: Situation | None, vehicle: Vehicle) -> str:
    """Why the tracks cannot all be true, in words; empty where they can.

    A contradiction is: two bodies, or one and the host, that overlap deeply; a track faster than any car; a track whose place or speed has
    jumped since the situation `before` (at most a second older). Uncertainty is allowed for. Two tracks that were there before and clearly
    differ in speed may overlap: one car has run into the other, and the planner avoids both.
    """
    known = _known(situation, before)
    for i, one in enumerate(situation.tracks):
        host = situation.host
        if max(abs(one.speed_s_mps), abs(one.speed_d_mps)) > _FASTEST_MPS:
            return f"track {one.id} moves faster than {_FASTEST_MPS:.0f} m/s"
        apart = (abs(one.s_m - host.s_m), abs(one.d_m - host.d_m))
        if _overlap(one, None, apart, (0.5 * (one.length_m + vehicle.length_m), 0.5 * (one.width_m + vehicle.width_m))):
            return f"track {one.id} is where the host is"
        for other in situation.tracks[i + 1 :]:
            apart = (abs(one.s_m - other.s_m), abs(one.d_m - other.d_m))
            if one.id in known and other.id in known and _run_together(one, other):
                continue
            if _overlap(one, other, apart, (0.5 * (one.length_m + other.length_m), 0.5 * (one.width_m + other.width_m))):
                return f"tracks {one.id} and {other.id} are in one place"
    elapsed = 0.0 if before is None else situation.time_s - before.time_s
    for track in situation.tracks:
        last = known.get(track.id)
        if last is None:
            continue
        spread = _SIGMAS * math.sqrt(max(float(last.covariance[0, 0] + track.covariance[0, 0]), 0.0))
        spread_d = _SIGMAS * math.sqrt(max(float(last.covariance[2, 2] + track.covariance[2, 2]), 0.0))
        along = abs(track.s_m - last.s_m - 0.5 * elapsed * (last.speed_s_mps + track.speed_s_mps))
        across = abs(track.d_m - last.d_m - 0.5 * elapsed * (last.speed_d_mps + track.speed_d_mps))
        if along > _JUMP_M + spread or across > _JUMP_M + spread_d:
            return f"track {track.id} jumped by {math.hypot(along, across):.1f} m in {elapsed:.2g} s"
        faster = abs(track.speed_s_mps - last.speed_s_mps)
        spread = _SIGMAS * math.sqrt(max(float(last.covariance[1, 1] + track.covariance[1, 1]), 0.0))
        if faster > _JUMP_MPS + _HARDEST_MPS2 * elapsed + spread:
            return f"the speed of track {track.id} jumped by {faster:.1f} m/s in {elapsed:.2g} s"
    return ""


def _known(situation: Situation, before: Situation | None) -> dict[str, Track]:
    """The tracks of the situation before, where that is young enough."""
    if before is None or not 0.0 < situation.time_s - before.time_s <= _MEMORY_S:
        return {}
    return {track.id: track for track in before.tracks}


def _run_together(one: Track, other: Track) -> bool:
    """Whether the two clearly differ in speed."""
    spread = math.sqrt(max(float(one.covariance[1, 1] + other.covariance[1, 1]), 0.0))
    return abs(one.speed_s_mps - other.speed_s_mps) > max(_AGAINST_SIGMAS * spread, _AGAINST_MPS)


def _overlap(one: Track, other: Track | None, apart: tuple[float, float], reach: tuple[float, float]) -> bool:
    """Whether the bodies overlap, along and across the road, by more than they can be mistaken."""
    for axis, (distance, most) in enumerate(zip(apart, reach, strict=True)):
        variance = float(one.covariance[2 * axis, 2 * axis]) + (0.0 if other is None else float(other.covariance[2 * axis, 2 * axis]))
        if most - distance - _SIGMAS * math.sqrt(max(variance, 0.0)) < _OVERLAP_M:
            return False
    return True
