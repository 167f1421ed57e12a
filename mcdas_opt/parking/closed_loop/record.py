"""What a followed parking manoeuvre leaves behind."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
from mcdas_opt.domain.parking import ParkingTrajectory
from mcdas_opt.parking.closed_loop.sight import Visitor


class ParkingOutcome(StrEnum):
    PARKED = "parked"
    STOPPED = "stopped"
    COLLISION = "collision"


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingEvent:
    """What happened, and when."""

    time_s: float
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingDrive:
    """A drive and its figures, all of the true car among the true obstacles.

    `parked` is at rest within the case's tolerance of the true goal; `stopped` is at rest anywhere else. Tracking errors are against
    the trajectory of the moment. `stops_judged` counts the cycles in which a stop from there was built and judged, `stops_unsound`
    those in which it failed; `stops_driven` those that were used.
    """

    name: str
    planner: str
    seed: int
    outcome: ParkingOutcome
    reason: str
    duration_s: float
    end_position_error_m: float
    end_heading_error_rad: float
    min_clearance_m: float | None
    collided_with: str | None
    replans: int
    stops_judged: int
    stops_unsound: int
    stops_driven: int
    max_across_m: float
    max_heading_rad: float
    max_along_m: float
    trajectory: ParkingTrajectory
    events: tuple[ParkingEvent, ...] = ()
    visitors: tuple[Visitor, ...] = ()
    references: tuple[ParkingTrajectory, ...] = field(default=(), repr=False, compare=False)

    def to_dict(self) -> dict[str, Any]:
        """As a JSON document, without the references."""
        return {"schema_version": SCHEMA_VERSION, **to_document(self)}
