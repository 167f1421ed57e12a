"""Followers in a prediction who brake behind the host: as the cycle expects it of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from mcdas_opt.domain.prediction import CruisingBody, PredictedBody, Prediction, responding, responds
from mcdas_opt.domain.safe_end import SafeEndSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.variant import Variant

HOST_LENGTH_M = 5.0  # of a host whose length a prediction is not told
_QUEUE_MPS = 3.0  # behind a host that is no faster nobody who looks accelerates for long
_LEFT_M, _LEAST_M = 0.5, 0.1  # of a gap that somebody brakes within, when he is there; no gap is smaller


def with_attentive_followers(prediction: Prediction, situation: Situation, names: frozenset[str], settings: SafeEndSettings) -> Prediction:
    """The prediction with these followers braking twice: at once, by what keeps them behind a host that drives as it does now, or by what
    they are seen to brake with; and after their response to the host, as hard as may be asked of them. So also who is in slow traffic.
    Behind a host that stands, or rolls in a queue, none of them goes on accelerating."""
    late_s, most = settings.follower_response_s, settings.follower_demand_mps2
    followers = [track for track in situation.tracks if track.id in names]
    now = {track.id: max(track.braking_seen_mps2, min(_demanded_mps2(track, situation), most)) for track in followers}
    theirs = {name for one in now for name in (one, Variant.ACCELERATING.of(one))}
    ends = {Variant.ACCELERATING.of(one) for one in now} if situation.host.speed_mps <= _QUEUE_MPS else set()
    free = (
        replace(body, response_s=math.inf) if isinstance(body, CruisingBody) and body.id in theirs else body
        for body in prediction.bodies
        if body.id not in ends
    )
    told = {track.id: (late_s, max(most, track.braking_seen_mps2)) for track in followers}
    braking = with_braking(Prediction(name=prediction.name, bodies=tuple(free)), told)
    return Prediction(name=prediction.name, bodies=tuple(_braking_until(body, now.get(body.id, 0.0), late_s) for body in braking.bodies))


def with_braking(prediction: Prediction, answers: Mapping[str, tuple[float, float]]) -> Prediction:
    """The prediction with these followers, by track, braking after so long [s] by so much [m/s^2], having gone on as they do, or
    accelerated, until then. Who brakes in it already does so as before. Who brakes before a turn is not too fast for it."""
    known = predicted_to_brake(prediction)
    answers = {name: answer for name, answer in answers.items() if name not in known}
    if not answers:
        return prediction
    too_fast = {Variant.STRAIGHT_ON.of(one) for one in answers}
    answers = dict(answers) | {Variant.ACCELERATING.of(one): answer for one, answer in answers.items()}
    bodies = tuple(
        responding(body, response_s=answers[body.id][0], braking_mps2=answers[body.id][1]) if body.id in answers else body
        for body in prediction.bodies
        if body.id not in too_fast
    )
    return Prediction(name=prediction.name, bodies=bodies)


def predicted_to_brake(prediction: Prediction) -> tuple[str, ...]:
    """Who is predicted to brake because he follows: in slow traffic, or at a distance that he keeps."""
    accelerating = Variant.ACCELERATING.of("")
    return tuple(body.id for body in prediction.bodies if responds(body) and not body.id.endswith(accelerating))


def gap_to_host_m(track: Track, host_s_m: float) -> float:
    """From bumper to bumper, the host's length being a usual one."""
    return abs(track.s_m - host_s_m) - 0.5 * (track.length_m + HOST_LENGTH_M)


def _demanded_mps2(track: Track, situation: Situation) -> float:
    """What keeps him behind a host that drives as it does now."""
    closing = max(track.speed_s_mps - situation.host.speed_mps, 0.0)
    return closing * closing / (2.0 * max(gap_to_host_m(track, situation.host.s_m) - _LEFT_M, _LEAST_M))


def _braking_until(body: PredictedBody, braking_mps2: float, until_s: float) -> PredictedBody:
    """The same body, braking so until then, or until it stands."""
    if braking_mps2 <= 0.0 or not isinstance(body, CruisingBody):
        return body
    return replace(body, acceleration_mps2=-braking_mps2, changing_s=min(until_s, body.speed_s_mps / braking_mps2))
