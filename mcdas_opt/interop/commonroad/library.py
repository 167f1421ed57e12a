"""The one version of commonroad-io that this door was built for, and a file that is safe to hand to it."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.errors import InputError, MissingExtraError, reading

PACKAGE, PIN = "commonroad-io", "2024.3"  # 2026.1 removed what its own drivability checker needs
LARGEST_BYTES = 100_000_000
LONGEST_LANELET_M = 20_000.0  # its line is sampled every metre


def require() -> None:
    """Raises `MissingExtraError` without the package, `InputError` that names the pin for any other version of it."""
    try:
        found = version(PACKAGE)
    except PackageNotFoundError:
        raise MissingExtraError(PACKAGE, "commonroad") from None
    if found != PIN:
        raise InputError(PACKAGE, "version", found, f"must be {PIN}: pip install 'mcdas-opt[commonroad]'")


def read_file(path: Path) -> tuple[Any, Any]:
    """(scenario, planning problems) of a CommonRoad XML. Raises `InputError` for a file that is none, or plays tricks with entities."""
    require()
    try:
        from commonroad.common.file_reader import CommonRoadFileReader
        from commonroad.common.util import FileFormat
        from defusedxml import DefusedXmlException
        from defusedxml.ElementTree import ParseError, iterparse
    except ImportError as error:
        raise MissingExtraError(error.name or PACKAGE, "commonroad") from None
    try:
        with reading(path):
            size = path.stat().st_size
            if size > LARGEST_BYTES:
                raise InputError(path, "size", size, f"must be at most {LARGEST_BYTES} bytes")
            root = ""
            with path.open("rb") as file:
                for _, element in iterparse(file, events=("start",)):
                    root = root or element.tag
        if root != "commonRoad":
            raise InputError(path, "root element", root, "must be commonRoad")
    except (ParseError, DefusedXmlException) as error:
        raise InputError(path, "", None, f"is no XML that is safe to read: {error!r}") from None
    try:
        scenario, problems = CommonRoadFileReader(str(path), FileFormat.XML).open(lanelet_assignment=False)
    except Exception as error:  # the reader raises whatever its parsing meets
        raise InputError(path, "", None, f"is no CommonRoad scenario: {type(error).__name__}: {error}") from None
    for lanelet in scenario.lanelet_network.lanelets:
        extent_m = float(np.ptp(np.vstack([lanelet.left_vertices, lanelet.right_vertices]), axis=0).max())
        if not extent_m <= LONGEST_LANELET_M:
            raise InputError(path, f"lanelet {lanelet.lanelet_id}", f"{extent_m:g} m", f"must be at most {LONGEST_LANELET_M:g} m long")
    return scenario, problems
