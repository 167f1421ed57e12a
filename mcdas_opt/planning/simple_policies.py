"""What anybody would try when nothing is safe: full braking, full acceleration, hold, and steering out to either side with all grip."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from mcdas_opt.actuation.path_following import SpeedLaw
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.planning.path_driving import follow
from mcdas_opt.reference.lane_centre import LaneCentre
from mcdas_opt.reference.offset_path import OffsetPath, corrected

_STEERING_SHARE = 0.9  # of the grip, for steering out with nothing left for brakes


class Policy(NamedTuple):
    """A name, and what it does."""

    name: str
    mode: Mode
    side: Side


FULL_BRAKING = Policy("full braking", Mode.BRAKE, Side.NONE)
FULL_ACCELERATION = Policy("full acceleration", Mode.ACCELERATE, Side.NONE)
HOLD = Policy("hold", Mode.HOLD, Side.NONE)
OUT = {side: Policy(f"hard {side.value}", Mode.EVADE, side) for side in (Side.LEFT, Side.RIGHT)}


def simple_policies(situation: Situation, vehicle: Vehicle, settings: Settings) -> Iterator[tuple[Policy, Trajectory]]:
    """The five, driven by the bicycle within the car's limits; a side without lane or shoulder, or that
    nobody watches, is left out."""
    host, road = situation.host, situation.road
    grip = road.friction * GRAVITY_MPS2
    keep = LaneCentre(d_m=road.lane_centre_m(road.lane_of(host.d_m)))
    brake, accelerate = min(-vehicle.acceleration_min_mps2, grip), min(vehicle.acceleration_max_mps2, grip)
    stop = SpeedLaw(speed_mps=0.0, acceleration_mps2=brake)
    go = SpeedLaw(speed_mps=0.98 * vehicle.speed_max_mps, acceleration_mps2=accelerate)
    for policy, law in ((FULL_BRAKING, stop), (FULL_ACCELERATION, go), (HOLD, _steady(host))):
        yield policy, _driven(situation, vehicle, settings, keep, law, 0.5 * grip)
    yield from steering_out(situation, vehicle, settings)


def steering_out(situation: Situation, vehicle: Vehicle, settings: Settings) -> Iterator[tuple[Policy, Trajectory]]:
    """Of the five, the sides."""
    host, road = situation.host, situation.road
    for side, policy in OUT.items():
        target = next_lane_m(situation, vehicle, side)
        watched = situation.coverage.sees(Sector(side.value))
        if target is None or not watched or host.speed_mps < settings.selector.evading_speed_mps:
            continue
        lateral = _STEERING_SHARE * road.friction * GRAVITY_MPS2
        path = corrected(
            start_s_m=host.s_m,
            start_d_m=host.d_m,
            target_d_m=target,
            speed_mps=host.speed_mps,
            lateral_acceleration_mps2=0.8 * lateral,
            b=settings.sigmoid.b,
            speed_floor_mps=settings.sigmoid.speed_floor_mps,
        )
        yield policy, _driven(situation, vehicle, settings, path, _steady(host), lateral)


def _steady(host: HostState) -> SpeedLaw:
    return SpeedLaw(speed_mps=host.speed_mps, acceleration_mps2=1.0)


def _driven(
    situation: Situation, vehicle: Vehicle, settings: Settings, path: LaneCentre | OffsetPath, law: SpeedLaw, lateral_mps2: float
) -> Trajectory:
    return follow(
        situation.host,
        path,
        law,
        vehicle=vehicle,
        road=situation.road,
        duration_s=float(settings.grid.times_s[-1]),
        lateral_acceleration_mps2=lateral_mps2,
    )
