"""A prediction works out its bodies' motions on times that nobody can write into once, and as each body says."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.prediction import BodyMotion, CruisingBody, KnownBody, PredictedBody, Prediction


def cruising(seed: int) -> CruisingBody:
    s, d, vs, vd = np.random.default_rng(seed).normal(0.0, (50.0, 4.0, 20.0, 1.0))
    fade = 1.0 + seed % 3
    return CruisingBody(
        id=str(seed),
        length_m=4.5,
        width_m=1.8,
        s_m=s,
        d_m=d,
        speed_s_mps=vs,
        speed_d_mps=vd,
        covariance=np.zeros((4, 4)),
        lateral_fade_s=fade,
    )


def standing(t: np.ndarray) -> BodyMotion:
    return BodyMotion(s_m=0.0 * t, d_m=0.0 * t, heading_rad=0.0 * t, speed_s_mps=0.0 * t, speed_d_mps=0.0 * t)


@settings(deadline=None, max_examples=40)
@given(seeds=st.lists(st.integers(0, 999), max_size=5, unique=True), known=st.booleans())
def test_it_says_what_each_body_says(seeds: list[int], known: bool) -> None:
    bodies: list[PredictedBody] = [cruising(seed) for seed in seeds]
    if known:
        bodies.append(KnownBody(id="known", length_m=4.5, width_m=1.8, motion=standing))
    prediction, times = Prediction(name="test", bodies=tuple(bodies)), TimeGrid().times_s
    rows = prediction.rows_on(times)
    assert prediction.rows_on(times) is rows
    for k, body in enumerate(bodies):
        for part in fields(BodyMotion):
            np.testing.assert_allclose(getattr(rows, part.name)[k], getattr(body.at(times), part.name), rtol=1e-13, atol=1e-13)


def test_times_that_may_change_are_not_remembered() -> None:
    prediction, times = Prediction(name="test", bodies=(cruising(1),)), np.arange(3.0)
    before = prediction.rows_on(times).s_m
    times += 1.0
    assert (prediction.rows_on(times).s_m != before).all()


def test_what_it_remembers_cannot_be_written_into() -> None:
    prediction, times = Prediction(name="test", bodies=(cruising(1), cruising(2))), TimeGrid().times_s
    for part in fields(BodyMotion):
        with pytest.raises(ValueError, match="read-only"):
            getattr(prediction.rows_on(times), part.name)[...] = 0.0


def test_it_remembers_a_few_times_only() -> None:
    prediction = Prediction(name="test", bodies=(cruising(2),))
    for steps in range(2, 60):
        prediction.rows_on(TimeGrid(steps_s=np.full(steps, 0.1)).times_s)
    assert len(prediction._on) <= 16
