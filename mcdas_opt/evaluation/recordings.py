"""Recorded traffic as scenes: the car ahead as it drove, the host in the place of the one between, the car behind as a driver who reacts.

What was recorded is read from a folder that the user names; nothing of it is part of this package.
"""

from __future__ import annotations

import math
import os
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from mcdas_opt.catalogue.data_files import read_json, read_text
from mcdas_opt.catalogue.part import Part
from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.rules import Array, all_finite
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.manoeuvres import speed_script

_STEP_S = 0.1
_LONGEST_S = 3600.0  # of a triple
_LEAST_GAP_M = 0.5
_MOVES_MPS = 1.0
_CARS = 5  # of the platoon


class Recordings(Part):
    """The [recorded] table: which files below the user's folder, cut into windows; who follows reacts after `reaction_s`."""

    platoon: Annotated[str | None, Field(description="files below --data, as a glob: tables of t, vehK_x, vehK_y, vehK_v")] = None
    triples: Annotated[
        str | None, Field(description="file below --data: a JSON object whose `triples` is a list of rear, host and front")
    ] = None
    window_s: Annotated[Annotated[float, Field(ge=2.0)], Field(description="length of a scene")] = 20.0
    every_s: Annotated[Annotated[float, Field(ge=1.0)], Field(description="from one scene's start to the next one's")] = 20.0
    vehicle: Annotated[str, Field(description="a shipped vehicle or a path")] = "sedan"
    friction: Annotated[Annotated[float, Field(gt=0.0, le=1.5)], Field(description="of the road")] = 0.9
    reaction_s: Annotated[Annotated[float, Field(ge=0.0)], Field(description="of who follows the host")] = 1.0
    desired_mps: Annotated[Annotated[float, Field(gt=0.0)], Field(description="the host's desired speed, at least")] = 15.6
    sensors: Annotated[dict[str, Any], Field(description="as in a scene")] = Field(default_factory=dict)

    def scenes(self, folder: Path | None, seed: int) -> tuple[tuple[str, Scene], ...]:
        """(family, scene) of every window in the order of files and times. Raises `InputError` where the folder lacks a file."""
        if folder is None:
            raise InputError("--data", "", None, "this suite reads recordings: name the folder that holds them")
        found = [*self._platoon_scenes(folder, seed), *self._triple_scenes(folder, seed)]
        if not found:
            raise InputError(folder, "", None, "holds no window that could be a scene")
        return tuple(found)

    def _platoon_scenes(self, folder: Path, seed: int) -> Iterator[tuple[str, Scene]]:
        if self.platoon is None:
            return
        paths = sorted(folder.glob(self.platoon))
        if not paths:
            raise InputError(folder, "", None, f"holds no {self.platoon}")
        length = load_vehicle(self.vehicle).length_m
        for path in paths:
            table = _table(path)
            for start in np.arange(0.0, float(table["t"][-1]) - self.window_s, self.every_s):
                t = start + np.arange(0.0, self.window_s + 1e-9, _STEP_S)
                for host in range(2, _CARS):
                    front, middle, rear = (np.interp(t, table["t"], table[f"veh{k}_v"]) for k in (host - 1, host, host + 1))
                    window = _Window(
                        name=f"platoon-{path.stem}-{host}-{start:g}",
                        gap_front_m=_apart(table, host, host - 1, float(start)) - length,
                        gap_rear_m=_apart(table, host, host + 1, float(start)) - length,
                        length_front_m=length,
                        length_rear_m=length,
                        front_mps=front,
                        host_mps=middle,
                        rear_mps=rear,
                    )
                    if window.can_be:
                        yield "platoon", self._scene(window, seed)

    def _triple_scenes(self, folder: Path, seed: int) -> Iterator[tuple[str, Scene]]:
        if self.triples is None:
            return
        path = folder / self.triples
        if not os.path.isfile(path):
            raise InputError(folder, "", None, f"holds no {self.triples}")
        document = read_json(path)
        if not isinstance(document, dict) or not isinstance(document.get("triples"), list):
            raise InputError(path, "triples", None, 'must be a list in an object: {"triples": [...]}')
        for number, triple in enumerate(document["triples"]):
            try:
                front, host, rear = _resampled(triple)
                lengths = {who: float(triple["dims"][who][0]) for who in ("front", "host", "rear")}
            except (KeyError, TypeError, ValueError) as error:
                raise InputError(path, f"triples[{number}]", None, f"is no triple: {error}") from None
            window = _Window(
                name=f"us101-{number}",
                gap_front_m=float(np.hypot(*(front[0, :2] - host[0, :2]))) - 0.5 * (lengths["front"] + lengths["host"]),
                gap_rear_m=float(np.hypot(*(rear[0, :2] - host[0, :2]))) - 0.5 * (lengths["rear"] + lengths["host"]),
                length_front_m=lengths["front"],
                length_rear_m=lengths["rear"],
                front_mps=front[:, 3],
                host_mps=host[:, 3],
                rear_mps=rear[:, 3],
            )
            if window.can_be:
                yield "us101", self._scene(window, seed)

    def _scene(self, window: _Window, seed: int) -> Scene:
        half = 0.5 * load_vehicle(self.vehicle).length_m
        speeds = _drivable(np.maximum(window.front_mps, 0.0), self.friction * GRAVITY_MPS2)
        times = [round(k * _STEP_S, 9) for k in range(len(speeds))]
        front = {
            "name": "front",
            "s_m": half + window.gap_front_m + 0.5 * window.length_front_m,
            "speed_mps": speeds[0],
            "length_m": window.length_front_m,
            "motion": speed_script(times, speeds),
        }
        rear = {
            "name": "rear",
            "s_m": -half - window.gap_rear_m - 0.5 * window.length_rear_m,
            "speed_mps": max(float(window.rear_mps[0]), 0.0),
            "length_m": window.length_rear_m,
            "behaviour": "idm",
            "reaction_s": self.reaction_s,
        }
        begins = max(float(window.host_mps[0]), 0.0)
        document = {
            "name": window.name,
            "duration_s": times[-1],
            "seed": int(np.random.SeedSequence(entropy=seed, spawn_key=(zlib.crc32(window.name.encode()),)).generate_state(1)[0]),
            "road": {"friction": self.friction},
            "host": {
                "vehicle": self.vehicle,
                "speed_mps": begins,
                "desired_speed_mps": max(self.desired_mps, float(window.host_mps.max())),
            },
            "neighbour": [front, rear],
            "sensors": dict(self.sensors),
        }
        return scene_from_document(document, Path(f"{window.name}.toml"))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Window:
    """A stretch of a recording: gaps bumper to bumper at its start, and speeds every 0.1 s."""

    name: str
    gap_front_m: float
    gap_rear_m: float
    length_front_m: float
    length_rear_m: float
    front_mps: Array
    host_mps: Array
    rear_mps: Array

    @property
    def can_be(self) -> bool:
        """Not where the places put the cars into one another, nor where the host hardly moves."""
        return min(self.gap_front_m, self.gap_rear_m) >= _LEAST_GAP_M and float(self.host_mps.max()) >= _MOVES_MPS


