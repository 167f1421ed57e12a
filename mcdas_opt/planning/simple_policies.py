"""What anybody would try when nothing is safe: full braking, full acceleration, hold, and steering out to either side with all grip."""

from __future__ import annotations

from collections.abc import Iterator

from mcdas_opt.actuation.path_following import SpeedLaw
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.planning.candidate import Driven, Proposed
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.path_driving import follow
from mcdas_opt.planning.proposals.keep_lane import keep_path
from mcdas_opt.reference.lane_centre import LaneCentre
from mcdas_opt.reference.offset_path import OffsetPath, corrected

FULL_BRAKING, FULL_ACCELERATION, HOLD = "full braking", "full acceleration", "hold"
_OUT = {side: f"hard {side.value}" for side in (Side.LEFT, Side.RIGHT)}
_STEERING_SHARE = 0.9  # of the grip, for steering out with nothing left for brakes


def simple_policies(cycle: Cycle) -> Iterator[Driven]:
    """The five, driven by the bicycle within the car's limits; a side without lane or shoulder, or that nobody watches, is left out."""
    vehicle, path = cycle.vehicle, keep_path(cycle)
    brake, accelerate = available_mps2(vehicle, cycle.situation.road.friction)
    stop = SpeedLaw(speed_mps=0.0, acceleration_mps2=brake)
    go = SpeedLaw(speed_mps=0.98 * vehicle.speed_max_mps, acceleration_mps2=accelerate)
    laws = ((FULL_BRAKING, Mode.BRAKE, stop), (FULL_ACCELERATION, Mode.ACCELERATE, go), (HOLD, Mode.HOLD, _steady(cycle)))
    for name, mode, law in laws:
        yield driven_in_lane(Proposed(name=name, mode=mode, side=Side.NONE, path=path, speed_mps=law.speed_mps), law, cycle)
    yield from steering_out(cycle)


def steering_out(cycle: Cycle) -> Iterator[Driven]:
    """Of the five, the sides."""
    situation, settings = cycle.situation, cycle.settings
    host, law = situation.host, _steady(cycle)
    for side, name in _OUT.items():
        target = next_lane_m(situation, cycle.vehicle, side)
        watched = situation.coverage.sees(Sector(side.value))
        if target is None or not watched or host.speed_mps < settings.selector.evading_speed_mps:
            continue
        lateral = _STEERING_SHARE * situation.road.friction * GRAVITY_MPS2
        path = corrected(
            start_s_m=host.s_m,
            start_d_m=host.d_m,
            target_d_m=target,
            speed_mps=host.speed_mps,
            lateral_acceleration_mps2=0.8 * lateral,
            b=settings.sigmoid.b,
            speed_floor_mps=settings.sigmoid.speed_floor_mps,
        )
        proposed = Proposed(name=name, mode=Mode.EVADE, side=side, path=path, speed_mps=law.speed_mps)
        yield _driven(proposed, path, law, lateral, cycle)


def driven_in_lane(proposed: Proposed, law: SpeedLaw, cycle: Cycle) -> Driven:
    """Along the middle of the lane that holds the body centre, by this law, with half the grip for coming back to it."""
    road = cycle.situation.road
    host = cycle.situation.host
    middle = LaneCentre(d_m=road.lane_centre_m(road.lane_of(host.d_m, host.s_m), host.s_m))
    return _driven(proposed, middle, law, 0.5 * _grip_mps2(cycle), cycle)


def _grip_mps2(cycle: Cycle) -> float:
    return cycle.situation.road.friction * GRAVITY_MPS2


def _steady(cycle: Cycle) -> SpeedLaw:
    return SpeedLaw(speed_mps=cycle.situation.host.speed_mps, acceleration_mps2=1.0)


def _driven(proposed: Proposed, path: LaneCentre | OffsetPath, law: SpeedLaw, lateral_mps2: float, cycle: Cycle) -> Driven:
    trajectory = follow(
        cycle.situation.host,
        path,
        law,
        vehicle=cycle.vehicle,
        road=cycle.situation.road,
        duration_s=float(cycle.settings.grid.times_s[-1]),
        lateral_acceleration_mps2=lateral_mps2,
    )
    return Driven(proposed=proposed, trajectory=trajectory)
