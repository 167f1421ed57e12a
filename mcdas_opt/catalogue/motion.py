"""Motion files: the process noise of a kind of target."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mcdas_opt.catalogue.data_files import checked, find, read_toml, shipped
from mcdas_opt.catalogue.part import SourcedFile
from mcdas_opt.domain.motion import TargetMotion
from mcdas_opt.errors import InputError, blaming


class MotionFile(SourcedFile):
    """The keys of a motion file; `sources` says of every number where it comes from."""

    NUMBERS = ("acceleration_along_mps2", "acceleration_across_mps2")

    description: Annotated[str, Field(description="what moves so")] = ""
    acceleration_along_mps2: Annotated[float, Field(description="standard deviation along the road, white between updates")]
    acceleration_across_mps2: Annotated[float, Field(description="the same across the road")]


def load_motion(name: str) -> TargetMotion:
    """The motion behind a shipped name or a path. Raises `InputError` that names the file, the key and the known motions."""
    try:
        path = find("motion", name)
    except InputError:
        known = ", ".join(shipped("motion"))
        raise InputError(name, "", None, f"no such file, and no target motion of that name; known: {known}") from None
    entry = checked(MotionFile, read_toml(path), path)
    with blaming(path):
        return TargetMotion(name=path.stem, **entry.numbers())
