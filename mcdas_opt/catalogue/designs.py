"""Files of a designed sigmoid: what `tune` writes and `plan --params` reads."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import Field

from mcdas_opt.catalogue.data_files import checked, read_toml
from mcdas_opt.catalogue.part import Part
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import InputError, blaming


class _SigmoidPart(Part):
    a_per_m: float
    b: float
    y_max_m: float
    offset_m: float = 0.0
    side: Literal["left", "right"] = "left"
    lateral_acceleration_mps2: float | None = None


class DesignFile(Part):
    """`sigmoid` or `values` is what a planner takes, one of them; the other tables say where it comes from."""

    KIND: ClassVar[str] = "file of values"

    sigmoid: _SigmoidPart | None = None
    values: dict[str, float] = Field(default_factory=dict)
    design: dict[str, Any] = Field(default_factory=dict)
    provenance: dict[str, Any] = Field(default_factory=dict)
    constraint: list[dict[str, Any]] = Field(default_factory=list)
    set: list[dict[str, Any]] = Field(default_factory=list)


def load_parameters(path: Path) -> tuple[SigmoidSettings | None, dict[str, float]]:
    """A file's sigmoid, or its values by name. Raises `InputError` that names file, key, value and rule."""
    if not os.path.isfile(path):
        raise InputError(path, "", None, "no such file")
    document = checked(DesignFile, read_toml(path), path)
    if (document.sigmoid is None) == (not document.values):
        raise InputError(path, "sigmoid", None, "must hold a table [sigmoid] or a table [values], one of them")
    return (None if document.sigmoid is None else _settings(document.sigmoid, path)), document.values


def _settings(part: _SigmoidPart, path: Path) -> SigmoidSettings:
    if part.lateral_acceleration_mps2 is not None and part.lateral_acceleration_mps2 <= 0.0:
        raise InputError(path, "sigmoid.lateral_acceleration_mps2", part.lateral_acceleration_mps2, "must be greater than 0")
    with blaming(path, "sigmoid."):
        given = SigmoidDesign(a_per_m=part.a_per_m, b=part.b, y_max_m=part.y_max_m, offset_m=part.offset_m, side=Side(part.side))
    settings = SigmoidSettings(given=given)
    if part.lateral_acceleration_mps2 is not None:
        settings = replace(settings, lateral_acceleration_mps2=part.lateral_acceleration_mps2)
    return settings
