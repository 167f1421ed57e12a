"""How hard the host has to brake for the front car: gently, or with nearly all that it has."""

from __future__ import annotations

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.safe_end import SafeEndSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Mode, Sector

_STANDING_GAP_M = 2.0
_BRAKING_MPS2 = 0.5  # who brakes by less may as well hold its speed
_SLOWING_MPS2 = 2.5  # with which ordinary braking ends the closing
_NEAREST_M = 0.5  # room is at least so much
_CLEARLY = 1.5  # standard deviations
_LIMIT_SHARE = 0.8  # of what tyres and brakes give is nearly all of it


def brakes_to_the_limit(situation: Situation, assessment: Assessment, vehicle: Vehicle, safe_end: SafeEndSettings) -> bool:
    """The front car brakes so that stopping behind it, begun now, takes nearly all that tyres and brakes give (the distance of
    Responsibility-Sensitive Safety, Shalev-Shwartz et al. 2017, with its braking as it is)."""
    front = _front(situation, assessment)
    if front is None or front.acceleration_s_sd_mps2 is None:
        return False
    braking = -front.acceleration_s_mps2
    if braking < max(_BRAKING_MPS2, _CLEARLY * front.acceleration_s_sd_mps2):
        return False
    grip = situation.road.friction * GRAVITY_MPS2
    most = _LIMIT_SHARE * safe_end.braking_share * min(-vehicle.acceleration_min_mps2, grip)
    v, its = situation.host.speed_mps, max(front.speed_s_mps, 0.0)
    room = assessment.front_gap_m - _STANDING_GAP_M - safe_end.response_s * v + its * its / (2.0 * min(braking, grip))
    return v > its and v * v > 2.0 * most * room


def brakes_gently(situation: Situation, assessment: Assessment, comfortable_mps2: float) -> bool:
    """Braking is enough for the front car: no more than is comfortable would stop the host behind it where it brakes itself, and less end
    the closing."""
    if assessment.mode is not Mode.BRAKE or _front(situation, assessment) is None:
        return False
    slowing = _slowing_mps2(situation, assessment)
    return slowing <= _SLOWING_MPS2 and stopping_mps2(situation, assessment) <= comfortable_mps2


def stopping_mps2(situation: Situation, assessment: Assessment) -> float:
    """The least constant braking that keeps the host behind the front car, with room at standstill, where he goes on braking as he is seen
    to: until both are equally fast, or until both stand. 0 without him."""
    front = _front(situation, assessment)
    if front is None:
        return 0.0
    speed, its_speed, room = situation.host.speed_mps, max(front.speed_s_mps, 0.0), _room_m(assessment)
    slowing, braking = _slowing_mps2(situation, assessment), -front.acceleration_s_mps2
    if braking <= _BRAKING_MPS2:
        return slowing
    if 2.0 * room * braking < its_speed * (speed - its_speed):  # equally fast before he stands
        return braking + slowing
    return speed**2 / (2.0 * room + its_speed**2 / braking)


def is_ordinary(situation: Situation, assessment: Assessment, comfortable_mps2: float) -> bool:
    """Nothing threatens but a front car for which gentle braking is enough."""
    return not assessment.threatened or (Sector.REAR not in assessment.threats and brakes_gently(situation, assessment, comfortable_mps2))


def _slowing_mps2(situation: Situation, assessment: Assessment) -> float:
    """The constant braking that ends the closing before the front car, which keeps its speed."""
    closing = max(situation.host.speed_mps - (assessment.front_speed_mps or 0.0), 0.0)
    return closing**2 / (2.0 * _room_m(assessment))


def _room_m(assessment: Assessment) -> float:
    return max(assessment.front_gap_m - _STANDING_GAP_M, _NEAREST_M)


def _front(situation: Situation, assessment: Assessment) -> Track | None:
    return next((track for track in situation.tracks if track.id == assessment.front_id), None)
