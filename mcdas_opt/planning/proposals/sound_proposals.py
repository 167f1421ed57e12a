"""What a function of the list of candidates proposes, each proposal checked: a faulty one is refused by name, and the others go on."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import Array, require_type, within
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.errors import McdasError, ParameterError, PlannerFaultWarning, told
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.reference.offset_path import OffsetPath

_STATES = 6
_OURS = frozenset({"brake", "brake-behind", "brake-for-bend", "accelerate", "left", "right", "keep"})


def sound_proposals(functions: Iterable[Callable[[Cycle], Iterable[Proposed]]], path: OffsetPath, cycle: Cycle) -> tuple[Proposed, ...]:
    """Of all functions, in their order. One that fails is refused under its own name, on `path`, with a `PlannerFaultWarning`."""
    found: list[Proposed] = []
    names = set(_OURS)
    for function in functions:
        for proposed in _proposals(function, path, cycle):
            fault = f"there is another {proposed.name!r}" if proposed.name in names else _fault(proposed, cycle)
            names.add(proposed.name)
            found.append(replace(proposed, refusal=f"faulty: {fault}") if fault else proposed)
    return tuple(found)


def _proposals(function: Callable[[Cycle], Iterable[Proposed]], path: OffsetPath, cycle: Cycle) -> tuple[Proposed, ...]:
    name = getattr(function, "__name__", repr(function))
    try:
        proposals = tuple(function(cycle))
        for proposed in proposals:
            require_type(f"a proposal of {name}", proposed, Proposed)
            require_type(f"the name of a proposal of {name}", proposed.name, str)
        return proposals
    except Exception as error:
        fault = f"{name} failed: {told(error)}"
        warnings.warn(fault, PlannerFaultWarning, stacklevel=2)
        return (Proposed(name=name, mode=Mode.HOLD, side=Side.NONE, path=path, speed_mps=0.0, refusal=fault),)


def _fault(proposed: Proposed, cycle: Cycle) -> str:
    """What is wrong with it; empty where nothing is."""
    nodes = len(cycle.settings.grid.times_s)
    try:
        require_types(proposed)
        require_type("mode", proposed.mode, Mode)
        require_type("side", proposed.side, Side)
        within("speed_mps", proposed.speed_mps, 0.0, max(cycle.vehicle.speed_max_mps, cycle.situation.host.speed_mps), "m/s")
        _require_shape("guess", proposed.guess, (nodes, _STATES))
        _require_shape("speeds_mps", proposed.speeds_mps, (nodes,))
    except McdasError as error:
        return str(error)
    return ""


def _require_shape(name: str, values: Array | None, shape: tuple[int, ...]) -> None:
    if values is not None and not (isinstance(values, np.ndarray) and values.shape == shape and np.isfinite(values).all()):
        raise ParameterError(name, f"shape {np.shape(values)}", f"must be finite numbers of shape {shape}")
