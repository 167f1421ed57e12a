"""Planner for the car in the middle: front and rear vehicles as constraints, every plan judged before it leaves.

The names below are the public surface; so is every module whose name does not start with an underscore.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mcdas_opt.catalogue.scenes import Scene, load_scene
    from mcdas_opt.domain.plan import Plan, Refusal
    from mcdas_opt.domain.settings import Settings
    from mcdas_opt.domain.situation import Situation
    from mcdas_opt.parking.case_file import load_parking_case
    from mcdas_opt.parking.park import park
    from mcdas_opt.planning.planner import Planner
    from mcdas_opt.planning.stateless import plan
    from mcdas_opt.simulation.judging import verify
    from mcdas_opt.simulation.loop import simulate
    from mcdas_opt.time_to_react.escapes import escapes
    from mcdas_opt.tuning.tune import tune

__version__ = "0.1.0"

_HOME = {
    "Plan": "mcdas_opt.domain.plan",
    "Planner": "mcdas_opt.planning.planner",
    "Refusal": "mcdas_opt.domain.plan",
    "Scene": "mcdas_opt.catalogue.scenes",
    "Settings": "mcdas_opt.domain.settings",
    "Situation": "mcdas_opt.domain.situation",
    "escapes": "mcdas_opt.time_to_react.escapes",
    "load_parking_case": "mcdas_opt.parking.case_file",
    "load_scene": "mcdas_opt.catalogue.scenes",
    "park": "mcdas_opt.parking.park",
    "plan": "mcdas_opt.planning.stateless",
    "simulate": "mcdas_opt.simulation.loop",
    "tune": "mcdas_opt.tuning.tune",
    "verify": "mcdas_opt.simulation.judging",
}

__all__ = [
    "Plan",
    "Planner",
    "Refusal",
    "Scene",
    "Settings",
    "Situation",
    "__version__",
    "escapes",
    "load_parking_case",
    "load_scene",
    "park",
    "plan",
    "simulate",
    "tune",
    "verify",
]


def __getattr__(name: str) -> Any:
    """Public names load their module when first used, so that importing the package stays light (PEP 562)."""
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'mcdas_opt' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
