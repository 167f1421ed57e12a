"""Planning with a file of parameters: a designed sigmoid, or a study's values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from mcdas_opt.catalogue.designs import load_parameters
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, blaming
from mcdas_opt.planning.adjustable import adjusted
from mcdas_opt.planning.planner import Planner

_WITHOUT_SIGMOID = ("acc", "aeb", "commonroad-reactive", "idm-mobil", "un-r157")


def planner_with(
    path: Path | None, vehicle: Vehicle, method: str, reserve: Callable[[Settings], Settings] = lambda settings: settings
) -> Planner:
    """A fresh planner; with a file, one that plans by it. `reserve` is what its settings have to leave to whoever drives the plan.

    Raises `InputError` that names file, key, value and rule.
    """
    if path is None:
        return Planner(vehicle=vehicle, method=method, settings=reserve(Settings()))
    sigmoid, values = load_parameters(path)
    if sigmoid is not None:
        if method in _WITHOUT_SIGMOID:
            raise InputError(path, "sigmoid", None, f"is read by mpc and closed-form-corrected: {method!r} does not take it")
        return Planner(vehicle=vehicle, method=method, settings=reserve(Settings(sigmoid=sigmoid)))
    if method != "mpc":
        raise InputError(path, "values", None, f"are the MPC's: {method!r} does not take them")
    with blaming(path, "values."):
        made = adjusted(values)
        made = replace(made, settings=reserve(made.settings))
    return Planner(vehicle=vehicle, method=made.method(vehicle), settings=made.settings, name=method)
