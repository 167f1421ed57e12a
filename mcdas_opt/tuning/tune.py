"""The public tuner: one sigmoid designed for a speed, or a study in traffic."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.rules import require_type, require_type_if_given
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.tuning.design import Design, design
from mcdas_opt.tuning.request import DesignRequest
from mcdas_opt.tuning.study_options import StudyOptions

if TYPE_CHECKING:
    from mcdas_opt.tuning.tune_in_traffic import StudyReport


Objective = Literal["shortest", "clearance", "jerk"]
_OF_A_DESIGN = ("offset_m", "objective", "lateral_acceleration_mps2", "lateral_jerk_mps3", "friction")
_OF_A_STUDY = ("trials", "storage", "study")


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
@usual_arithmetic
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
    of that stem are written. Raises `ParameterError` for what is out of range, unknown, of the other kind or cannot be had:
    then with the figure that could.
    """
    given = locals()
    require_type_if_given("out", out, str, Path)
    _refuse(_OF_A_STUDY if scenes is None else _OF_A_DESIGN, given, "is of a study in traffic" if scenes is None else "is of a design")
    if scenes is not None:
        from mcdas_opt.tuning.tune_in_traffic import tune_in_traffic

        if storage is None:
            raise ParameterError("storage", None, "a study needs a file to live in")
        require_type("storage", storage, str, Path)
        if study is not None:
            _refuse(("speed_mps",), given, "is said by study.speed_mps")
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


def _refuse(names: Iterable[str], given: Mapping[str, Any], rule: str) -> None:
    """What would not be read: none of these may be given, but as it is by default."""
    for name in names:
        default = signature(tune).parameters[name].default
        if type(given[name]) is not type(default) or given[name] != default:
            raise ParameterError(name, given[name], rule)
