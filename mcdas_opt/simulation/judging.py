"""The judge on any trajectory, in a scene or a situation."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import require_type, require_type_if_given
from mcdas_opt.domain.safe_end import SafeEndSettings, named_in
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.simulation.first_situation import situation_of
from mcdas_opt.simulation.neighbours import Traffic, known_bodies
from mcdas_opt.situation.doubts import planned_around
from mcdas_opt.tracking.follower_prediction import with_attentive_followers
from mcdas_opt.tracking.prediction import CONSTANT_VELOCITY, predict, predict_for
from mcdas_opt.verification.judge import judge

SCENE = "scene"
PREDICTIONS = (SCENE, CONSTANT_VELOCITY)


@usual_arithmetic
def verify(
    trajectory: Trajectory,
    target: Scene | Situation,
    prediction: str | None = None,
    settings: PredictionSettings | None = None,
    vehicle: Vehicle | None = None,
    relies_on: str | None = None,
) -> Verdict:
    """The judge's verdict on a trajectory that begins at the start of a scene, or at the time of a situation.

    `prediction` says how the neighbours move: "scene" by the scene's script (default there; followers react to the trajectory),
    "constant-velocity" as a planner with perfect sensors predicts at t = 0 (the only one for a situation, from the tracks that are planned
    around: `situation/doubts.py`). Judged with the friction that plans are made with, and the target's vehicle unless another is given.
    `relies_on`, in a situation: the followers who brake behind the host as a plan expects them to (its `safe_end.relies_on`); None: nobody
    is expected to. Raises `ParameterError` for another name of a prediction.
    """
    require_type("trajectory", trajectory, Trajectory)
    require_type("target", target, Scene, Situation)
    require_type_if_given("prediction", prediction, str)
    require_type_if_given("settings", settings, PredictionSettings)
    require_type_if_given("vehicle", vehicle, Vehicle)
    require_type_if_given("relies_on", relies_on, str)
    if isinstance(target, Situation):
        car = vehicle or load_vehicle(target.vehicle_name)
        around = planned_around(target, car)
        foreseen = foresee(trajectory, around, prediction, settings)
        if relies_on is not None:
            foreseen = with_attentive_followers(
                foreseen, around, frozenset(named_in(relies_on, [track.id for track in around.tracks])), SafeEndSettings()
            )
        return judge(trajectory, target.host, car, target.road, foreseen)
    foreseen = foresee(trajectory, target, prediction, settings)
    return judge(trajectory, target.host_state, vehicle or target.vehicle, target.assumed_road, foreseen)


def target_of(name: str) -> tuple[Scene | Situation, Vehicle]:
    """What to judge in: a scene (path or shipped name), or a situation saved as `.json`; and its vehicle. Raises `InputError`."""
    if Path(name).suffix == ".json":
        return situation_of(name)
    scene = load_scene(name)
    return scene, scene.vehicle


def foresee(
    trajectory: Trajectory, target: Scene | Situation, prediction: str | None = None, settings: PredictionSettings | None = None
) -> Prediction:
    """The prediction that `verify` judges against; its `name` is the one in use."""
    if isinstance(target, Situation):
        if prediction not in (None, CONSTANT_VELOCITY):
            raise ParameterError("prediction", prediction, f"a situation knows only {CONSTANT_VELOCITY!r}")
        return predict_for(target, settings)
    if prediction in (None, SCENE):
        return Prediction(name=SCENE, bodies=known_bodies(target, trajectory))
    if prediction == CONSTANT_VELOCITY:
        return predict(exact_tracks(target), settings, target.assumed_road)
    raise ParameterError("prediction", prediction, nearest(str(prediction), PREDICTIONS))


def exact_tracks(scene: Scene) -> tuple[Track, ...]:
    """Every neighbour at t = 0 as a perfect sensor measures it."""
    traffic = Traffic(scene)
    moments = traffic.motions(np.array(0.0))
    return tuple(
        Track(
            id=name,
            s_m=float(moment.s_m),
            d_m=float(moment.d_m),
            speed_s_mps=float(moment.speed_s_mps),
            speed_d_mps=float(moment.speed_d_mps),
            length_m=length,
            width_m=width,
            heading_rad=math.remainder(float(moment.heading_rad), 2.0 * math.pi),
            kind=kind,
        )
        for name, moment, (length, width), kind in zip(traffic.names, moments, traffic.sizes, traffic.kinds, strict=True)
    )
