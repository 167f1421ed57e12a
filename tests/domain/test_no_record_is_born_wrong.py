"""No record that somebody fills in takes a number that is none, or one that makes no sense: looked for in every module of the package."""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mcdas_opt
from mcdas_opt.domain.actuator_response import ActuatorResponse
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.motion import TargetMotion
from mcdas_opt.domain.parking import ParallelSlot
from mcdas_opt.domain.sensor import Beam, Sensor
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.track import Track
from mcdas_opt.errors import McdasError, MissingExtraError
from mcdas_opt.tuning.search_space import Range

FILLED_BY_US = {  # results, and what is counted or carried on while something runs: nobody hands them in
    *("Account", "AccelerationFilter", "Assessment", "CycleTimes", "Drops", "Escape", "Escapes", "LaneChoice", "LqrTracking", "Memory"),
    *("OrdinaryDriving", "PassedInLane", "Searched", "SteadyLaw", "SumoSummary", "Timing", "TurnRateFilter"),
}
GATED = {"Mounting", "RadarDetection", "BodyDetection"}  # they come with a scan, whose faults the tracker sorts out and counts
SIGNED = {  # may be less than 0
    "acceleration_d_mps2",
    *("acceleration_min_mps2", "acceleration_mps2", "acceleration_s_mps2", "a_per_m", "aside_m", "clear_m", "d_m", "heading_rad"),
    *(
        "host_speed_share",
        "host_yaw_rate_radps",
        "jerk_min_mps3",
        "lane",
        "lateral_speed_mps",
        "low",
        "high",
        "offset_m",
        "road_end_s_m",
        "s_m",
    ),
    *("speed_d_mps", "speed_mps", "speed_s_mps", "steering_rad", "turn_rate_radps", "yaw_rad", "yaw_rate_radps", "rotation_rad"),
}
EXAMPLES = (
    ActuatorResponse(),
    Beam(name="wide", range_max_m=60.0, half_angle_rad=0.7),
    Body(name="x", s_m=0.0),
    Destination(lane=1),
    Lane(lane=1),
    ParallelSlot(length_m=6.0),
    Range(name="cost.nearness", low=1.0, high=2.0),
    SigmoidDesign(a_per_m=-0.2, b=40.0, y_max_m=3.7),
    Sensor(
        name="radar",
        beams=(Beam(name="wide", range_max_m=60.0, half_angle_rad=0.7),),
        range_min_m=1.0,
        rate_hz=20.0,
        range_sd_m=0.1,
        azimuth_sd_rad=0.01,
        range_rate_sd_mps=0.1,
    ),
    TargetMotion(name="car", acceleration_along_mps2=1.0, acceleration_across_mps2=0.5),
    Track(id="front", s_m=30.0, d_m=0.0, speed_s_mps=10.0),
)


def defaults() -> Iterator[Any]:
    """Every record of the package that can be made of its defaults alone."""
    root = Path(mcdas_opt.__file__).parent
    for path in sorted(root.rglob("*.py")):
        name = ".".join(("mcdas_opt", *path.relative_to(root).with_suffix("").parts)).removesuffix(".__init__")
        if path.stem in ("__main__", "build_hook"):  # the command; what hatchling loads while it builds
            continue
        try:
            found = vars(importlib.import_module(name)).values()
        except ImportError as error:
            if not isinstance(error, MissingExtraError) and (error.name or "").startswith("mcdas_opt"):
                raise
            continue  # an extra is not here
        for kind in found:
            if not isinstance(kind, type) or not dataclasses.is_dataclass(kind) or kind.__module__ != name:
                continue
            if kind.__name__.startswith("_") or kind.__name__ in FILLED_BY_US | GATED:
                continue
            given = {type(example) for example in EXAMPLES}
            missing = dataclasses.MISSING
            if kind not in given and all(f.default is not missing or f.default_factory is not missing for f in dataclasses.fields(kind)):
                with contextlib.suppress(MissingExtraError):
                    yield kind()


RECORDS = tuple({type(record): record for record in (*EXAMPLES, *defaults())}.values())


def numbers(record: Any) -> list[tuple[str, bool]]:
    """Names of the fields that are numbers, and whether they are whole."""
    kinds = {"float": False, "float | None": False, "int": True, "int | None": True}
    return [(f.name, kinds[str(f.type)]) for f in dataclasses.fields(record) if f.init and str(f.type) in kinds]


def test_the_settings_are_among_them() -> None:
    names = {type(record).__name__ for record in RECORDS}
    assert {"Settings", "SelectorSettings", "CostWeights", "SolverSettings", "Tolerances", "ParkSettings", "FollowSettings"} <= names
    assert sum(len(numbers(record)) for record in RECORDS) > 200


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
def test_nonsense_is_refused(record: Any) -> None:
    for name, is_whole in numbers(record):
        for nonsense in (math.nan, math.inf, -math.inf, "1", True, np.array([1.0, 2.0])):
            with pytest.raises(McdasError):
                dataclasses.replace(record, **{name: nonsense})
        if name not in SIGNED:
            with pytest.raises(McdasError):
                dataclasses.replace(record, **{name: -1 if is_whole else -1.0})
