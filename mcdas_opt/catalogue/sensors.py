"""Sensor files. "ideal" and "none" are words of a scene, not files."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Annotated, ClassVar

from pydantic import Field

from mcdas_opt.catalogue.data_files import checked, find, read_toml, shipped
from mcdas_opt.catalogue.part import Part, SourcedFile
from mcdas_opt.domain.sensor import Beam, Sensor
from mcdas_opt.errors import InputError, blaming, reading

IDEAL = "ideal"  # body centre and velocity of every neighbour in the sector
NONE = "none"  # nobody watches the sector


class BeamPart(Part):
    name: Annotated[str, Field(description="of the beam")]
    range_max_m: Annotated[float, Field(description="farthest that it sees")]
    half_angle_rad: Annotated[float, Field(description="half its field of view")]
    source: Annotated[str, Field(min_length=1, description="where these come from")]


class SensorFile(SourcedFile):
    """The keys of a sensor file; `sources` says of every number where it comes from."""

    KIND: ClassVar[str] = "sensor"

    NUMBERS = ("range_min_m", "rate_hz", "range_sd_m", "azimuth_sd_rad", "range_rate_sd_mps", "detection_probability")

    description: Annotated[str, Field(description="what it is")] = ""
    beam: Annotated[list[BeamPart], Field(min_length=1, description="its beams")]
    range_min_m: Annotated[float, Field(description="nearest that it sees")]
    rate_hz: Annotated[float, Field(description="scans a second")]
    range_sd_m: Annotated[float, Field(description="standard deviation of range")]
    azimuth_sd_rad: Annotated[float, Field(description="standard deviation of azimuth")]
    range_rate_sd_mps: Annotated[float, Field(description="standard deviation of range rate")]
    detection_probability: Annotated[float, Field(description="of a body in view, each scan")]


def known_sensors() -> tuple[str, ...]:
    """The shipped sensors and the words for a perfect one and for nobody."""
    return (*shipped("sensors"), IDEAL, NONE)


def load_sensor(name: str | Path, beside: Path | None = None) -> Sensor:
    """The radar behind a shipped name or a path. Raises `InputError` that names the file, the key and the known sensors."""
    path = _find(str(name), beside)
    with reading(path):
        found = path.stat()
    return _read(path, found.st_ino, found.st_mtime_ns, found.st_size)


@lru_cache(maxsize=64)
def _read(path: Path, *_: int) -> Sensor:
    """Once as long as the file stays as it is: a scene's are asked for at each of its edits."""
    entry = checked(SensorFile, read_toml(path), path)
    with blaming(path):
        beams = tuple(Beam(name=b.name, range_max_m=b.range_max_m, half_angle_rad=b.half_angle_rad) for b in entry.beam)
        return Sensor(name=path.stem, beams=beams, **entry.numbers())


def _find(name: str, beside: Path | None) -> Path:
    if name in (IDEAL, NONE):
        raise InputError(name, "", None, "is a word of a scene's [sensors], not a sensor file")
    try:
        return find("sensors", name, beside=beside)
    except InputError:
        if "/" in name or name.endswith(".toml"):
            raise
        known = ", ".join(known_sensors())
        raise InputError(name, "", None, f"no such file, and no sensor of that name; known: {known}") from None
