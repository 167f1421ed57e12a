"""The cruising body: its motion is that of its speeds, its margins grow for a second and no more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.prediction import (
    BodyMotion,
    CruisingBody,
    KnownBody,
    PredictedBody,
    margins_together,
    responding,
    responds,
    together,
)

speeds = st.floats(-40.0, 60.0)


def cruising(**changed):
    values = {
        "id": "x",
        "length_m": 4.5,
        "width_m": 1.8,
        "s_m": 3.0,
        "d_m": 1.0,
        "speed_s_mps": 10.0,
        "speed_d_mps": 0.0,
        "covariance": np.zeros((4, 4)),
    }
    return CruisingBody(**{**values, **changed})


@given(speed_s=speeds, speed_d=st.floats(-3.0, 3.0), t=st.floats(0.0, 10.0))
def test_positions_are_the_integrals_of_the_speeds(speed_s, speed_d, t):
    body = cruising(speed_s_mps=speed_s, speed_d_mps=speed_d)
    h = 1e-4
    near = body.at(np.array([t, t + h]))
    assert np.diff(near.s_m)[0] / h == pytest.approx(speed_s, abs=1e-6)
    assert np.diff(near.d_m)[0] / h == pytest.approx(near.speed_d_mps.mean(), abs=1e-6)
    assert body.at(0.0).s_m == 3.0
    assert body.at(0.0).d_m == 1.0
    assert abs(float(body.at(t).d_m) - 1.0) <= abs(speed_d) * min(t, body.lateral_fade_s) + 1e-12


@given(speed_s=st.floats(1.0, 40.0), speed_d=st.floats(-3.0, 3.0), sign=st.sampled_from([-1.0, 1.0]))
def test_the_body_lies_along_its_course_forwards_and_backwards(speed_s, speed_d, sign):
    motion = cruising(speed_s_mps=sign * speed_s, speed_d_mps=speed_d).at(0.5)
    across = motion.speed_s_mps * np.sin(motion.heading_rad) - motion.speed_d_mps * np.cos(motion.heading_rad)
    assert across == pytest.approx(0.0, abs=1e-9)
    assert abs(motion.heading_rad) < np.pi / 2


@given(t=st.lists(st.floats(0.0, 10.0), min_size=1, max_size=8), speed_d=st.floats(-3.0, 3.0))
def test_many_times_at_once_are_each_time_alone(t, speed_d):
    body = cruising(speed_d_mps=speed_d)
    together = body.at(np.array(t))
    for k, one in enumerate(t):
        alone = body.at(one)
        for field in ("s_m", "d_m", "heading_rad", "speed_s_mps", "speed_d_mps"):
            assert getattr(together, field)[k] == pytest.approx(float(getattr(alone, field)), abs=1e-12)


@given(root=st.lists(st.floats(-1.0, 1.0), min_size=16, max_size=16))
def test_margins_never_exceed_their_cap_and_stand_still_after_the_growth(root):
    r = np.array(root).reshape(4, 4)
    body = cruising(covariance=r @ r.T)
    t = np.linspace(0.0, 6.0, 31)
    for margin, cap in ((body.margin_along_m(t), 3.0), (body.margin_across_m(t), 0.5)):
        assert np.all((margin >= 0.0) & (margin <= cap))
        assert np.ptp(margin[t >= 1.0]) == pytest.approx(0.0, abs=1e-12)
    assert body.margin_along_m(0.0) == pytest.approx(min(2.5 * np.sqrt(body.covariance[0, 0]), 3.0))


def test_a_known_body_has_its_script_and_no_margin():
    def motion(t):
        return BodyMotion(s_m=t**2, d_m=0.0 * t, heading_rad=0.0 * t, speed_s_mps=2.0 * t, speed_d_mps=0.0 * t)

    body = KnownBody(id="scripted", length_m=4.5, width_m=1.8, motion=motion)
    assert body.at([1.0, 2.0]).s_m.tolist() == [1.0, 4.0]
    assert body.margin_along_m([1.0, 2.0]).tolist() == body.margin_across_m([1.0, 2.0]).tolist() == [0.0, 0.0]


@given(speed=speeds, response=st.floats(0.1, 2.0), braking=st.floats(0.5, 9.0), known=st.booleans())
def test_who_responds_brakes_after_its_response_and_comes_to_rest(speed, response, braking, known):
    free = cruising(speed_s_mps=speed)
    before, t = np.linspace(0.0, response, 7), np.linspace(response, response + 1.1 * abs(speed) / braking + 0.1, 2001)
    scripted = KnownBody(id="scripted", length_m=4.5, width_m=1.8, motion=free.at)
    body = responding(scripted if known else free, response_s=response, braking_mps2=braking)
    assert responds(body)
    assert not responds(free)
    assert np.array_equal(body.at(before).s_m, free.at(before).s_m)
    motion = body.at(t[1:])
    travelled = np.concatenate([[0.0], np.cumsum(0.5 * (motion.speed_s_mps[1:] + motion.speed_s_mps[:-1]) * np.diff(t[1:]))])
    assert motion.s_m - motion.s_m[0] == pytest.approx(travelled, abs=1e-3)
    assert motion.speed_s_mps[-1] == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(motion.speed_s_mps) <= 1e-12).all()
    stop = free.s_m + speed * response + max(speed, 0.0) ** 2 / (2.0 * braking)
    assert motion.s_m[-1] == pytest.approx(stop, abs=1e-6)


@given(
    speed=speeds,
    rate=st.floats(-5.0, 3.0),
    until=st.floats(0.0, 2.0),
    response=st.floats(0.0, 2.0),
    braking=st.floats(0.5, 9.0),
    more=st.floats(0.5, 9.0),
)
def test_the_one_closed_form_responds_as_whoever_moves_otherwise(speed, rate, until, response, braking, more):
    """The same to the bit, alone or together with others; and who responds already goes on so until it responds again."""
    free = cruising(speed_s_mps=speed, acceleration_mps2=rate, changing_s=until, lateral_swell=2.0, speed_d_mps=0.7)
    scripted = KnownBody(id="scripted", length_m=4.5, width_m=1.8, motion=free.at)
    t = np.linspace(0.0, 6.0, 61)
    one, other = (responding(body, response_s=response, braking_mps2=braking) for body in (free, scripted))
    assert one.at(t) == other.at(t) == together((free, one), t).part(1)
    assert together((free, one), t).part(0) == free.at(t)
    again, also = (responding(body, response_s=1.0, braking_mps2=more) for body in (one, other))
    assert again.at(t) == also.at(t)


def test_of_a_mixed_company_everybody_moves_as_alone() -> None:
    rng, t = np.random.default_rng(3), np.linspace(0.0, 6.0, 31)
    bodies: list[PredictedBody] = []
    for k in range(40):
        covariance = np.diag(rng.uniform(0.0, 0.3, 4))
        moves = dict(zip(("s_m", "d_m", "speed_s_mps", "speed_d_mps"), rng.uniform(-20.0, 20.0, 4).tolist(), strict=True))
        body = CruisingBody(id=str(k), length_m=4.5, width_m=1.8, covariance=covariance, **moves)
        changed: PredictedBody = body
        if k % 5 == 1:
            changed = replace(body, lateral_swell=rng.uniform(0.0, 9.0), acceleration_mps2=-3.0, changing_s=2.0)
        elif k % 5 == 2:
            changed = responding(body, response_s=1.0, braking_mps2=3.0)
        elif k % 5 == 3:
            changed = responding(responding(body, response_s=1.0, braking_mps2=2.0), response_s=0.5, braking_mps2=4.0)
        elif k % 5 == 4:
            motion = body.at(t)
            changed = KnownBody(id=str(k), length_m=4.5, width_m=1.8, motion=lambda _, motion=motion: motion)
        bodies.append(changed)
    rows, margins = together(bodies, t), margins_together(bodies, t)
    for j, one in enumerate(bodies):
        assert rows.part(j) == one.at(t)
        assert np.array_equal(margins[0][j], one.margin_along_m(t))
        assert np.array_equal(margins[1][j], one.margin_across_m(t))
