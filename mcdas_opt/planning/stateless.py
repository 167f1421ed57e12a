"""One plan for one situation, without memory."""

from __future__ import annotations

import threading

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.rules import require_type
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.planner import Planner

_MOST = 8  # planners that a thread keeps warm


class _Warm(threading.local):
    def __init__(self) -> None:
        self.planners: dict[tuple[str | Vehicle, str, Settings | None], Planner] = {}


_WARM = _Warm()


def plan(situation: Situation, vehicle: str | Vehicle | None = None, method: str = "mpc", *, settings: Settings | None = None) -> Plan:
    """The judged plan of a planner that begins: the same question has the same answer. `vehicle` is the situation's own unless given.

    Each thread keeps the planners that it asked last, so that only the first question of a kind waits for a solver to be built. For a drive
    build a `Planner`: it goes on with what it began. Raises `InputError` or `ParameterError` for what is not known.
    """
    require_type("situation", situation, Situation)
    asked = situation.vehicle if vehicle is None else vehicle, method, settings
    planner = _WARM.planners.pop(asked, None) or Planner(asked[0], method, settings=settings)
    if len(_WARM.planners) >= _MOST:
        _WARM.planners.pop(next(iter(_WARM.planners)))
    _WARM.planners[asked] = planner
    planner.reset()
    return planner.plan(situation)
