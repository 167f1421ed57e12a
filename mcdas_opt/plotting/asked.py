"""What an answer of the layers below was asked for, which it carries along: it is drawn in that."""

from __future__ import annotations

from mcdas_opt.domain.escapes import Escapes
from mcdas_opt.domain.parking import Parking, ParkingCase
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.parking.closed_loop.record import ParkingDrive


def situation_of(answer: Plan | Escapes) -> tuple[Situation, Vehicle]:
    if answer.situation is None or answer.vehicle is None:
        raise ParameterError("situation", None, "is not known, so that there is nothing to draw in: ask a Planner, plan or escapes")
    return answer.situation, answer.vehicle


def case_of(answer: Parking | ParkingDrive) -> ParkingCase:
    """Of a manoeuvre that was driven the true one."""
    name, case = ("case", answer.case) if isinstance(answer, Parking) else ("truth", answer.truth)
    if case is None:
        raise ParameterError(name, None, "is not known, so that there is nothing to draw in")
    return case
