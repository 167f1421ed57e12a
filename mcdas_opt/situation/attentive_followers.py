"""Who follows the host at a distance that he keeps himself: he is expected to brake behind it, as an attentive driver does."""

from __future__ import annotations

from mcdas_opt.domain.settings import LEAST_SHARE, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.situation.roles import gap_m

_CLOSING_MPS = 3.0  # who closes in faster does not keep his distance
_HARDLY_MPS = 1.0  # of who closes in no faster the least headway is enough
_LATE_MPS2 = 3.0  # who needs more braking than this, and does not brake, looks elsewhere, ...
_LATE_S, _LATE_HELD_S = 2.0, 1.5  # ... and in any case so long before he would be there, behind a host that drives on, or is held, ...
_LATEST_S = 3.0  # ... but no longer before
_QUEUE_MPS, _SLOWLY_MPS = 3.0, 9.0  # who is slower stands in a queue, or rolls with it; and a host that comes up to one
_STOPPING_MPS2, _NEAR_M = 1.0, 10.0  # a host that needs no less braking than this for a line stops there, or stands so near it, or him
_WAITING_M = 30.0  # before the end of its lane a host that hardly moves waits to be let in


def attentive_followers(situation: Situation, vehicle: Vehicle, settings: Settings, before: frozenset[str]) -> frozenset[str]:
    """Of those behind in the host's lane: who keeps the headway that is asked of the host, and closes in slowly; of who hardly closes in
    the least headway is enough. Whoever can stop behind the host, before a stop line, at which he has to wait himself, and behind a
    queue, or an end of the lane, that holds the host, or that it slowly comes up to.

    From then on (`before`) he is, for as long as no harder braking is needed behind the host as it drives now than may be asked of him, or
    than he is seen to brake with: that a host which brakes is closed in on tells nothing against him. But not who clearly closes
    in, does not brake, and should.
    """
    followers = [track for track in situation.tracks if _follows(track, situation)]
    if not followers:
        return frozenset()
    is_held = waits_at_a_line(situation, vehicle) or _is_held_by_traffic(situation, vehicle)
    return frozenset(track.id for track in followers if _is_attentive(track, situation, vehicle, settings, is_held, track.id in before))


def _follows(track: Track, situation: Situation) -> bool:
    return situation.shares_lane(track) and track.s_m < situation.host.s_m and track.speed_s_mps >= 0.0


def _is_attentive(track: Track, situation: Situation, vehicle: Vehicle, settings: Settings, is_held: bool, was_attentive: bool) -> bool:
    host = situation.host
    gap = host.s_m - track.s_m - 0.5 * (track.length_m + vehicle.length_m)
    closing = max(track.speed_s_mps - host.speed_mps, 0.0)
    if is_held or was_attentive:
        asked = max(settings.safe_end.follower_demand_mps2, track.braking_seen_mps2)
        return gap > 0.0 and closing * closing <= 2.0 * asked * gap and not _is_late(track, closing, gap, is_held)
    share = LEAST_SHARE if closing <= _HARDLY_MPS else 1.0
    return closing <= _CLOSING_MPS and gap >= settings.headway.gap_m(track.speed_s_mps, share)


def _is_late(track: Track, closing: float, gap: float, is_held: bool) -> bool:
    """Whether he clearly closes in, does not brake, and should."""
    late_s = max(closing / (2.0 * _LATE_MPS2), _LATE_HELD_S if is_held else _LATE_S)
    return closing > _HARDLY_MPS and track.acceleration_s_mps2 >= 0.0 and gap <= min(late_s, _LATEST_S) * closing


def line_ahead_m(situation: Situation, vehicle: Vehicle) -> float | None:
    """s [m] of the line at which the host has to wait; None without one, or where its front bumper is beyond."""
    line_m = situation.stop_line_s_m
    return line_m if line_m is not None and line_m >= situation.host.s_m + 0.5 * vehicle.length_m else None


def waits_at_a_line(situation: Situation, vehicle: Vehicle) -> bool:
    """Whether the host stands at its stop line, or has to brake for it now."""
    line_m = line_ahead_m(situation, vehicle)
    return line_m is not None and line_m - situation.host.s_m - 0.5 * vehicle.length_m <= _braking_for_m(situation)


def _braking_for_m(situation: Situation) -> float:
    """So near is what the host stands before, or has to brake for now."""
    return _NEAR_M + situation.host.speed_mps**2 / (2.0 * _STOPPING_MPS2)


def _is_held_by_traffic(situation: Situation, vehicle: Vehicle) -> bool:
    """Whether the host stands behind somebody who stands or rolls, or slowly brakes for him; or stands, or rolls, near where its lane
    ends. A side that is open makes no difference: it is no less so once he is seen not to brake."""
    host = situation.host
    if host.speed_mps > _SLOWLY_MPS:
        return False
    ahead = (one for one in situation.tracks if one.s_m > host.s_m and abs(one.speed_s_mps) < _QUEUE_MPS and situation.shares_lane(one))
    if any(gap_m(one, host, vehicle) <= _braking_for_m(situation) for one in ahead):
        return True
    end_m = situation.road.lane_ends_m(situation.host_lane, host.s_m, vehicle.width_m) - host.s_m - 0.5 * vehicle.length_m
    return host.speed_mps <= _QUEUE_MPS and -_NEAR_M <= end_m <= _WAITING_M
