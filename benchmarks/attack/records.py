"""Every public record of the package that has rules, found by itself, with sound values of the fields that must be given."""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
from enum import Enum
from functools import cache
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

import mcdas_opt
from mcdas_opt import Coverage, HostState, RadarDetection, Road, Scan, Sector, Situation, Track
from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.measurement import BodyDetection
from mcdas_opt.domain.parking import ParallelSlot, ParkingCase
from mcdas_opt.domain.sensor import Beam, Sensor
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.esr_codec import EsrCodec
from mcdas_opt.interop.recordings.csv_table import CsvTable
from mcdas_opt.reference.offset_path import OffsetPath
from mcdas_opt.simulation.recorded import RecordedMotion
from mcdas_opt.simulation.scripted import HeadedMotion
from mcdas_opt.tuning.search_space import Range
from mcdas_opt.tuning.study import StudySpec

HOST = HostState(speed_mps=20.0)
_PACKAGE = Path(mcdas_opt.__file__).parent
_NOT_FROZEN: tuple[type, ...] = (GripMonitor, EsrCodec, CsvTable)  # doors as records are
_SERIES = ("t_s", "s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad", "steering_rate_radps", "jerk_mps3")
_BENT = Road(curvature=((0.0, 0.0), (50.0, 0.01)))
_PLAIN: dict[Any, Any] = {float: 1.0, int: 1, str: "x", bool: False, Path: Path(), np.ndarray: (0.0, 0.1)}
_GIVEN: dict[type, dict[str, Any]] = {  # where a type's plain value is not sound, or no value of traffic
    Situation: {"host": HOST, "coverage": Coverage()},
    Track: {"id": "f", "s_m": 60.0, "d_m": 0.0, "speed_s_mps": 15.0},
    Scan: {"sensor": "esr", "sector": Sector.FRONT, "t_s": 0.0},
    RadarDetection: {"range_m": 30.0, "azimuth_rad": 0.0, "range_rate_mps": -5.0},
    BodyDetection: {"name": "x", "s_m": 30.0, "d_m": 0.0, "speed_s_mps": 10.0, "speed_d_mps": 0.0, "length_m": 4.5, "width_m": 1.8},
    Body: {"s_m": 30.0},
    Beam: {"name": "long", "range_max_m": 174.0, "half_angle_rad": 0.17},
    Sensor: {"range_min_m": 0.5},
    Destination: {"lane": 0},
    SigmoidDesign: {"a_per_m": -0.2, "b": 3.0, "y_max_m": 3.7},
    OffsetPath: {"a_per_m": -0.2, "b": 3.0},
    GainSchedule: {
        "speed_mps": (10.0,), "offset_m": (0.0,), "friction": (0.9,), "a_per_m": [[[-0.2]]], "b": [[[3.0]]], "y_max_m": [[[3.7]]],
        "length_m": [[[30.0]]],
    },
    ParallelSlot: {"length_m": 5.4},
    ParkingCase: {"start": (6.0, 1.4, 0.0), "goal": (1.35, -1.05, 0.0)},
    Trajectory: dict.fromkeys(_SERIES, (0.0, 0.1)),
    CsvTable: {"path": models_folder() / "logs" / "front_and_rear.host.csv"},
    FrenetFrame: {"road": _BENT},
    RecordedMotion: {"road": _BENT, "samples": ((0.0, 0.0, 0.0, 0.0, 10.0), (1.0, 10.0, 0.0, 0.0, 10.0))},
    HeadedMotion: {"road": _BENT},
    Range: {"name": "cost.jerk", "low": 0.1},
    Chassis: {"wheelbase_m": 2.7},
    StudySpec: {"scenes": (load_scene("sandwich-60-40"),)},
}  # fmt: skip


@cache
def records() -> tuple[type, ...]:
    """Those of modules that can be imported: some need an extra."""
    found: list[type] = [*_NOT_FROZEN]
    for path in sorted(_PACKAGE.rglob("*.py")):
        if "def __post_init__" not in path.read_text(encoding="utf-8"):
            continue
        name = ".".join(path.relative_to(_PACKAGE.parent).with_suffix("").parts)
        with contextlib.suppress(ImportError):
            module = importlib.import_module(name)
            found += [made for made in vars(module).values() if _is_record(made) and made.__module__ == name and made not in found]
    return tuple(found)


def _is_record(made: object) -> bool:
    """A public frozen dataclass with rules of its own."""
    return (
        isinstance(made, type)
        and dataclasses.is_dataclass(made)
        and made.__dataclass_params__.frozen
        and "__post_init__" in vars(made)
        and not made.__name__.startswith("_")
    )


@cache
def needed(record: type) -> dict[str, Any]:
    """Sound values of the fields that have no default."""
    hints, given = get_type_hints(record), _GIVEN.get(record, {})
    must = [field.name for field in fields(record) if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING]
    return {**{name: _plain(hints[name]) for name in must if name not in given}, **given}


def fields(record: type) -> list[dataclasses.Field[Any]]:
    """Those that its constructor takes."""
    return [field for field in dataclasses.fields(record) if field.init]


def _plain(hint: Any) -> Any:
    kind = get_origin(hint) or hint
    if kind in (Union, UnionType):
        return _plain(get_args(hint)[0])
    if kind is tuple:
        return tuple(_plain(part) for part in get_args(hint) if part is not Ellipsis)
    if kind in _PLAIN or not isinstance(kind, type):  # an alias: numpy's of an array, from 2.4 on
        return _PLAIN.get(kind, _PLAIN[np.ndarray])
    return next(iter(kind)) if issubclass(kind, Enum) else kind(**needed(kind))
