"""The public tuner: one sigmoid designed for a speed, or a study in traffic."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from mcdas_opt.domain.rules import require_type, require_type_if_given
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.tuning.design import Design, design
from mcdas_opt.tuning.request import DesignRequest
from mcdas_opt.tuning.study_options import StudyOptions

if TYPE_CHECKING:
    from mcdas_opt.tuning.tune_in_traffic import StudyReport


Objective = Literal["shortest", "clearance", "jerk"]


@overload
def tune(
    *,
    speed_mps: float = ...,
    offset_m: float = ...,
    objective: Objective | str = ...,
    lateral_acceleration_mps2: float = ...,
    lateral_jerk_mps3: float = ...,
    friction: float = ...,
    out: str | Path | None = ...,
    scenes: None = ...,
    **limits: Any,
) -> Design: ...
@overload
def tune(
    *,
    speed_mps: float = ...,
    out: str | Path | None = ...,
    scenes: str,
    trials: int = ...,
    storage: str | Path,
    study: StudyOptions | None = ...,
) -> StudyReport: ...
def tune(
    *,
    speed_mps: float = 60.0 / 3.6,
    offset_m: float = 0.0,
    objective: Objective | str = "shortest",
    lateral_acceleration_mps2: float = 4.0,
    lateral_jerk_mps3: float = 20.0,
    friction: float = 0.9,
    out: str | Path | None = None,
    scenes: str | None = None,
    trials: int = 30,
    storage: str | Path | None = None,
    study: StudyOptions | None = None,
    **limits: Any,
) -> Design | StudyReport:
    """The sigmoid (a, b, y_max) that is shortest, clearest or smoothest within every limit; further limits are those of `DesignRequest`.

    With `scenes`, a suite's name, a study in traffic instead, of `trials` trials kept in the file `storage`. With `out` a TOML and a PNG
    of that stem are written. Raises `ParameterError` for what is out of range, unknown or cannot be had:
    then with the figure that could.
    """
    require_type_if_given("out", out, str, Path)
    if scenes is not None:
        from mcdas_opt.tuning.tune_in_traffic import tune_in_traffic

        if storage is None:
            raise ParameterError("storage", None, "a study needs a file to live in")
        require_type("storage", storage, str, Path)
        if limits:
            raise ParameterError(next(iter(limits)), next(iter(limits.values())), "is a limit of a design, not of a study")
        target = None if out is None else Path(out)
        return tune_in_traffic(scenes, trials, Path(storage), study or StudyOptions(speed_mps=speed_mps), out=target)
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
    from mcdas_opt.tuning.design import check_out, write_design

    target = check_out(Path(out))
    found = design(request)
    write_design(found, target)
    return found
