"""Tracks go on at constant velocity."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.track import Track
from mcdas_opt.tracking.prediction import predict


def test_a_prediction_holds_every_track_with_the_settings_of_the_planner() -> None:
    covariance = np.diag([0.04, 0.01, 0.09, 0.25])
    tracks = [
        Track(id="1", s_m=30.0, d_m=0.2, speed_s_mps=12.0, covariance=covariance),
        Track(id="2", s_m=-30.0, d_m=3.7, speed_s_mps=15.0, speed_d_mps=-0.8, covariance=covariance, length_m=9.0, width_m=2.4),
    ]
    settings = PredictionSettings(sigmas=2.0, growth_s=0.5, cap_along_m=0.45, cap_across_m=10.0, lateral_fade_s=2.0)
    prediction = predict(tracks, settings)
    assert prediction.name == "constant-velocity"
    assert [(b.id, b.length_m, b.width_m) for b in prediction.bodies] == [("1", 4.5, 1.8), ("2", 9.0, 2.4)]
    t = np.array([0.0, 1.0, 4.0])
    first, second = (body.at(t) for body in prediction.bodies)
    np.testing.assert_allclose(first.s_m, 30.0 + 12.0 * t)
    np.testing.assert_allclose(first.d_m, 0.2)
    np.testing.assert_allclose(second.d_m, 3.7 - 0.8 * 2.0 * (1.0 - np.exp(-t / 2.0)))
    along, across = prediction.bodies[0].margin_along_m(t), prediction.bodies[0].margin_across_m(t)
    np.testing.assert_allclose(along, [0.4, 2.0 * np.sqrt(0.04 + 0.25 * 0.01), 2.0 * np.sqrt(0.0425)])
    np.testing.assert_allclose(across, 2.0 * np.sqrt([0.09, 0.09 + 0.0625, 0.09 + 0.0625]))
    assert predict([]).bodies == ()
