"""Whatever has to be loaded, before the first cycle."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.native.library import library
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.method import CycleMethod
from mcdas_opt.planning.time_to_react import with_time_to_react

_FAST_MPS, _SLOW_MPS = 20.0, 12.0


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


def rehearse(method: CycleMethod, settings: Settings) -> None:
    """Two cycles that nobody asked for, one in which nothing threatens and one between two cars. What runs for the first time takes two to
    four times as long: memory is touched, texts are linked, small tables made."""
    own = min(_FAST_MPS, 0.5 * method.vehicle.speed_max_mps)
    front = Track(id="front", s_m=30.0, d_m=0.0, speed_s_mps=own * _SLOW_MPS / _FAST_MPS)
    rear = Track(id="rear", s_m=-20.0, d_m=0.0, speed_s_mps=own)
    for tracks in ((), (front, rear)):
        situation = Situation(host=HostState(speed_mps=own), tracks=tracks, coverage=Coverage())
        cycle = Cycle.of(situation, method.vehicle, settings)
        answer = method.answer(cycle)
        if isinstance(answer, Plan):
            with_time_to_react(answer, cycle)
