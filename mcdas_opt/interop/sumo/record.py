"""What a drive in SUMO comes to, and who caused a contact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

from mcdas_opt.simulation.ordinary import OrdinaryDriving, Snapshot

SINCE_S = 3.0  # who came into the other's lane so recently caused what follows from it
SIDEWAYS_MPS = 0.3  # who moves sideways towards the other faster than this, and faster than the other, caused a contact of their sides
_OVER_S = 0.5


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


def caused_by(snapshots: Sequence[Snapshot], other: str) -> tuple[Cause, str]:
    """Of the contact that the last snapshot shows. In this order:

    1. bodies side by side: whoever moved sideways towards the other, the faster of the two;
    2. whoever came into the other's lane within SINCE_S; both: the later;
    3. else whoever was behind.
    """
    now = snapshots[-1]
    them = next(one for one in now.others if one.id == other)
    past = [(one, body) for one in snapshots if one.time_s >= now.time_s - SINCE_S for body in one.others if body.id == other]
    beside = 0.5 * (now.host.length_m + them.length_m) - abs(them.s_m - now.host.s_m) > 1.0
    if beside:
        side = math.copysign(1.0, them.d_m - now.host.d_m)
        first, body = next(((one, body) for one, body in past if one.time_s >= now.time_s - _OVER_S))
        span = max(now.time_s - first.time_s, 1e-9)
        ours, theirs = side * (now.host.d_m - first.host.d_m) / span, -side * (them.d_m - body.d_m) / span
        if max(ours, theirs) > SIDEWAYS_MPS:
            return (Cause.HOST, "the host moved sideways into it") if ours >= theirs else (Cause.OTHER, "it moved sideways into the host")
    changed = {Cause.HOST: -math.inf, Cause.OTHER: -math.inf}
    for (before, was), (after, is_) in pairwise(past):
        if before.host.lane != after.host.lane:
            changed[Cause.HOST] = after.time_s
        if was.lane != is_.lane:
            changed[Cause.OTHER] = after.time_s
    latest = max(changed, key=lambda who: changed[who])
    if math.isfinite(changed[latest]):
        when = now.time_s - changed[latest]
        return latest, f"{'the host' if latest is Cause.HOST else 'it'} had changed lanes {when:.1f} s before"
    return (Cause.HOST, "the host drove into it") if them.s_m > now.host.s_m else (Cause.OTHER, "it drove into the host")