def _resampled(triple: Any) -> tuple[Array, ...]:
    """(n, 4) x, y, heading, speed of front, host and rear every 0.1 s, from samples that are `dt` apart. Raises what a triple that is none
    leads to."""
    if not isinstance(triple, dict):
        raise TypeError("must be an object with front, host, rear and dims")
    step = float(triple.get("dt", _STEP_S))
    bodies = [np.array(triple[who], dtype=np.float64) for who in ("front", "host", "rear")]
    if not 0.0 < step < math.inf:
        raise ValueError(f"dt = {step:g} must be positive")
    if any(body.ndim != 2 or body.shape[1] < 4 or not all_finite(body) for body in bodies):
        raise ValueError("front, host and rear must be rows of four finite numbers")
    if {len(body) for body in bodies} != {len(bodies[0])} or len(bodies[0]) < 2:
        raise ValueError("front, host and rear must have as many rows, at least two")
    t = step * np.arange(len(bodies[0]))
    steps = t[-1] / _STEP_S + 1e-6
    if not 1.0 <= steps <= _LONGEST_S / _STEP_S:
        raise ValueError(f"lasts {t[-1]:g} s: must last at least {_STEP_S:g} s and at most {_LONGEST_S:g} s")
    at = _STEP_S * np.arange(int(steps) + 1)
    return tuple(np.column_stack([np.interp(at, t, column) for column in body.T]) for body in bodies)


def _table(path: Path) -> dict[str, Array]:
    """The columns of a platoon's CSV, t counted from its first moment. Raises `InputError` for a missing column, a cell that is no number,
    or a time that does not increase."""
    lines = [line.split(",") for line in read_text(path).splitlines() if line.strip()]
    names = [name.strip() for name in lines[0]] if lines else []
    wanted = ("t", *(f"veh{k}_{c}" for k in range(1, _CARS + 1) for c in "xyv"))
    for name in wanted:
        if name not in names:
            raise InputError(path, "line 1", None, f"missing column {name}")
    if len(lines) < 3:
        raise InputError(path, "", None, "needs at least two rows")
    for number, line in enumerate(lines[1:], start=1):
        if len(line) != len(names):
            raise InputError(path, f"row {number}", ",".join(line), f"must have {len(names)} cells, as the header has")
    try:
        values = np.array([[float(cell) for cell in line] for line in lines[1:]])
    except ValueError as error:
        raise InputError(path, "", None, f"holds a cell that is no number: {error}") from None
    table = {name: values[:, names.index(name)] for name in wanted}
    for name, column in table.items():
        if not all_finite(column):
            raise InputError(path, name, None, "must be finite numbers")
    back = np.flatnonzero(np.diff(table["t"]) <= 0.0)
    if back.size:
        raise InputError(path, f"row {back[0] + 2}: t", float(table["t"][back[0] + 1]), "must increase")
    return table | {"t": table["t"] - table["t"][0]}


def _apart(table: dict[str, Array], one: int, other: int, t_s: float) -> float:
    """Distance of two antennas at a time."""
    x, y = (
        float(np.interp(t_s, table["t"], table[f"veh{one}_{c}"]) - np.interp(t_s, table["t"], table[f"veh{other}_{c}"])) for c in ("x", "y")
    )
    return float(np.hypot(x, y))


def _drivable(speeds_mps: Array, grip_mps2: float) -> list[float]:
    """The speeds, changing no faster than tyres allow: recorded positions jump now and then."""
    found = [float(speeds_mps[0])]
    most = 0.98 * grip_mps2 * _STEP_S
    for speed in speeds_mps[1:]:
        found.append(float(np.clip(speed, found[-1] - most, found[-1] + most)))
    return found
