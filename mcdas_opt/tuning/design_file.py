"""What a design leaves behind: a TOML that planners take, and a picture."""

from __future__ import annotations

from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.domain.document import to_document
from mcdas_opt.errors import InputError
from mcdas_opt.tuning.design import Design

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SUFFIXES = (".toml", ".png")


def check_out(out: Path) -> Path:
    """Raises `InputError` for a file that is neither a TOML nor a PNG, before anything is computed."""
    if out.suffix.lower() not in _SUFFIXES:
        raise InputError(out, "", None, "must end in .toml or .png: both are written side by side")
    return out


def write_design(design: Design, out: Path) -> tuple[Path, Path]:
    """Writes `out`'s stem as .toml and as .png; returns both."""
    parameters, picture = check_out(out).with_suffix(".toml"), out.with_suffix(".png")
    try:
        parameters.write_text(design_text(design), encoding="utf-8")
        from mcdas_opt.plotting.style import save_png

        save_png(sheet(design), picture, dpi=120)
    except OSError as error:
        raise InputError(out, "", None, f"cannot be written: {error.strerror}") from None
    return parameters, picture


def design_text(design: Design) -> str:
    """The TOML: `sigmoid` is what `plan --params` takes, the rest says where it comes from."""
    from importlib.metadata import version

    request = to_document(design.request)
    vehicle = request.pop("vehicle")["name"]
    facts = ("objective", "value", "unit", "length_m", "end_m", "duration_s", "speed_mps", "active")
    document: dict[str, Any] = {
        "sigmoid": {
            "a_per_m": design.a_per_m,
            "b": design.b,
            "y_max_m": design.y_max_m,
            "offset_m": design.offset_m,
            "side": design.side.value,
            "lateral_acceleration_mps2": next(c.limit for c in design.constraints if c.name == "lateral acceleration"),
        },
        "design": {key: to_document(attrgetter(key)(design)) for key in facts},
        "provenance": {
            "made_by": f"mcdas-opt {version('mcdas-opt')} tune",
            "method": design.method,
            "evaluations": design.evaluations,
            "vehicle": vehicle,
            **{f"request_{key}": value for key, value in request.items() if key != "objective"},
        },
        "constraint": [to_document(row) for row in design.constraints],
    }
    return toml_text(document)


def sheet(design: Design) -> Figure:
    """The path with its curvature, acceleration and jerk against their limits, and the paper's beside it."""
    from mcdas_opt.plotting.design import design_sheet

    limits = {c.name: c.limit for c in design.constraints}
    return design_sheet(
        design.sigmoid,
        speed_mps=design.speed_mps,
        lane_width_m=design.request.lane_width_m,
        length_m=design.length_m,
        lateral_limit_mps2=min(limits["lateral acceleration"], limits["friction"]),
        jerk_limit_mps3=limits["lateral jerk"],
        vehicle=design.request.vehicle,
        title=f"{design.objective}: {design.length_m:.1f} m at {3.6 * design.speed_mps:.0f} km/h",
    )
