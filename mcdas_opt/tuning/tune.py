"""The public tuner: one sigmoid designed for a speed."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.tuning.design import Design, design
from mcdas_opt.tuning.request import DesignRequest


def tune(
    *,
    speed_mps: float = 60.0 / 3.6,
    offset_m: float = 0.0,
    objective: str = "shortest",
    lateral_acceleration_mps2: float = 4.0,
    lateral_jerk_mps3: float = 20.0,
    friction: float = 0.9,
    out: str | Path | None = None,
    **limits: Any,
) -> Design:
    """The sigmoid (a, b, y_max) that is shortest, clearest or smoothest within every limit; further limits are those of `DesignRequest`.

    With `out` a TOML and a PNG of that stem are written. Raises `ParameterError` for what is out of range, unknown or cannot be had:
    then with the figure that could.
    """
    known = {f.name for f in fields(DesignRequest)}
    for name in limits:
        if name not in known:
            raise ParameterError(name, limits[name], f"is not a limit of a design; {nearest(name, known)}")
    request = DesignRequest(
        speed_mps=speed_mps,
        offset_m=offset_m,
        objective=objective,
        lateral_acceleration_mps2=lateral_acceleration_mps2,
        lateral_jerk_mps3=lateral_jerk_mps3,
        friction=friction,
        **limits,
    )
    if out is None:
        return design(request)
    from mcdas_opt.tuning.design_file import check_out, write_design

    target = check_out(Path(out))
    found = design(request)
    write_design(found, target)
    return found
