"""Trajectory files: a CSV with the contract's columns, or a JSON document that holds them."""

from __future__ import annotations

import csv
import math
import os
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from mcdas_opt.catalogue.data_files import read_json, read_text
from mcdas_opt.domain.rules import require_type
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.errors import InputError, check_file_name, nearest

COLUMNS = tuple(field.name for field in fields(Trajectory))


@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectoryFile:
    """A trajectory that somebody wrote, the prediction that its plan was made with, and the followers that it relies on (None where the
    file names none)."""

    trajectory: Trajectory
    prediction: str | None = None
    relies_on: str | None = None


def load_trajectory(path: str | Path) -> TrajectoryFile:
    """From `.json` (a bare trajectory, or a whole document of `plan` or `simulate` that holds one) or else CSV.

    Every column of the contract is required, in any order. Raises `InputError` with file, line or key, and column where the file is
    malformed: unknown, missing or doubled columns, unequal lengths, cells that are no numbers. A number that is not finite (`nan`,
    `inf`; null in JSON) is let through: whether such a trajectory is sound is a verdict ('not finite'), not a question of the format.
    """
    require_type("path", path, str, Path)
    path = Path(path)
    check_file_name(path)
    if not os.path.isfile(path):
        raise InputError(path, "", None, "no such file")
    if path.suffix.lower() == ".json":
        return _from_document(read_json(path), path)
    return TrajectoryFile(trajectory=Trajectory.from_columns(_table(path)))


def _table(path: Path) -> dict[str, list[float]]:
    reader = csv.reader(read_text(path).removeprefix("\ufeff").splitlines())
    try:
        lines = [(reader.line_num, row) for row in reader]
    except csv.Error as error:
        raise InputError(path, f"line {reader.line_num}", None, f"is no CSV: {error}") from None
    header = [cell.strip() for cell in lines[0][1]] if lines else []
    _check_names(header, path, "line 1")
    columns: dict[str, list[float]] = {name: [] for name in header}
    for number, row in lines[1:]:
        if not any(cell.strip() for cell in row):
            continue
        line = f"line {number}"
        if len(row) != len(header):
            raise InputError(path, line, len(row), f"must have {len(header)} cells, as the header")
        for name, cell in zip(header, row, strict=True):
            try:
                columns[name].append(float(cell))
            except ValueError:
                raise InputError(path, f"{line}, column {name}", cell.strip(), "must be a number") from None
    if not columns["t_s"]:
        raise InputError(path, "", None, "holds no samples")
    return columns


def _from_document(document: Any, path: Path) -> TrajectoryFile:
    if not isinstance(document, dict):
        raise InputError(path, "", None, "must be an object")
    whole = "trajectory" in document
    columns = document["trajectory"] if whole else {k: v for k, v in document.items() if k != "schema_version"}
    at = "trajectory." if whole else ""
    if not isinstance(columns, dict):
        raise InputError(path, "trajectory", columns, "must be an object of columns")
    _check_names(list(columns), path, "trajectory" if whole else "")
    prediction = document.get("prediction") if whole else None
    if prediction is not None and not isinstance(prediction, str):
        raise InputError(path, "prediction", prediction, "must be text")
    end = document.get("safe_end") if whole else None
    relies_on = end.get("relies_on") if isinstance(end, dict) else None
    if relies_on is not None and not isinstance(relies_on, str):
        raise InputError(path, "safe_end.relies_on", relies_on, "must be text")
    read = {name: _numbers(values, path, f"{at}{name}") for name, values in columns.items()}
    for name, values in read.items():
        if len(values) != len(read["t_s"]):
            raise InputError(path, f"{at}{name}", len(values), f"must have {len(read['t_s'])} numbers, as t_s")
    if not read["t_s"]:
        raise InputError(path, f"{at}t_s", None, "holds no samples")
    return TrajectoryFile(trajectory=Trajectory.from_columns(read), prediction=prediction, relies_on=relies_on)


def _numbers(values: Any, path: Path, key: str) -> list[float]:
    if not isinstance(values, list):
        raise InputError(path, key, values, "must be a list of numbers")
    read: list[float] = []
    for i, value in enumerate(values):
        if value is None:
            value = math.nan
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(path, f"{key}[{i}]", value, "must be a number")
        try:
            read.append(float(value))
        except OverflowError:
            raise InputError(path, f"{key}[{i}]", None, "is too large a number") from None
    return read


def _check_names(names: list[str], path: Path, where: str) -> None:
    for name in names:
        if name not in COLUMNS:
            raise InputError(path, where, name, f"unknown column; {nearest(name, COLUMNS)}")
        if names.count(name) > 1:
            raise InputError(path, where, name, "stands twice")
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise InputError(path, where, None, f"missing column {missing[0]}")
