"""A table of a file: what all of them have in common."""

from __future__ import annotations

from typing import Annotated, ClassVar, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from mcdas_opt.domain.rules import FARTHEST_M, FASTEST_MPS
from mcdas_opt.errors import nearest

Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Place = Annotated[float, Field(ge=-FARTHEST_M, le=FARTHEST_M)]
Speed = Annotated[float, Field(ge=0.0, le=FASTEST_MPS)]
Acceleration = Annotated[float, Field(ge=-1e3, le=1e3)]
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]


class Part(BaseModel):
    """No key that is not known, no number that is not finite. `KIND` is what a file of it is called in messages."""

    KIND: ClassVar[str] = ""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


class SourcedFile(Part):
    """A file that says of every one of its NUMBERS where it comes from."""

    NUMBERS: ClassVar[tuple[str, ...]] = ()

    sources: Annotated[dict[str, str], Field(description="where each number comes from")]

    @model_validator(mode="after")
    def _every_number_has_a_source(self) -> Self:
        for name in self.sources:
            if name not in self.NUMBERS:
                raise ValueError(f"sources.{name}: names no number of this file; {nearest(name, self.NUMBERS)}")
        for name in self.NUMBERS:
            if not self.sources.get(name, "").strip():
                raise ValueError(f"sources.{name}: missing key (every number says where it comes from)")
        return self

    def numbers(self) -> dict[str, float]:
        """The numbers by name."""
        return self.model_dump(include=set(self.NUMBERS))
