"""Families of scenes: ranges as data, expanded into scenes by a tree of seeds."""

from __future__ import annotations

import zlib
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.catalogue.shelf import checked, read_toml
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.errors import InputError, nearest

_LENGTH_M = 4.5  # of a neighbour
_APART_M = 1.0  # bumper to bumper at the start, at least
_DRAWS = 200
_TOP_MPS = 45.0


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


class Spread(_Part):
    """Where a number comes from: evenly between low and high, or one of a list."""

    low: float | None = None
    high: float | None = None
    one_of: Annotated[list[float], Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if (self.one_of is None) == (self.low is None or self.high is None):
            raise ValueError("needs low and high, or one_of")
        if self.low is not None and self.high is not None and self.high < self.low:
            raise ValueError("high must be at least low")
        return self


Number = float | int | Spread


class RoadSpread(_Part):
    lane_width_m: Number = 3.7
    friction: Number = 0.9
    lanes_left: Number = 1
    lanes_right: Number = 1


class HostSpread(_Part):
    vehicle: str = "sedan"
    speed_mps: Number


class FrontSpread(_Part):
    """`braking_share` is the share of its speed that it brakes away; 1 is to a stop."""

    gap_m: Number | None = None
    headway_s: Number | None = None
    slower_mps: Number = 0.0
    braking_mps2: Number = 0.0
    braking_share: Number = 1.0

    @model_validator(mode="after")
    def _one_distance(self) -> Self:
        if (self.gap_m is None) == (self.headway_s is None):
            raise ValueError("needs gap_m or headway_s, not both")
        return self


class RearSpread(_Part):
    gap_m: Number | None = None
    headway_s: Number | None = None
    faster_mps: Number = 0.0
    braking_mps2: Number = 0.0
    after_s: Number = 1.5
    follows: bool = False

    @model_validator(mode="after")
    def _one_distance(self) -> Self:
        if (self.gap_m is None) == (self.headway_s is None):
            raise ValueError("needs gap_m or headway_s, not both")
        return self


class SideSpread(_Part):
    """Cars in each next lane there is: how many, how far ahead of the host, at which share of its speed."""

    cars: Number = 0
    ahead_m: Number = 0.0
    speed_ratio: Number = 1.0


class Family(_Part):
    """A family file of `benchmarks/suites`: the ranges that its scenes come from."""

    name: str
    duration_s: Annotated[float, Field(gt=0.0)] = 8.0
    event_s: Number = 0.0
    road: RoadSpread = RoadSpread()
    host: HostSpread
    front: FrontSpread | None = None
    rear: RearSpread | None = None
    side: SideSpread = SideSpread()
    sensors: dict[str, Any] = {}

    def scene(self, index: int, seed: int = 0) -> Scene:
        """Scene `index` of the family's tree under `seed`: the same whatever other scenes are expanded."""
        branch = np.random.SeedSequence(entropy=seed, spawn_key=(zlib.crc32(self.name.encode()), index))
        rng = np.random.default_rng(branch)
        document = _document(self, rng)
        document |= {"name": f"{self.name}-{seed}-{index}", "seed": int(branch.generate_state(1)[0])}
        return scene_from_document(document, Path(f"{self.name}-{seed}-{index}.toml"))

    def scenes(self, count: int, seed: int = 0, first: int = 0) -> tuple[Scene, ...]:
        return tuple(self.scene(index, seed) for index in range(first, first + count))


def load_family(name: str | Path) -> Family:
    """The family behind a path or a shipped name. Raises `InputError` that names file, key, value and rule."""
    path = Path(name)
    if not path.is_file():
        path = suites_folder() / f"{name}.toml"
        if not path.is_file():
            known = shipped_families()
            raise InputError(name, "", None, f"no such file, and no shipped suite of that name; {nearest(str(name), known)}")
    return checked(Family, read_toml(path), path)


def shipped_families() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in suites_folder().glob("*.toml")))


