"""How the answers of the layers below are drawn: each in what it was asked for, which it carries along."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mcdas_opt.domain.escapes import Escapes
from mcdas_opt.domain.parking import Parking, ParkingCase
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.parking.closed_loop.record import ParkingDrive
from mcdas_opt.plotting import export, parking, parking_follow, plan_sheet
from mcdas_opt.plotting.time_to_react_timeline import time_to_react_sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plan_figure(plan: Plan) -> Figure:
    """The plan in its situation, seconds later, and over time."""
    return plan_sheet.plan_sheet(*_asked(plan), plan)


def save_moving_plan(plan: Plan, path: Path) -> Path:
    return export.save_plan(*_asked(plan), plan, path)


def escapes_figure(escapes: Escapes) -> Figure:
    """The situation, and until when each candidate stays open."""
    return time_to_react_sheet(*_asked(escapes), escapes)


def parking_figure(found: Parking) -> Figure:
    """The manoeuvre from above, its curvature and its speed."""
    case = _case("case", found.case)
    if found.trajectory is None:
        raise ParameterError("trajectory", None, "there is nothing to draw: the case was refused")
    return parking.sheet(case, found)


def save_moving_parking(found: Parking, path: Path) -> Path | None:
    return export.save_parking(_case("case", found.case), found, path)


def followed_figure(drive: ParkingDrive) -> Figure:
    """What was driven, against what was planned."""
    return parking_follow.sheet(_case("truth", drive.truth), drive)


def save_moving_followed(drive: ParkingDrive, path: Path) -> Path:
    return export.save_follow(_case("truth", drive.truth), drive, path)


def _asked(answer: Plan | Escapes) -> tuple[Situation, Vehicle]:
    if answer.situation is None or answer.vehicle is None:
        raise ParameterError("situation", None, "is not known, so that there is nothing to draw in: ask a Planner, plan or escapes")
    return answer.situation, answer.vehicle


def _case(name: str, case: ParkingCase | None) -> ParkingCase:
    if case is None:
        raise ParameterError(name, None, "is not known, so that there is nothing to draw in")
    return case
