"""Gain schedules of the sigmoid: `models/tuned`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from mcdas_opt.catalogue.data_files import checked, find, read_toml, shipped
from mcdas_opt.catalogue.part import Part
from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import ParameterError, blaming

Table = list[list[list[float]]]
DEFAULT = "sedan"


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
