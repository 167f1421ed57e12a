"""The escape map: for each candidate, the last moment at which it still can be started (its time to react), and what ends it."""

from __future__ import annotations

import math

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.escapes import Closer, Escape, Escapes
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import require_type, require_type_if_given
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.native.library import library
from mcdas_opt.situation.doubts import planned_around
from mcdas_opt.time_to_react.compiled_map import answered
from mcdas_opt.time_to_react.guess import Case
from mcdas_opt.time_to_react.library import LATEST_S, EscapeSettings
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S
from mcdas_opt.time_to_react.search import found
from mcdas_opt.tracking.prediction import predict_for


@usual_arithmetic
def escapes(
    situation: Situation,
    vehicle: Vehicle | None = None,
    *,
    prediction: PredictionSettings | None = None,
    settings: EscapeSettings | None = None,
) -> Escapes:
    """For braking, accelerating, steering left and right: open or closed, the last moment to start, what closes it, what it asks now.

    Neighbours move as the planner predicts them; their bare bodies count, unless `settings.margins` grows them. `vehicle` is the
    situation's own unless given; last moments are earlier by what its actuators take to answer. Raises `InputError` for a vehicle
    that is not known.
    """
    require_type("situation", situation, Situation)
    require_type_if_given("vehicle", vehicle, Vehicle)
    require_type_if_given("prediction", prediction, PredictionSettings)
    require_type_if_given("settings", settings, EscapeSettings)
    car = load_vehicle(situation.vehicle_name) if vehicle is None else vehicle
    return escapes_under(predict_for(planned_around(situation, car), prediction), situation, car, settings)


def escapes_under(prediction: Prediction, situation: Situation, vehicle: Vehicle, settings: EscapeSettings | None = None) -> Escapes:
    """The same under any prediction: four candidates, each the best of some dozens of manoeuvres of its kind, for all starts at once.

    Each manoeuvre from a few starts says which gaps it needs, and so until when each gap lasts; the best few are then driven from
    about that moment and separated from everybody exactly, so that a candidate called open is open.
    """
    chosen = settings or _DEFAULT
    compiled = library()
    if compiled is None:
        answer = found(Case(situation, vehicle, prediction, chosen))
    else:
        answer = answered(compiled, situation, vehicle, prediction, chosen)
    end_s, ender, (last, comfortable), now, closers = answer
    latest = math.floor(end_s / LATTICE_S + 1e-9)
    ended = ender if latest * LATTICE_S < LATEST_S - 1e-9 else None
    sides = (situation.sees_lane(side) for side in (Side.LEFT, Side.RIGHT))
    covered = True, situation.coverage.front, *sides  # into a direction that no sensor covers everything is closed
    candidates: list[Escape] = []
    for kind, (seen, earlier) in enumerate(zip(covered, _answer_steps(vehicle), strict=True)):
        closer = closers[kind] if last[kind] < latest else ended
        sooner = earlier if closer is not None else 0  # what nothing closes stays open
        start, easy = last[kind] - sooner, comfortable[kind] - sooner
        if start < 0 or not seen:
            candidates.append(Escape(closed_by=closer if seen else _UNSEEN[kind]))
            continue
        candidate = Escape(
            open=True,
            last_moment_s=round(LATTICE_S * start, 4),
            closed_by=closer,
            demand_mps2=now[kind],
            last_comfortable_s=round(LATTICE_S * easy, 4) if easy >= 0 else None,
        )
        candidates.append(candidate)
    brake, accelerate, left, right = candidates
    keeping_on_s = round(end_s, 4) if ender is not None else None
    return Escapes(
        brake=brake,
        accelerate=accelerate,
        left=left,
        right=right,
        keeping_on_s=keeping_on_s,
        keeping_on_meets=ender,
        situation=situation,
        vehicle=vehicle,
    )


def _answer_steps(vehicle: Vehicle) -> tuple[int, ...]:
    """By how many steps of the lattice each kind has to be commanded earlier, as the actuators answer late.

    A lag counts with its time constant: the car then gets no farther than one that answers so much later. What a steering candidate
    brakes or accelerates besides is counted as immediate.
    """
    answer = vehicle.actuators
    lags = answer.brake_build_up_s, answer.engine_lag_s, answer.steering_lag_s, answer.steering_lag_s
    return tuple(math.ceil((answer.steering_delay_s + lag) / LATTICE_S - 1e-9) for lag in lags)


_DEFAULT = EscapeSettings()
_UNSEEN = (None, Closer.FRONT, Closer.SIDE, Closer.SIDE)  # what then closes it, by kind
