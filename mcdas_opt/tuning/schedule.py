"""The gain schedule: the designer run over speed, offset and friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any

import numpy as np

from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.tuning.design import Design, design
from mcdas_opt.tuning.request import DesignRequest

SPEEDS_MPS = tuple(round(v / 3.6, 6) for v in (15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0, 60.0, 70.0, 80.0, 100.0, 120.0, 140.0, 160.0))
OFFSETS_M = (-2.0, -1.0, 0.0, 1.0, 2.0)
FRICTIONS = (0.25, 0.5, 0.9)


def build_schedule(
    name: str,
    *,
    speeds_mps: Sequence[float] = SPEEDS_MPS,
    offsets_m: Sequence[float] = OFFSETS_M,
    frictions: Sequence[float] = FRICTIONS,
) -> GainSchedule:
    """A design at every crossing. The lateral bound is the lesser of the usual request's and the planner's share of the friction.

    Raises `ParameterError` where a crossing has no design.
    """
    request, share = DesignRequest(), SigmoidSettings().lateral_friction_share
    shape = (len(frictions), len(offsets_m), len(speeds_mps))
    found: dict[tuple[int, ...], Design] = {}
    for at in np.ndindex(shape):
        friction = frictions[at[0]]
        bound = min(request.lateral_acceleration_mps2, share * friction * GRAVITY_MPS2)
        asked = replace(request, speed_mps=speeds_mps[at[2]], offset_m=offsets_m[at[1]], friction=friction, lateral_acceleration_mps2=bound)
        found[at] = design(asked)

    def table(key: str) -> Any:
        return np.array([round(attrgetter(key)(found[at]), 9) for at in np.ndindex(shape)]).reshape(shape)

    return GainSchedule(
        name=name,
        speed_mps=tuple(speeds_mps),
        offset_m=tuple(offsets_m),
        friction=tuple(frictions),
        a_per_m=table("a_per_m"),
        b=table("b"),
        y_max_m=table("y_max_m"),
        length_m=table("length_m"),
    )


def schedule_text(schedule: GainSchedule) -> str:
    """The file of `models/tuned`: tables by friction, offset, speed, and where they come from."""
    from importlib.metadata import version

    request = DesignRequest()
    limits = ("lateral_acceleration_mps2", "lateral_jerk_mps3", "heading_jump_rad", "settling_m", "curvature_1pm", "lane_width_m")
    document: dict[str, Any] = {
        "speed_mps": list(schedule.speed_mps),
        "offset_m": list(schedule.offset_m),
        "friction": list(schedule.friction),
        "a_per_m": schedule.a_per_m.tolist(),
        "b": schedule.b.tolist(),
        "y_max_m": schedule.y_max_m.tolist(),
        "length_m": schedule.length_m.tolist(),
        "provenance": {
            "made_by": f"mcdas-opt {version('mcdas-opt')}, tuning.schedule.build_schedule; python benchmarks/tuning.py schedule",
            "method": f"nlp (IPOPT of casadi {version('casadi')}, exact derivatives), every crossing its own optimum",
            "objective": request.objective,
            "vehicle": request.vehicle.name,
            "lateral_friction_share": SigmoidSettings().lateral_friction_share,
            **dict(zip(limits, attrgetter(*limits)(request), strict=True)),
        },
    }
    head = "# Sigmoid parameters by [friction][offset][speed]; the offset is the front vehicle's, towards the side that is steered to.\n"
    return head + toml_text(document)
