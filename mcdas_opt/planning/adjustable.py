"""What of the MPC has no closed form: its adjustable numbers by name, and the method that runs with others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from operator import attrgetter
from typing import Any

from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.domain.rules import finite
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.ocp.lane_mpc import default_weights
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.planning.solver_settings import SolverSettings

_OF_SETTINGS = ("sigmoid", "selector", "headway", "comfort", "manners", "safe_end", "warning")
_GROUPS: dict[str, Any] = {name: attrgetter(name)(Settings()) for name in _OF_SETTINGS} | {"stage": SolverSettings(), "cost": CostWeights()}
_RENAMED = {f"worth.{field.name}": f"cost.{field.name}" for field in fields(CostWeights)} | {  # names that earlier versions gave
    "worth.waiting": "cost.delayed",
    "worth.needless": "cost.unneeded_lane_change",
    "worth.risen": "cost.replanning_ratio",
}
HYSTERESIS = "selector.hysteresis"  # ttc_clear over ttc_threat: one number, so that it cannot be less than 1


def _numbers(group: Any) -> dict[str, float]:
    return {name: value for name, value in asdict(group).items() if type(value) is float}


def defaults() -> dict[str, float]:
    """Every adjustable number by name, 'group.field' or 'weight.cost', at its default."""
    found = {f"{name}.{field}": value for name, group in _GROUPS.items() for field, value in _numbers(group).items()}
    selector = _GROUPS["selector"]
    del found["selector.ttc_clear_s"]
    found[HYSTERESIS] = selector.ttc_clear_s / selector.ttc_threat_s
    return found | {name.replace("weight_", "weight.", 1): value for name, value in default_weights().items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjusted:
    """The settings that a set of values makes."""

    settings: Settings
    solver: SolverSettings
    weights: CostWeights

    def method(self, vehicle: Vehicle) -> MpcMethod:
        return MpcMethod(vehicle, self.settings, self.solver, self.weights)


def adjusted(values: Mapping[str, float]) -> Adjusted:
    """Defaults, replaced by `values`. Raises `ParameterError` for an unknown name or a number that is none."""
    known, values = defaults(), {_RENAMED.get(name, name): value for name, value in values.items()}
    for name, value in values.items():
        if name not in known:
            raise ParameterError(name, value, f"is not adjustable; {nearest(name, known)}")
        finite(name, value)
    groups: dict[str, dict[str, float]] = {group: {} for group in (*_GROUPS, "weight")}
    for name, value in values.items():
        if name != HYSTERESIS:
            group, _, key = name.partition(".")
            groups[group][key] = float(value)
    if HYSTERESIS in values or "ttc_threat_s" in groups["selector"]:
        ratio = float(values.get(HYSTERESIS, known[HYSTERESIS]))
        groups["selector"]["ttc_clear_s"] = ratio * groups["selector"].get("ttc_threat_s", known["selector.ttc_threat_s"])
    made = {name: replace(group, **groups[name]) for name, group in _GROUPS.items()}
    if groups["weight"]:
        weights = default_weights() | {f"weight_{key}": value for key, value in groups["weight"].items()}
        made["stage"] = replace(made["stage"], weights=tuple(weights.items()))
    settings = Settings(**{name: made[name] for name in _OF_SETTINGS})
    return Adjusted(settings=settings, solver=made["stage"], weights=made["cost"])
