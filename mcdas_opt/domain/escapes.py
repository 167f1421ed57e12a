"""The escape map: which candidate manoeuvres are open, and until when (time to react)."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, ClassVar

from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.result import Columns, Result
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle


class Closer(StrEnum):
    """What closes a candidate."""

    FRONT = "front"
    REAR = "rear"
    SIDE = "side car"
    EDGE = "road edge"
    FRICTION = "friction"


@dataclass(frozen=True, slots=True, kw_only=True)
class Escape:
    """One candidate manoeuvre.

    `last_moment_s` is its time to react: the latest moment to command it, if the host keeps its acceleration and steering until then,
    earlier by what the vehicle's actuators take to answer; None when there is none, at most 10. `closed_by` ends it (None where nothing
    does within 10 s). `demand_mps2` is what it asks of the tyres when it begins now (the gentlest that was found); None when it cannot
    begin now. `last_comfortable_s` is the latest moment to command one that is comfortable; None when there is none.
    """

    open: bool = False
    last_moment_s: float | None = None
    closed_by: Closer | None = None
    demand_mps2: float | None = None
    last_comfortable_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Escapes(Result):
    """The four candidates: in the lane by braking or accelerating, into the next lane to the left or the right. Their last moments are the
    time to brake, the time to kickdown and the time to steer to either side; the greatest of them is the situation's time to react.

    `keeping_on_s` is when the constant-input prediction ends, `keeping_on_meets` what it ends at: somebody, or the road's edge; None where
    it does not end within 10 s.
    `situation` and `vehicle` are what was asked for, to draw it in.
    """

    drawn_by: ClassVar[str] = "mcdas_opt.plotting.time_to_react_timeline:time_to_react_sheet"

    brake: Escape = field(default_factory=Escape)
    accelerate: Escape = field(default_factory=Escape)
    left: Escape = field(default_factory=Escape)
    right: Escape = field(default_factory=Escape)
    keeping_on_s: float | None = field(default=None, repr=False)
    keeping_on_meets: Closer | None = field(default=None, repr=False)
    situation: Situation | None = field(default=None, repr=False, compare=False)
    vehicle: Vehicle | None = field(default=None, repr=False, compare=False)

    @property
    def candidates(self) -> tuple[Escape, Escape, Escape, Escape]:
        return self.brake, self.accelerate, self.left, self.right

    @property
    def last_moment_s(self) -> float | None:
        """Of all candidates; None when every one is closed."""
        return max((one.last_moment_s for one in self.candidates if one.last_moment_s is not None), default=None)

    @property
    def last_comfortable_s(self) -> float | None:
        """The last moment at which any of them can be started comfortably; None when it has passed."""
        return max((one.last_comfortable_s for one in self.candidates if one.last_comfortable_s is not None), default=None)

    def to_dict(self) -> dict[str, Any]:
        document: dict[str, Any] = to_document(self)
        return document

    def in_brief(self) -> tuple[str, str, str]:
        named = zip(_NAMES, self.candidates, strict=True)
        until = [f"{name} until {one.last_moment_s:.1f} s" for name, one in named if one.last_moment_s is not None]
        closed = [f"{name} ({one.closed_by or 'not seen'})" for name, one in zip(_NAMES, self.candidates, strict=True) if not one.open]
        ends = "meets nobody within 10 s" if self.keeping_on_s is None else f"ends in {self.keeping_on_s:.1f} s"
        return (
            f"Escapes: {', '.join(until) or 'none is open'}",
            f"closed: {', '.join(closed) or 'none'}",
            f"keeping acceleration and steering {ends}",
        )

    def columns(self) -> Columns:
        """A row for each candidate."""
        rows = self.candidates
        return {
            "candidate": _NAMES,
            "open": [one.open for one in rows],
            "last_moment_s": [one.last_moment_s for one in rows],
            "last_comfortable_s": [one.last_comfortable_s for one in rows],
            "closed_by": [None if one.closed_by is None else one.closed_by.value for one in rows],
            "demand_mps2": [one.demand_mps2 for one in rows],
        }


_NAMES = ("brake", "accelerate", "left", "right")