@lru_cache(maxsize=1)
def suites_folder() -> Path:
    """The packaged suites, else the checkout's."""
    package = Path(__file__).resolve().parent.parent
    for folder in (package / "_suites", package.parent / "benchmarks" / "suites"):
        if folder.is_dir():
            return folder
    raise InputError(package, "suites", None, "the data folder is missing: reinstall the package")


def _draw(number: Number, rng: np.random.Generator) -> float:
    """One number; a fixed one takes nothing from the generator."""
    if not isinstance(number, Spread):
        return float(number)
    if number.one_of is not None:
        return float(number.one_of[int(rng.integers(len(number.one_of)))])
    assert number.low is not None
    assert number.high is not None
    return float(rng.uniform(number.low, number.high))


def _document(family: Family, rng: np.random.Generator) -> dict[str, Any]:
    host_length = load_vehicle(family.host.vehicle).length_m
    between = 0.5 * (host_length + _LENGTH_M)
    road = {
        "lane_width_m": _draw(family.road.lane_width_m, rng),
        "friction": _draw(family.road.friction, rng),
        "lanes_left": int(_draw(family.road.lanes_left, rng)),
        "lanes_right": int(_draw(family.road.lanes_right, rng)),
    }
    speed = _draw(family.host.speed_mps, rng)
    event = _draw(family.event_s, rng)
    grip = road["friction"] * GRAVITY_MPS2
    neighbours: list[dict[str, Any]] = []
    if family.front is not None:
        v = max(speed - _draw(family.front.slower_mps, rng), 0.0)
        neighbours.append({"name": "front", "s_m": between + _distance(family.front, speed, rng), "speed_mps": v})
        neighbours[-1] |= _braking(_draw(family.front.braking_mps2, rng), grip, event, v * (1.0 - _draw(family.front.braking_share, rng)))
    if family.rear is not None:
        v = min(max(speed + _draw(family.rear.faster_mps, rng), 0.0), _TOP_MPS)
        neighbours.append({"name": "rear", "s_m": -between - _distance(family.rear, v, rng), "speed_mps": v})
        if family.rear.follows:
            neighbours[-1]["behaviour"] = "idm"
        else:
            neighbours[-1] |= _braking(_draw(family.rear.braking_mps2, rng), grip, event + _draw(family.rear.after_s, rng), 0.0)
    for name, sign, lanes in (("left", 1, road["lanes_left"]), ("right", -1, road["lanes_right"])):
        if lanes:
            neighbours += _beside(family.side, name, sign * road["lane_width_m"], speed, rng)
    return {
        "duration_s": family.duration_s,
        "road": road,
        "host": {"vehicle": family.host.vehicle, "speed_mps": speed},
        "neighbour": neighbours,
        "sensors": dict(family.sensors),
    }


def _distance(part: FrontSpread | RearSpread, speed_mps: float, rng: np.random.Generator) -> float:
    if part.gap_m is not None:
        return _draw(part.gap_m, rng)
    assert part.headway_s is not None
    return max(_draw(part.headway_s, rng) * speed_mps, 2.0)


def _braking(wanted_mps2: float, grip_mps2: float, start_s: float, until_mps: float) -> dict[str, Any]:
    """A script that brakes, never beyond the grip."""
    if wanted_mps2 == 0.0:
        return {}
    return {"motion": [{"start_s": start_s, "acceleration_mps2": -min(wanted_mps2, grip_mps2), "until_speed_mps": until_mps}]}


def _beside(side: SideSpread, name: str, d_m: float, speed_mps: float, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Cars in one lane that neither overlap now nor run through one another later: the one ahead is the faster."""
    count = int(_draw(side.cars, rng))
    for _ in range(_DRAWS):
        places = sorted(_draw(side.ahead_m, rng) for _ in range(count))
        if all(after - before >= _LENGTH_M + _APART_M for before, after in pairwise(places)):
            break
    else:
        places = places[:1]
    speeds = sorted(_draw(side.speed_ratio, rng) * speed_mps for _ in places)
    return [
        {"name": f"{name}-{i}", "s_m": s, "d_m": d_m, "speed_mps": v} for i, (s, v) in enumerate(zip(places, speeds, strict=True), start=1)
    ]
