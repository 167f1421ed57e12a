"""What anybody would try: keep the lane, braking ever harder or accelerating, then steer out with all grip."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from mcdas_opt.actuation.path_following import SpeedLaw
from mcdas_opt.domain.plan import Candidate
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.planning.candidate import Checked, Costed, Driven, Proposed
from mcdas_opt.planning.collision_check import verdicts
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.proposals.keep_lane import keep_path
from mcdas_opt.planning.simple_policies import driven_in_lane, steering_out

_BRAKING_SHARES = (0.25, 0.5, 0.75, 1.0)
_ACCELERATING_SHARES = (0.5, 1.0)


def simple_drives(cycle: Cycle, rows: list[Candidate]) -> Iterator[Checked]:
    """Checked in one go: where most of them fail, all cost little more than one."""
    yield from _checked([*_in_the_lane(cycle), *steering_out(cycle)], cycle, rows)


def stop_in_lane(cycle: Cycle, rows: list[Candidate]) -> Iterator[Checked]:
    """Braking ever harder to a stop, then holding speed."""
    drives = [driven for driven in _in_the_lane(cycle) if driven.proposed.mode in (Mode.BRAKE, Mode.HOLD)]
    yield from _checked(sorted(drives, key=lambda driven: driven.proposed.mode is Mode.HOLD), cycle, rows)


def _checked(drives: Sequence[Driven], cycle: Cycle, rows: list[Candidate]) -> Iterator[Checked]:
    judged = verdicts([driven.trajectory for driven in drives], cycle)
    for driven, verdict in zip(drives, judged, strict=True):
        checked = Checked(driven=driven, verdict=verdict)
        rows.append(Costed(checked=checked, cost=None).row())
        proposed = driven.proposed
        yield checked if proposed.side is not Side.NONE else checked.proposed_as(replace(proposed, name=f"{proposed.name} in the lane"))


def _in_the_lane(cycle: Cycle) -> Iterator[Driven]:
    """Hold, brake ever harder to a stop, accelerate."""
    situation, vehicle = cycle.situation, cycle.vehicle
    brake, accelerate = available_mps2(vehicle, situation.road.friction)
    laws = [("hold", Mode.HOLD, SpeedLaw(speed_mps=situation.host.speed_mps, acceleration_mps2=1.0))]
    for share in _BRAKING_SHARES:
        most = share * brake
        laws.append((f"brake {most:.1f} m/s^2", Mode.BRAKE, SpeedLaw(speed_mps=0.0, acceleration_mps2=most)))
    for share in _ACCELERATING_SHARES:
        most = share * accelerate
        law = SpeedLaw(speed_mps=0.98 * vehicle.speed_max_mps, acceleration_mps2=most)
        laws.append((f"accelerate {most:.1f} m/s^2", Mode.ACCELERATE, law))
    path = keep_path(cycle)
    for name, mode, law in laws:
        proposed = Proposed(name=name, mode=mode, side=Side.NONE, path=path, speed_mps=law.speed_mps)
        yield driven_in_lane(proposed, law, cycle)
