"""Whether the tracks and the host can be true: no bodies that overlap, no cars that jump or are too fast."""

from __future__ import annotations

import math

from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import FARTHEST_M
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle

_SIGMAS = 3.0
_OVERLAP_M = 0.5  # bodies that overlap by more, beyond their uncertainty, cannot both be there
_JUMP_M, _JUMP_MPS = 3.0, 8.0  # farther from where it was going, within a cycle, no car gets
_AGAINST_MPS, _AGAINST_SIGMAS = 2.0, 2.0  # who differ in speed by both move against one another
_HARDEST_MPS2 = 12.0
_FASTEST_MPS = 100.0
_HOST_FASTEST_MPS = 85.0  # and than half as fast again as it can drive
_HOST_HARDEST_MPS2 = 30.0  # three times what tyres hold: a crash, or no acceleration
_HOST_STEERING_RAD = 1.4  # of the wheels of any car
_HOST_LATERAL_MPS2 = 100.0  # that the steering would give: ten times what tyres hold
_HOST_OFF_ROAD_M = 20.0  # beyond the edge
_FOLD = 0.9  # of the radius of the bend: there the road folds over itself
_HOST_SIDEWAYS_MPS, _HOST_TURNING_RADPS = 40.0, 15.0
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


def host_faults(host: HostState, road: Road, before_mps: tuple[float, ...], elapsed_s: float, vehicle: Vehicle) -> dict[str, str]:
    """Which quantities of the host's state no car can have, each with why, in words.

    `before_mps` are its speeds as they were known `elapsed_s` before: a speed that is far from all of them has jumped.
    """
    faults: dict[str, str] = {}
    speed, fastest = host.speed_mps, min(_HOST_FASTEST_MPS, 1.5 * vehicle.speed_max_mps)
    if abs(host.s_m) > FARTHEST_M:
        faults["s_m"] = f"the host is at {host.s_m:.3g} m along the road"
    if speed < 0.0:
        faults["speed_mps"] = f"the host moves backwards at {-speed:.3g} m/s"
    elif speed > fastest:
        faults["speed_mps"] = f"the host moves at {speed:.0f} m/s, faster than {fastest:.0f}"
    elif before_mps and min(abs(speed - before) for before in before_mps) > _JUMP_MPS + _HARDEST_MPS2 * elapsed_s:
        faults["speed_mps"] = f"the host's speed jumped by {abs(speed - before_mps[-1]):.1f} m/s in {elapsed_s:.2g} s"
    if abs(host.acceleration_mps2) > _HOST_HARDEST_MPS2:
        faults["acceleration_mps2"] = f"the host accelerates at {host.acceleration_mps2:.3g} m/s^2, beyond {_HOST_HARDEST_MPS2:.0f}"
    if abs(host.heading_rad) > math.pi:
        faults["heading_rad"] = f"the host's heading against the road is {host.heading_rad:.3g} rad, beyond half a turn"
    steering, slowest = abs(host.steering_rad), min(max(speed, 0.0), fastest)
    if steering > _HOST_STEERING_RAD or slowest**2 * math.tan(steering) > _HOST_LATERAL_MPS2 * vehicle.wheelbase_m:
        faults["steering_rad"] = f"the host's wheels are turned by {host.steering_rad:.3g} rad at {speed:.0f} m/s"
    off_road = max(host.d_m - road.left_edge_m, road.right_edge_m - host.d_m)
    if off_road > _HOST_OFF_ROAD_M or (off_road > 0.0 and max(kappa * host.d_m for _, kappa in road.curvature) > _FOLD):
        faults["d_m"] = f"the host is {off_road:.3g} m beyond the edge of the road"
    if isinstance(host, SlidingState) and (
        abs(host.lateral_speed_mps) > _HOST_SIDEWAYS_MPS or abs(host.yaw_rate_radps) > _HOST_TURNING_RADPS
    ):
        faults["heading_rad"] = f"the host slides at {host.lateral_speed_mps:.3g} m/s and turns at {host.yaw_rate_radps:.3g} rad/s"
    return faults


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
