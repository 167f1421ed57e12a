"""The time-to-react assessment of a plan: which manoeuvres are open, until when, and whether that calls for an alert."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.vocabulary import Alert, Mode, Status
from mcdas_opt.dynamics.bicycle import lateral_acceleration
from mcdas_opt.planning.candidate import strongest_mps2
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage
from mcdas_opt.planning.proposals.unwatched import unwatched
from mcdas_opt.planning.reporting.reason import with_alert
from mcdas_opt.time_to_react.alert import alert
from mcdas_opt.time_to_react.escapes import escapes_under
from mcdas_opt.time_to_react.library import EscapeSettings

_STANDING_MPS = 0.1
_CLEARLY = 0.7  # of what is comfortable: an alert that was given ends there, and does not flicker


def with_time_to_react(plan: Plan, cycle: Cycle) -> Plan:
    """The plan with its map of time to react and its alert: the map's (none where the settings turn the map off), and a warning at least
    where the plan itself warns, steers out, or brakes harder than is comfortable, or nobody watches ahead of a host that drives. Steering
    out where nobody watches behind is `act`, and so is driving on for long where nobody watches ahead.
    `warning` says whether there is an alert, and the reason what of. Where the deadline leaves no time for a map, the alert is that of the
    cycle before.

    There is no alert while the plan itself is a comfortable candidate: whatever a map of a few dozens of manoeuvres found, there is one.
    One that was given lasts until the plan is clearly so. Nor is it `act` in ordinary driving while the plan passes to a safe end.
    """
    wanted, before, found, told = cycle.settings.warning, cycle.memory.alert, None, Alert.NONE
    if wanted.escapes and cycle.is_late_for(Stage.TIME_TO_REACT):
        told = before
    elif wanted.escapes:
        comfort = _comfortable(wanted.comfort_mps2, wanted.comfort_share)
        found = escapes_under(cycle.prediction, cycle.situation, cycle.vehicle, comfort)
        most = comfort.comfort_on(cycle.situation.road.friction) * (1.0 if before is Alert.NONE else _CLEARLY)
        ordinary_s = float(cycle.settings.grid.times_s[-1]) if cycle.is_ordinary else None
        if not _is_comfortable(plan, cycle.vehicle.wheelbase_m, most, ordinary_s):
            told = alert(found, wanted, before)
            if told is Alert.ACT and cycle.is_ordinary and plan.mode is not Mode.EVADE and _is_sound(plan):
                told = Alert.WARN
            if told is Alert.NONE and (before is not Alert.NONE or plan.mode is Mode.EVADE or _brakes_hard(plan, cycle)):
                told = Alert.WARN
    blind = cycle.observed.blind_ahead
    is_blind = not cycle.situation.coverage.front and cycle.situation.host.speed_mps > _STANDING_MPS
    if told is Alert.NONE and (plan.warning or is_blind):
        told = Alert.WARN
    if is_blind and blind is not None and blind.is_long:
        told = Alert.ACT
    if plan.mode is Mode.EVADE and unwatched(cycle.situation, plan.side):
        told = Alert.ACT
    reason = plan.reason if told is Alert.NONE else with_alert(plan.reason, found, blind=_blindness(plan, cycle) if is_blind else "")
    return replace(plan, escapes=found, alert=told, warning=told is not Alert.NONE, reason=reason)


def _blindness(plan: Plan, cycle: Cycle) -> str:
    return f"nobody watches ahead{': slows down' if cycle.slows_blindly and plan.mode is Mode.BRAKE else ''}"


def _brakes_hard(plan: Plan, cycle: Cycle) -> bool:
    """Whether it brakes by more than is comfortable at the host's speed (ISO 15622) within a second."""
    return strongest_mps2(plan.trajectory) < -cycle.settings.comfort.limits(cycle.situation.host.speed_mps).braking_mps2


def _is_sound(plan: Plan) -> bool:
    return plan.status is Status.PLANNED and plan.safe_end is not None and plan.safe_end.safe


def _is_comfortable(plan: Plan, wheelbase_m: float, most_mps2: float, ordinary_s: float | None) -> bool:
    """Whether it passes to a safe end, asking no more of the tyres. In ordinary driving, to that horizon, neither speeding up counts, as
    out of a turn, nor how it would stop afterwards."""
    if not _is_sound(plan):
        return False
    x = plan.trajectory
    along, across = x.acceleration_mps2, lateral_acceleration(x.speed_mps, x.steering_rad, wheelbase_m, np)
    if ordinary_s is not None:
        along = np.where(x.t_s <= ordinary_s, np.minimum(along, 0.0), 0.0)
    return bool(np.hypot(along, across).max() <= most_mps2)


@lru_cache(maxsize=4)
def _comfortable(mps2: float, share: float) -> EscapeSettings:
    return EscapeSettings(comfort_mps2=mps2, comfort_share=share)
