"""Which ways out are still open, and until when."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from mcdas_opt.domain.document import to_document


class Closer(StrEnum):
    """What closes a way out."""

    FRONT = "front"
    REAR = "rear"
    SIDE = "side car"
    EDGE = "road edge"
    FRICTION = "friction"


@dataclass(frozen=True, slots=True, kw_only=True)
class Escape:
    """One way out.

    `last_moment_s` is the latest start, if the host keeps its acceleration and steering until then; None when there is none, at most
    10. `closed_by` ends it (None where nothing does within 10 s). `demand_mps2` is what it asks of the tyres when it begins now
    (the gentlest that was found); None when it cannot begin now. `last_comfortable_s` is the latest start of one that is comfortable;
    None when there is none.
    """

    open: bool = False
    last_moment_s: float | None = None
    closed_by: Closer | None = None
    demand_mps2: float | None = None
    last_comfortable_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Escapes:
    """The four ways out of a situation: in the lane by braking or accelerating, into the next lane to the left or the right.

    `keeping_on_s` is when keeping acceleration and steering ends in somebody or off the road; None where it does not within 10 s.
    """

    brake: Escape = field(default_factory=Escape)
    accelerate: Escape = field(default_factory=Escape)
    left: Escape = field(default_factory=Escape)
    right: Escape = field(default_factory=Escape)
    keeping_on_s: float | None = field(default=None, repr=False)

    @property
    def ways(self) -> tuple[Escape, Escape, Escape, Escape]:
        return self.brake, self.accelerate, self.left, self.right

    @property
    def last_moment_s(self) -> float | None:
        """Of all ways out; None when every one is closed."""
        return max((way.last_moment_s for way in self.ways if way.last_moment_s is not None), default=None)

    @property
    def last_comfortable_s(self) -> float | None:
        """The last moment at which any way out can be started comfortably; None when it has passed."""
        return max((way.last_comfortable_s for way in self.ways if way.last_comfortable_s is not None), default=None)

    def to_dict(self) -> dict[str, Any]:
        document: dict[str, Any] = to_document(self)
        return document
