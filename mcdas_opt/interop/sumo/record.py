"""What a drive in SUMO comes to."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from mcdas_opt.simulation.ordinary import OrdinaryDriving


class Cause(StrEnum):
    """Who caused a contact."""

    HOST = "host"
    OTHER = "other"


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """The host and somebody touch; `speed_mps` is that of one centre relative to the other. `why` says what the cause is told by."""

    time_s: float
    other: str
    speed_mps: float
    cause: Cause
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class SumoSummary:
    """A drive so far. `ended`: driving, arrived (the route's end), vanished (SUMO took the vehicle away)."""

    driver: str
    ended: str
    contacts: tuple[Contact, ...]
    ordinary: OrdinaryDriving
    plans: int
    fallbacks: int
    unavoidable: int
    unverified_plans: int
