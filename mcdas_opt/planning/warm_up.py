"""Whatever has to be loaded, before the first cycle."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.native.library import library


@dataclass(frozen=True, slots=True, kw_only=True)
class WarmUp:
    """What was made ready for a vehicle, in which form it runs, and how long that took."""

    vehicle: str
    solver: str
    seconds: float


def warm_up(vehicle: Vehicle) -> WarmUp:
    """Loads what planning for this vehicle needs, and for its dynamic plant where its chassis is known."""
    from mcdas_opt.planning.mpc import MpcMethod

    started = time.perf_counter()
    library()
    solver = MpcMethod(vehicle).solver
    MpcMethod(replace(vehicle, zero_sideslip_point_m=Chassis.of(vehicle).zero_sideslip_point_m(vehicle.speed_max_mps)))
    return WarmUp(vehicle=vehicle.name, solver=solver, seconds=time.perf_counter() - started)
