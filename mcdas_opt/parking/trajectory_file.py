"""Parking trajectories from files: the contract's JSON and CSV, and the tables that TPCAP entrants publish."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.catalogue.data_files import find, finite_cell, read_json, read_text
from mcdas_opt.domain.parking import ParkingTrajectory
from mcdas_opt.errors import InputError, blaming, nearest

COLUMNS = ("t_s", "x_m", "y_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad", "steering_rate_radps")
_NEEDED = ("t_s", "x_m", "y_m", "heading_rad", "speed_mps", "steering_rad")
_PUBLISHED = {"x": "x_m", "y": "y_m", "theta": "heading_rad", "v": "speed_mps", "sigma": "steering_rad", "t": "t_s"}


def load_parking_trajectory(name: str | Path) -> ParkingTrajectory:
    """A trajectory in the file's own coordinates: `.json` (a trajectory, or a document with the key `trajectory`) or a table.

    In a published TPCAP table (columns x, y, theta, v, sigma, t) row k's `t` is the time of row k + 1, and row 0 is the start.
    """
    path = find("cases", str(name))
    if path.suffix.lower() == ".json":
        return _from_json(path)
    columns = _table(path)
    if "theta" in columns:
        columns = {_PUBLISHED[key]: value for key, value in columns.items() if key in _PUBLISHED}
        columns["t_s"] = [0.0, *columns["t_s"][:-1]]
    return _built(columns, path)


def _from_json(path: Path) -> ParkingTrajectory:
    document = read_json(path)
    if isinstance(document, dict) and isinstance(document.get("trajectory"), dict):
        document = document["trajectory"]
    if not isinstance(document, dict):
        raise InputError(path, "trajectory", None, "must be an object of columns")
    for key in document:
        if key not in COLUMNS and key != "schema_version":
            raise InputError(path, f"trajectory.{key}", None, f"unknown key; {nearest(key, COLUMNS)}")
    return _built({key: value for key, value in document.items() if key in COLUMNS}, path)


def _built(columns: dict[str, Any], path: Path) -> ParkingTrajectory:
    for key in _NEEDED:
        if key not in columns:
            raise InputError(path, key, None, "missing column")
    try:
        arrays = {key: np.array(value, dtype=np.float64) for key, value in columns.items()}
    except (TypeError, ValueError):
        raise InputError(path, "trajectory", None, "columns must be lists of numbers") from None
    size = arrays["t_s"].shape
    for key, value in arrays.items():
        if value.ndim != 1 or value.shape != size:
            raise InputError(path, key, f"shape {value.shape}", f"must be a list of {size[0] if size else 0} numbers, as t_s")
        if not np.all(np.isfinite(value)):
            raise InputError(path, key, None, "must be finite")
    with blaming(path):
        return ParkingTrajectory.from_columns(arrays)


def _table(path: Path) -> dict[str, list[float]]:
    lines = read_text(path).splitlines()
    if not lines:
        raise InputError(path, "line 1", None, "must be a header")
    separator = "\t" if "\t" in lines[0] else ","
    header = [part.strip() for part in lines[0].split(separator)]
    columns: dict[str, list[float]] = {name: [] for name in header}
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        parts = line.split(separator)
        if len(parts) != len(header):
            raise InputError(path, f"line {number}", None, f"has {len(parts)} columns, the header has {len(header)}")
        for column, (name, part) in enumerate(zip(header, parts, strict=True), start=1):
            columns[name].append(finite_cell(part, path, f"line {number}, column {column} ({name})"))
    return columns
