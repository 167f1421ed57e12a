"""What every plan says besides: which ways out are open, until when, and whether that is worth an alert."""

from __future__ import annotations

from dataclasses import replace

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Alert
from mcdas_opt.manoeuvres.escape_library import EscapeSettings
from mcdas_opt.planning.escape_map import escapes
from mcdas_opt.situation.alert import alert


def watched(plan: Plan, situation: Situation, previous: Plan | None, vehicle: Vehicle, settings: Settings) -> Plan:
    """The plan with its escape map and alert; an alert is a warning. The plan itself where the settings turn the map off."""
    wanted = settings.warning
    if not wanted.escapes:
        return plan
    comfort = EscapeSettings(comfort_mps2=wanted.comfort_mps2, comfort_share=wanted.comfort_share)
    found = escapes(situation, vehicle, prediction=settings.prediction, settings=comfort)
    told = alert(found, wanted, Alert.NONE if previous is None else previous.alert)
    return replace(plan, escapes=found, alert=told, warning=plan.warning or told is not Alert.NONE)
