"""What anybody would try: keep the lane, braking ever harder or accelerating, then steer out with all grip."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from mcdas_opt.actuation.path_following import SpeedLaw
from mcdas_opt.domain.plan import Candidate
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.planning.candidate import Checked, Costed, Driven, Proposed
from mcdas_opt.planning.candidates.collision_check import verdicts
from mcdas_opt.planning.candidates.path_driving import follow
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage
from mcdas_opt.planning.proposals.keep_lane import keep_path
from mcdas_opt.reference.lane_centre import LaneCentre
from mcdas_opt.reference.offset_path import OffsetPath, corrected

_BRAKING_SHARES = (0.25, 0.5, 0.75, 1.0)
_ACCELERATING_SHARES = (0.5, 1.0)
_STEERING_SHARE = 0.9  # of the grip, for steering out with nothing left for brakes


def simple_drives(cycle: Cycle, rows: list[Candidate]) -> Iterator[Checked]:
    """Checked in one go: where most of them fail, all cost little more than one. The five policies where the deadline is near."""
    drives = simple_policies(cycle) if cycle.is_late_for(Stage.GRADES) else [*_in_the_lane(cycle), *_steering_out(cycle)]
    yield from _checked(list(drives), cycle, rows)


def stop_in_lane(cycle: Cycle, rows: list[Candidate]) -> Iterator[Checked]:
    """Braking ever harder to a stop, then holding speed."""
    drives = [driven for driven in _in_the_lane(cycle) if driven.proposed.mode in (Mode.BRAKE, Mode.HOLD)]
    yield from _checked(sorted(drives, key=lambda driven: driven.proposed.mode is Mode.HOLD), cycle, rows)


def simple_policies(cycle: Cycle) -> Iterator[Driven]:
    """The five that a plan is measured by: hold, full braking, full acceleration, and steering out to either side."""
    yield from _in_the_lane(cycle, braking_shares=(1.0,), accelerating_shares=(1.0,))
    yield from _steering_out(cycle)


def _checked(drives: Sequence[Driven], cycle: Cycle, rows: list[Candidate]) -> Iterator[Checked]:
    judged = verdicts([driven.trajectory for driven in drives], cycle)
    for driven, verdict in zip(drives, judged, strict=True):
        checked = Checked(driven=driven, verdict=verdict)
        rows.append(Costed(checked=checked, cost=None).row())
        proposed = driven.proposed
        yield checked if proposed.side is not Side.NONE else checked.proposed_as(replace(proposed, name=f"{proposed.name} in the lane"))


def _in_the_lane(
    cycle: Cycle, braking_shares: Sequence[float] = _BRAKING_SHARES, accelerating_shares: Sequence[float] = _ACCELERATING_SHARES
) -> Iterator[Driven]:
    """Hold, brake ever harder to a stop, accelerate: along the middle of the lane, with half the grip for coming back to it."""
    vehicle, friction = cycle.vehicle, cycle.situation.road.friction
    brake, accelerate = available_mps2(vehicle, friction)
    laws = [("hold", Mode.HOLD, _steady(cycle))]
    for share in braking_shares:
        most = share * brake
        laws.append((f"brake {most:.1f} m/s^2", Mode.BRAKE, SpeedLaw(speed_mps=0.0, acceleration_mps2=most)))
    for share in accelerating_shares:
        most = share * accelerate
        law = SpeedLaw(speed_mps=0.98 * vehicle.speed_max_mps, acceleration_mps2=most)
        laws.append((f"accelerate {most:.1f} m/s^2", Mode.ACCELERATE, law))
    path, middle = keep_path(cycle), LaneCentre(d_m=cycle.lane_centre_m)
    for name, mode, law in laws:
        proposed = Proposed(name=name, mode=mode, side=Side.NONE, path=path, speed_mps=law.speed_mps)
        yield _driven(proposed, middle, law, 0.5 * friction * GRAVITY_MPS2, cycle)


def _steering_out(cycle: Cycle) -> Iterator[Driven]:
    """To either side at constant speed; one without lane or shoulder, or that nobody watches, is left out."""
    situation, settings = cycle.situation, cycle.settings
    host, law = situation.host, _steady(cycle)
    lateral = _STEERING_SHARE * situation.road.friction * GRAVITY_MPS2
    for side in (Side.LEFT, Side.RIGHT):
        target = next_lane_m(situation, cycle.vehicle, side)
        watched = situation.coverage.sees(Sector(side.value))
        if target is None or not watched or host.speed_mps < settings.selector.evading_speed_mps:
            continue
        path = corrected(
            start_s_m=host.s_m,
            start_d_m=host.d_m,
            target_d_m=target,
            speed_mps=host.speed_mps,
            lateral_acceleration_mps2=0.8 * lateral,
            b=settings.sigmoid.b,
            speed_floor_mps=settings.sigmoid.speed_floor_mps,
        )
        proposed = Proposed(name=f"hard {side.value}", mode=Mode.EVADE, side=side, path=path, speed_mps=law.speed_mps)
        yield _driven(proposed, path, law, lateral, cycle)


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
