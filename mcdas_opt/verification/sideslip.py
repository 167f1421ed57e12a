"""Whether the car grips at all: plans are those of a car without slip, and a car that spins follows none of them."""

from __future__ import annotations

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Violation, ViolationKind
from mcdas_opt.dynamics.single_track import slip_share


def sideslip(start: HostState | None, vehicle: Vehicle, road: Road) -> Violation | None:
    """The violation of every trajectory from a start whose rear tyres slide (`Chassis.sliding_sideslip_rad`); None where they grip, or the
    car hardly moves. Without a start nothing is known of it."""
    if start is None or start.sideslip_rad == 0.0:
        return None
    limit = Chassis.of(vehicle).sliding_sideslip_rad(road.friction)
    if start.sideslip_rad * slip_share(start.speed_mps) <= limit:
        return None
    return Violation(kind=ViolationKind.SIDESLIP, t_s=0.0, value=start.sideslip_rad, limit=limit, unit="rad")
