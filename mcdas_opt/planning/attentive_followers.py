"""Who follows the host at a distance that he keeps himself: he is expected to brake behind it, as an attentive driver does."""

from __future__ import annotations

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.safe_end import SafeEndSettings
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.gap import LEAST_SHARE
from mcdas_opt.tracking.slow_traffic import answering

_CLOSING_MPS = 2.0  # who closes in faster does not keep his distance
_SEEN_MPS2, _SEEN_SIGMAS = 1.0, 2.0  # braking that is seen


def attentive_followers(situation: Situation, vehicle: Vehicle, settings: Settings, before: frozenset[str]) -> frozenset[str]:
    """Of those behind in the host's lane: who keeps at least the least headway and hardly closes in.

    From then on (`before`) he is, for as long as no harder braking is needed behind the host as it drives now than may be asked of him, or
    than he is seen to brake with: that a host which brakes is closed in on tells nothing against him.
    """
    return frozenset(
        track.id for track in situation.tracks if _follows(track, situation) and _is_attentive(track, situation, vehicle, settings, before)
    )


def with_attentive_followers(prediction: Prediction, names: frozenset[str], situation: Situation, settings: SafeEndSettings) -> Prediction:
    """The prediction with these braking as attentive drivers do, who respond late; at once who is seen to brake already."""
    seen = {track.id: braking_seen_mps2(track) for track in situation.tracks if track.id in names}
    answers = {
        name: (0.0 if braking else settings.follower_response_s, max(settings.attentive_braking_mps2, braking))
        for name, braking in seen.items()
    }
    return answering(prediction, answers)


def braking_seen_mps2(track: Track) -> float:
    """What he is clearly seen to brake with, else 0."""
    sd = track.acceleration_s_sd_mps2
    return -track.acceleration_s_mps2 if sd is not None and -track.acceleration_s_mps2 > max(_SEEN_MPS2, _SEEN_SIGMAS * sd) else 0.0


def _follows(track: Track, situation: Situation) -> bool:
    host = situation.host
    in_lane = abs(track.d_m - host.d_m) < 0.5 * situation.road.lane_width_m
    return in_lane and track.follows_road and track.s_m < host.s_m and track.speed_s_mps >= 0.0


def _is_attentive(track: Track, situation: Situation, vehicle: Vehicle, settings: Settings, before: frozenset[str]) -> bool:
    host = situation.host
    gap = host.s_m - track.s_m - 0.5 * (track.length_m + vehicle.length_m)
    closing = max(track.speed_s_mps - host.speed_mps, 0.0)
    if track.id in before:
        asked = max(settings.safe_end.follower_demand_mps2, braking_seen_mps2(track))
        return gap > 0.0 and closing * closing <= 2.0 * asked * gap
    return closing <= _CLOSING_MPS and gap >= settings.headway.gap_m(track.speed_s_mps, LEAST_SHARE)
