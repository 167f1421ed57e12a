"""What a followed parking manoeuvre leaves behind."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import ClassVar

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.result import Columns, Result
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


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class ParkingDrive(Result):
    """A drive and its figures, all of the true car among the true obstacles.

    `parked` is at rest within the case's tolerance of the true goal; `stopped` is at rest anywhere else. Tracking errors are against
    the trajectory of the moment. `stops_judged` counts the cycles in which a stop from there was built and judged, `stops_unsound`
    those in which it failed; `stops_driven` those that were used. `truth` is the case as it really is.
    """

    drawn_by: ClassVar[str] = "mcdas_opt.plotting.parking_follow:sheet"
    moves_by: ClassVar[str] = "mcdas_opt.plotting.parking_follow:film"
    plays_by: ClassVar[str] = "mcdas_opt.plotting.player:follow_page"

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
    truth: ParkingCase | None = field(default=None, repr=False, compare=False)

    def in_brief(self) -> tuple[str, str, str]:
        off = f"{100.0 * self.end_position_error_m:.1f} cm and {1e3 * self.end_heading_error_rad:.0f} mrad off"
        least = "no obstacles" if self.min_clearance_m is None else f"least clearance {self.min_clearance_m:.3f} m"
        return (
            f"Parking drive of {self.planner} in {self.name}, seed {self.seed}: {self.outcome} after {self.duration_s:.1f} s, {off}",
            f"{least}; {self.reason}",
            f"{self.stops_judged} stops judged, {self.stops_unsound} unsound, {self.stops_driven} driven; {self.replans} plans anew",
        )

    def columns(self) -> Columns:
        """What was driven."""
        return self.trajectory.columns()
