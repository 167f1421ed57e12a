"""Parking: search, closed forms, the nonlinear program with its exchange loop, and the one public function `park`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mcdas_opt.planning.parking.park import PLANNERS, ParkSettings, park

__all__ = ["PLANNERS", "ParkSettings", "park"]


def __getattr__(name: str) -> Any:
    """`park` and its settings load CasADi only when they are asked for (PEP 562)."""
    if name in __all__:
        import importlib

        return getattr(importlib.import_module("mcdas_opt.planning.parking.park"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
