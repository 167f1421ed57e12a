"""What a planning method is, and how one is found by name."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Protocol

from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError, nearest

GROUP = "mcdas_opt.methods"
_OWN = {
    "mpc": "mcdas_opt.planning.mpc:MpcMethod",
    "closed-form": "mcdas_opt.planning.closed_form:LiteralMethod",
    "closed-form-corrected": "mcdas_opt.planning.closed_form:CorrectedMethod",
    "closed-form-tuned": "mcdas_opt.planning.tuned_form:TunedMethod",
    "aeb": "mcdas_opt.planning.rivals.aeb:AebMethod",
    "un-r157": "mcdas_opt.planning.rivals.competent_driver:CompetentDriverMethod",
    "idm-mobil": "mcdas_opt.planning.rivals.idm_mobil:IdmMobilMethod",
}


class Method(Protocol):
    """Built as `Method(vehicle, settings)`. Raises nothing in traffic: a plan or a refusal is a value.

    `has_ladder` true: a refusal, or a plan that the judge fails, is answered by the fallback ladder. `vehicle` is what it plans with: of a
    car that slips the planner sets it anew where the point at which that car rolls has moved.
    """

    has_ladder: bool
    vehicle: Vehicle

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal: ...


def known_methods() -> tuple[str, ...]:
    return tuple(sorted({*_OWN, *(point.name for point in entry_points(group=GROUP))}))


def build_method(name: str, vehicle: Vehicle, settings: Settings) -> Method:
    """The method registered as `name`. Raises `ParameterError` that names the nearest known one."""
    if name in _OWN:
        module, _, attribute = _OWN[name].partition(":")
        factory: Any = getattr(import_module(module), attribute)
    else:
        point = next((p for p in entry_points(group=GROUP) if p.name == name), None)
        if point is None:
            raise ParameterError("planner", name, f"is not a known planner; {nearest(name, known_methods())}")
        factory = point.load()
    method: Method = factory(vehicle, settings)
    return method
