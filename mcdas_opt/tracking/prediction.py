"""Where tracked neighbours are believed to go."""

from __future__ import annotations

from collections.abc import Sequence

from mcdas_opt.domain.prediction import CruisingBody, Prediction
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.track import Track

CONSTANT_VELOCITY = "constant-velocity"


def predict(tracks: Sequence[Track], settings: PredictionSettings | None = None) -> Prediction:
    """Everybody keeps the speed along the road and settles across it; margins from the *present* covariance (see `CruisingBody`).

    The tracks are at the situation's time, which is the prediction's time zero.
    """
    settings = PredictionSettings() if settings is None else settings
    bodies = tuple(
        CruisingBody(
            id=track.id,
            length_m=track.length_m,
            width_m=track.width_m,
            s_m=track.s_m,
            d_m=track.d_m,
            speed_s_mps=track.speed_s_mps,
            speed_d_mps=track.speed_d_mps,
            covariance=track.covariance,
            lateral_fade_s=settings.lateral_fade_s,
            sigmas=settings.sigmas,
            growth_s=settings.growth_s,
            cap_along_m=settings.cap_along_m,
            cap_across_m=settings.cap_across_m,
        )
        for track in tracks
    )
    return Prediction(name=CONSTANT_VELOCITY, bodies=bodies)
