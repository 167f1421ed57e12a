"""Whatever has to be built or loaded, before the first cycle."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.manoeuvres.kinds import build_family
from mcdas_opt.native.kernels import CONSERVATIVE_ACCEPT, PLAIN
from mcdas_opt.reference.offset_path import build_search
from mcdas_opt.time_to_react.compiled_case import compiled_escapes


@dataclass(frozen=True, slots=True, kw_only=True)
class WarmUp:
    """What was made ready for a vehicle, in which form it runs, and how long that took."""

    vehicle: str
    solver: str
    seconds: float


def load_kernels(settings: Settings) -> None:
    """The libraries that any planner's cycle may ask for: judge, tracker, manoeuvres, time to react. Built where they are not there yet."""
    PLAIN.loaded()
    CONSERVATIVE_ACCEPT.loaded()
    build_search()
    build_family(settings.grid)
    if settings.warning.escapes:
        compiled_escapes()


def warm_up(vehicle: Vehicle) -> WarmUp:
    """Builds, once a machine, what planning for this vehicle needs, and its dynamic plant where its chassis is known; else loads it."""
    from mcdas_opt.planning.mpc import MpcMethod

    started = time.perf_counter()
    load_kernels(Settings())
    solver = MpcMethod(vehicle).solver
    MpcMethod(replace(vehicle, zero_sideslip_point_m=Chassis.of(vehicle).zero_sideslip_point_m(vehicle.speed_max_mps)))
    return WarmUp(vehicle=vehicle.name, solver=solver, seconds=time.perf_counter() - started)
