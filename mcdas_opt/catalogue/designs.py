"""Files of designed sigmoids: what `tune` writes and `plan --params` reads, and the gain schedules of `models/tuned`."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from mcdas_opt.catalogue.data_files import checked, find, read_toml, shipped
from mcdas_opt.catalogue.part import Part
from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import InputError, ParameterError, blaming

DEFAULT = "sedan"


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


Table = list[list[list[float]]]


class ScheduleFile(Part):
    """Axes, tables (friction, offset, speed), and where they come from."""

    speed_mps: list[float]
    offset_m: list[float]
    friction: list[float]
    a_per_m: Table
    b: Table
    y_max_m: Table
    length_m: Table
    provenance: dict[str, Any] = Field(default_factory=dict)


def load_schedule(name: str | Path) -> GainSchedule:
    """The schedule behind a shipped name or a path. Raises `InputError` that names file, key, value and rule."""
    path = find("tuned", str(name))
    entry = checked(ScheduleFile, read_toml(path), path)
    with blaming(path):
        return GainSchedule(
            name=path.stem,
            speed_mps=tuple(entry.speed_mps),
            offset_m=tuple(entry.offset_m),
            friction=tuple(entry.friction),
            a_per_m=_even("a_per_m", entry.a_per_m),
            b=_even("b", entry.b),
            y_max_m=_even("y_max_m", entry.y_max_m),
            length_m=_even("length_m", entry.length_m),
        )


def _even(name: str, table: Table) -> Array:
    try:
        return np.array(table)
    except ValueError:
        raise ParameterError(name, table, "must have rows of one length") from None


def schedule_of(vehicle: str) -> GainSchedule:
    """The vehicle's own schedule where one is shipped, else the sedan's: the bound on lateral acceleration holds for any car."""
    return load_schedule(vehicle if vehicle in shipped("tuned") else DEFAULT)
