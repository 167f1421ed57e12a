"""How hard the host has to brake for the front car: not at all, gently, or with nearly all that it has."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.safe_end import SafeEndSettings
from mcdas_opt.domain.settings import Settings
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


@dataclass(frozen=True, slots=True, kw_only=True)
class FrontBraking:
    """`stopping_mps2`: the least constant braking that keeps the host behind the front car, with room at standstill, where he goes on
    braking as he is seen to; 0 without him. `is_gentle`: braking is enough for him, and no more than is comfortable. `is_to_the_limit`: he
    brakes so that stopping behind him, begun now, takes nearly all that tyres and brakes give, and nobody closes in from behind.
    """

    stopping_mps2: float
    is_gentle: bool
    is_to_the_limit: bool

    @classmethod
    def of(cls, situation: Situation, assessment: Assessment, vehicle: Vehicle, settings: Settings) -> FrontBraking:
        front = situation.track(assessment.front_id)
        if front is None:
            return cls(stopping_mps2=0.0, is_gentle=False, is_to_the_limit=False)
        host_mps = situation.host.speed_mps
        room = max(assessment.front_gap_m - _STANDING_GAP_M, _NEAREST_M)
        slowing = stopping_mps2(host_mps, front.speed_s_mps, 0.0, room)
        stopping = stopping_mps2(host_mps, front.speed_s_mps, -front.acceleration_s_mps2, room)
        comfortable = settings.comfort.limits(host_mps).braking_mps2
        return cls(
            stopping_mps2=stopping,
            is_gentle=assessment.mode is Mode.BRAKE and slowing <= _SLOWING_MPS2 and stopping <= comfortable,
            is_to_the_limit=Sector.REAR not in assessment.threats
            and _is_to_the_limit(host_mps, front, assessment.front_gap_m, situation.road.friction, vehicle, settings.safe_end),
        )


def stopping_mps2(host_mps: float, front_mps: float, braking_mps2: float, room_m: float) -> float:
    """The least constant braking behind a front car that brakes so: until both are equally fast, or until both stand. One that brakes
    hardly may as well hold its speed: what ends the closing."""
    its_mps, slowing = max(front_mps, 0.0), max(host_mps - front_mps, 0.0) ** 2 / (2.0 * room_m)
    if braking_mps2 <= _BRAKING_MPS2:
        return slowing
    if 2.0 * room_m * braking_mps2 < its_mps * (host_mps - its_mps):  # equally fast before he stands
        return braking_mps2 + slowing
    return host_mps**2 / (2.0 * room_m + its_mps**2 / braking_mps2)


def _is_to_the_limit(host_mps: float, front: Track, gap_m: float, friction: float, vehicle: Vehicle, safe_end: SafeEndSettings) -> bool:
    """By the distance of Responsibility-Sensitive Safety (Shalev-Shwartz et al. 2017), with his braking as it is."""
    braking, sd = -front.acceleration_s_mps2, front.acceleration_s_sd_mps2
    if sd is None or braking < max(_BRAKING_MPS2, _CLEARLY * sd):
        return False
    grip = friction * GRAVITY_MPS2
    most = _LIMIT_SHARE * safe_end.braking_share * min(-vehicle.acceleration_min_mps2, grip)
    its_mps = max(front.speed_s_mps, 0.0)
    room = gap_m - _STANDING_GAP_M - safe_end.response_s * host_mps + its_mps * its_mps / (2.0 * min(braking, grip))
    return host_mps > its_mps and host_mps * host_mps > 2.0 * most * room
