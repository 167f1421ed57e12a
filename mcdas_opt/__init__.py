"""Planner for the car in the middle: front and rear vehicles as constraints, every plan judged before it leaves."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mcdas_opt.catalogue.scenes import Scene, load_scene
    from mcdas_opt.domain.plan import Plan
    from mcdas_opt.domain.situation import Situation

__version__ = "0.1.0"

_HOME = {
    "Plan": "mcdas_opt.domain.plan",
    "Scene": "mcdas_opt.catalogue.scenes",
    "Situation": "mcdas_opt.domain.situation",
    "load_scene": "mcdas_opt.catalogue.scenes",
}

__all__ = ["Plan", "Scene", "Situation", "__version__", "load_scene"]


def __getattr__(name: str) -> Any:
    """Public names load their module when first used, so that importing the package stays light (PEP 562)."""
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'mcdas_opt' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
