"""Neighbours grown by clearance and margins: the compiled form is that of the array operations to the bit, and of the bodies' own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt import load_scene, simulate
from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.prediction import BodyMotion, CruisingBody, KnownBody, PredictedBody, together
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.track import Track
from mcdas_opt.native.form import SWITCH
from mcdas_opt.planning.lane_problem.grown_bodies import grown_bodies
from mcdas_opt.tracking.prediction import predict

TIMES = TimeGrid().times_s


def cruising(rng: np.random.Generator, k: int) -> CruisingBody:
    root = rng.normal(0.0, 0.7, (4, 4))
    length, width, s, d, speed, sideways, sigmas, growth = rng.uniform(0.2, 6.0, 8)
    covariance = root @ root.T * rng.choice([0.0, 0.01, 1.0])
    return CruisingBody(
        id=str(k),
        length_m=length,
        width_m=width,
        s_m=s,
        d_m=d,
        speed_s_mps=speed,
        speed_d_mps=sideways,
        covariance=covariance,
        sigmas=sigmas,
        growth_s=growth,
    )


def standing(t: np.ndarray) -> BodyMotion:
    zero = np.zeros_like(t)
    return BodyMotion(s_m=zero, d_m=zero, heading_rad=zero, speed_s_mps=zero, speed_d_mps=zero)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 6), st.booleans())
def test_all_forms_agree(seed: int, count: int, scripted: bool) -> None:
    rng = np.random.default_rng(seed)
    bodies: list[PredictedBody] = [cruising(rng, k) for k in range(count)]
    if scripted:
        bodies.append(KnownBody(id="scripted", length_m=5.0, width_m=2.0, motion=standing))
    along, across = rng.uniform(0.0, 1.0, 2).tolist()
    heading = together(bodies, TIMES).heading_rad
    grown = grown_bodies(bodies, TIMES, heading, along, across)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        arrays = grown_bodies(bodies, TIMES, heading, along, across)
    assert grown.shape == (len(bodies), 2, TIMES.size)
    assert grown.tobytes() == np.ascontiguousarray(arrays).tobytes()
    for body, (half_along, half_across) in zip(bodies, grown, strict=True):
        np.testing.assert_allclose(half_along, 0.5 * body.length_m + along + body.margin_along_m(TIMES), rtol=1e-15)
        np.testing.assert_allclose(half_across, 0.5 * body.width_m + across + body.margin_across_m(TIMES), rtol=1e-15)


@pytest.mark.parametrize(("kind", "kept_m"), [("pedestrian", 1.5), ("car", 0.25)])
def test_people_are_kept_farther_from_on_every_side(kind: str, kept_m: float) -> None:
    crossing = Track(
        id="1", s_m=30.0, d_m=-5.0, speed_s_mps=0.0, speed_d_mps=1.4, heading_rad=0.5 * np.pi, length_m=0.4, width_m=0.6, kind=kind
    )
    (body,) = predict((crossing,), road=Road()).bodies
    ((along, across),) = grown_bodies([body], TIMES, together([body], TIMES).heading_rad, 0.25, 0.25, on_foot_m=1.5)
    np.testing.assert_allclose(along, 0.3 + kept_m + body.margin_along_m(TIMES))
    np.testing.assert_allclose(across, 0.2 + kept_m + body.margin_across_m(TIMES))


def test_who_crosses_on_foot_is_passed_with_room() -> None:
    drive = simulate(load_scene("crossing-pedestrian"), "mpc")
    assert drive.outcome == "safe"
    assert drive.min_clearance_m > 1.5
