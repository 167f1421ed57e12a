"""The escape map of a situation, under the planner's own prediction."""

from __future__ import annotations

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.escapes import Escapes
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.time_to_react.escape_map import escapes as escapes_under
from mcdas_opt.time_to_react.library import EscapeSettings
from mcdas_opt.tracking.prediction import predict_for


def escapes(
    situation: Situation,
    vehicle: Vehicle | None = None,
    *,
    prediction: PredictionSettings | None = None,
    settings: EscapeSettings | None = None,
) -> Escapes:
    """For braking, accelerating, steering left and right: open or closed, the last moment to start, what closes it, what it asks now.

    Neighbours go on at constant velocity from their tracks; their bare bodies count, unless `settings.margins` grows them. `vehicle`
    is the situation's own unless given. Raises `InputError` for a vehicle that is not known.
    """
    car = load_vehicle(situation.vehicle) if vehicle is None else vehicle
    return escapes_under(situation, car, predict_for(situation, prediction), settings)
