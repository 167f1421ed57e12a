"""The time-to-react assessment of a plan: which candidates are open, until when, and whether that is worth an alert."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Alert
from mcdas_opt.time_to_react.alert import alert
from mcdas_opt.time_to_react.escapes import escapes
from mcdas_opt.time_to_react.library import EscapeSettings


def time_to_react(plan: Plan, situation: Situation, previous: Plan | None, vehicle: Vehicle, settings: Settings) -> dict[str, Any]:
    """The plan's escape map, alert and warning, by field; an alert is a warning. Nothing where the settings turn the map off."""
    wanted = settings.warning
    if not wanted.escapes:
        return {}
    comfort = _comfortable(wanted.comfort_mps2, wanted.comfort_share)
    found = escapes(situation, vehicle, prediction=settings.prediction, settings=comfort)
    told = alert(found, wanted, Alert.NONE if previous is None else previous.alert)
    return {"escapes": found, "alert": told, "warning": plan.warning or told is not Alert.NONE}


@lru_cache(maxsize=4)
def _comfortable(mps2: float, share: float) -> EscapeSettings:
    return EscapeSettings(comfort_mps2=mps2, comfort_share=share)
