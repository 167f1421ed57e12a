"""One plan without memory: for a situation, or from scans."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.deprecation import renamed
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import require_type, require_type_if_given
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request
from mcdas_opt.planning.method import PlannerName
from mcdas_opt.planning.planner import Planner

_MOST = 8  # planners that a thread keeps warm


class _Warm(threading.local):
    def __init__(self) -> None:
        self.planners: dict[tuple[Vehicle, str, Settings], Planner] = {}


_WARM = _Warm()


def plan(
    situation: Situation,
    vehicle: str | Vehicle | None = None,
    planner: PlannerName | str | None = None,
    *,
    settings: Settings | None = None,
    method: str | None = None,
) -> Plan:
    """The judged plan of a planner that begins: the same question has the same answer. `vehicle` is the situation's own unless given,
    `planner` a registered name (default "mpc"; `method` is its old name).

    Each thread keeps the planners that it asked last, so that only the first question of a kind (vehicle, planner, settings) waits for a
    solver to be built. A vehicle's file is read each time. For a drive build a `Planner`: it goes on with what it began. Raises
    `InputError` or `ParameterError` for what is not known.
    """
    require_type("situation", situation, Situation)
    require_type_if_given("planner", planner, str)
    chosen = renamed("plan", "method", method, "planner", planner) or "mpc"
    begun = _begun(situation.vehicle_name if vehicle is None else vehicle, chosen, settings)
    return begun.plan(situation if vehicle is None else replace(situation, vehicle=begun.vehicle.name))


def step(
    measurements: Sequence[Scan],
    host: HostState,
    now: float,
    *,
    road: Road | None = None,
    vehicle: str | Vehicle = "sedan",
    planner: PlannerName | str = "mpc",
    desired_speed_mps: float | None = None,
    request: Request = Request.DRIVE,
    stop_line_s_m: float | None = None,
    settings: Settings | None = None,
) -> Plan:
    """From scans to a judged plan, of a planner that begins: tracks are made of these scans alone, each seen from where the host is `now`.
    `now` [s] is of the clock that stamps the scans; `desired_speed_mps` left out is the host's speed now.

    In a car build a `Planner` and call its `step` every cycle: it keeps its tracks, and what it began. Raises `InputError` or
    `ParameterError` for what is not known.
    """
    begun = _begun(vehicle, planner, settings)
    told = {"desired_speed_mps": desired_speed_mps, "stop_line_s_m": stop_line_s_m}
    return begun.step(measurements, host, now, road=road or Road(), request=request, **told)


def _begun(vehicle: str | Vehicle, name: str, settings: Settings | None) -> Planner:
    """This thread's planner of that kind, without memory: of a car's file as it is now."""
    require_type("vehicle", vehicle, str, Vehicle)
    require_type("planner", name, str)
    require_type_if_given("settings", settings, Settings)
    car, settings = load_vehicle(vehicle) if isinstance(vehicle, str) else vehicle, settings or Settings()
    asked = car, name, settings
    planner = _WARM.planners.pop(asked, None) or Planner(car, name, settings=settings)
    if len(_WARM.planners) >= _MOST:
        _WARM.planners.pop(next(iter(_WARM.planners)))
    _WARM.planners[asked] = planner
    planner.reset()
    return planner
