"""What a design leaves behind: a TOML that planners take, and a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mcdas_opt.errors import InputError, writing
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
    from mcdas_opt.plotting.style import save_png

    with writing(out):
        parameters.write_text(design.to_toml(), encoding="utf-8")
        save_png(sheet(design), picture, dpi=120)
    return parameters, picture


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
