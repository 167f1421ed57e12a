"""Motion files: the process noise of a kind of target."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from mcdas_opt.catalogue.data_files import checked, find, read_toml, shipped
from mcdas_opt.domain.motion import TargetMotion
from mcdas_opt.errors import InputError, ParameterError

NUMBERS = ("acceleration_along_mps2", "acceleration_across_mps2")


class MotionFile(BaseModel):
    """The keys of a motion file; `sources` says of every number where it comes from."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    description: Annotated[str, Field(description="what moves so")] = ""
    acceleration_along_mps2: Annotated[float, Field(description="standard deviation along the road, white between updates")]
    acceleration_across_mps2: Annotated[float, Field(description="the same across the road")]
    sources: Annotated[dict[str, str], Field(min_length=1, description="where each number comes from")]

    @model_validator(mode="after")
    def _every_number_has_a_source(self) -> Self:
        for name in NUMBERS:
            if not self.sources.get(name, "").strip():
                raise ValueError(f"sources.{name}: missing key (every number says where it comes from)")
        return self


def load_motion(name: str, beside: Path | None = None) -> TargetMotion:
    """The motion behind a shipped name or a path. Raises `InputError` that names the file, the key and the known motions."""
    try:
        path = find("motion", name, beside=beside)
    except InputError:
        known = ", ".join(shipped("motion"))
        raise InputError(name, "", None, f"no such file, and no target motion of that name; known: {known}") from None
    entry = checked(MotionFile, read_toml(path), path)
    try:
        return TargetMotion(name=path.stem, **entry.model_dump(include=set(NUMBERS)))
    except ParameterError as error:
        raise InputError(path, error.name, error.value, error.rule) from None
