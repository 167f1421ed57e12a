"""Collisions against shapely, looked at every two milliseconds; mirrored scenes; neighbours that are nowhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.prediction import BodyMotion, KnownBody, Prediction
from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners
from tests.verification.rollouts import WIDE, WIDE_CURVED, cruising, legal, names, roll_out, straight_on

both_roads = pytest.mark.parametrize("road", [WIDE, WIDE_CURVED], ids=["straight", "curved"])
_FINE = {road: FrenetFrame(road=road, s_min_m=-300.0, s_max_m=500.0) for road in (WIDE, WIDE_CURVED)}


def meeting(seed, road, contact):
    """A legal drive, and a neighbour that comes near the host's pose at some instant: so near that about half of them touch."""
    rng = np.random.default_rng(seed)
    drive = legal(int(rng.integers(0, 60)), road, duration_s=1.5)
    k = int(rng.integers(0, len(drive.trajectory)))
    x = drive.trajectory
    length, width = (rng.uniform(0.2, 1.0), rng.uniform(0.2, 1.0)) if seed % 2 else (rng.uniform(2.0, 16.0), rng.uniform(1.5, 2.5))
    speed_s, speed_d = rng.uniform(-40.0, 60.0), rng.uniform(-15.0, 15.0)
    aside = rng.uniform(-1.0, 1.0) * (1.4 + contact * 0.5 * width)
    ahead = rng.uniform(-1.0, 1.0) * (2.6 + contact * 0.5 * length)
    s = x.s_m[k] + ahead - speed_s * x.t_s[k]
    d = x.d_m[k] + aside - speed_d * x.t_s[k]
    return drive, cruising("other", s, d, speed_s, speed_d, rng.uniform(-0.6, 0.6), length, width)


def shapes(drive, body):
    """Shapely polygons of host and neighbour every two milliseconds of the drive."""
    x, u = drive.trajectory, drive.trajectory.inputs
    counts = np.round(np.diff(x.t_s) / 0.002).astype(int)
    pieces = []
    for k, count in enumerate(counts):
        t = np.linspace(x.t_s[k], x.t_s[k + 1], count + 1)
        pieces.append(roll_out(x.states[k], [u[k]] * count, t, drive.road, drive.vehicle, substeps=1))
    t = np.concatenate([p.t_s for p in pieces])
    frame = _FINE[drive.road]
    host = frame.to_plane(*(np.concatenate([getattr(p, name) for p in pieces]) for name in ("s_m", "d_m", "heading_rad")))
    path = body.at(t)
    other = frame.to_plane(path.s_m, path.d_m, path.heading_rad)
    return (
        shapely.polygons(corners(*host, drive.vehicle.length_m, drive.vehicle.width_m)),
        shapely.polygons(corners(*other, body.length_m, body.width_m)),
    )


@both_roads
def test_shapely_agrees_on_who_touches(road):
    """Whatever overlaps at any of these instants is convicted; whoever stays a centimetre clear is not. Thin, fast, long bodies alike."""
    convicted = clear = 0
    for seed in range(40):
        drive, body = meeting(seed, road, contact=1.2 + (seed % 3) * 0.4)
        verdict = replace(drive, prediction=Prediction(name="one", bodies=(body,))).verdict()
        host, other = shapes(drive, body)
        if shapely.area(shapely.intersection(host, other)).max() > 1e-6:
            assert names(verdict) == ["collision with other"], seed
            assert verdict.violations[0].value < 0.0
            convicted += 1
        elif shapely.distance(host, other).min() > 0.01:
            assert verdict.passed, (seed, verdict.reason)
            clear += 1
    assert convicted > 10
    assert clear > 5


@settings(max_examples=40, deadline=None)
@given(gap=st.floats(-0.5, 0.5), speed=st.floats(2.0, 30.0), ahead=st.booleans())
def test_bumper_to_bumper_the_sign_of_the_gap_decides(gap, speed, ahead):
    drive = straight_on(speed)
    s = (4.5 + gap) * (1.0 if ahead else -1.0)
    verdict = replace(drive, prediction=Prediction(name="one", bodies=(cruising("other", s, 0.0, speed),))).verdict()
    if gap < -1e-6:
        assert names(verdict) == ["collision with other"]
        assert verdict.violations[0].value == pytest.approx(max(gap, -1.8), abs=1e-9)
        assert verdict.violations[0].t_s == 0.0
    elif gap > 1e-6:
        assert verdict.passed


@pytest.mark.parametrize("speed", [20.0, 100.0, 300.0, 1000.0])
@pytest.mark.parametrize("offset", [0.0, 0.003, 0.006, 0.01])
def test_a_thin_crosser_does_not_tunnel(speed, offset):
    """A post of 5 cm, crossing within less than a fine step, between the fine instants."""
    drive = straight_on(20.0)
    cross = cruising("post", 20.0 * (1.0 + offset), speed * (1.0 + offset), 0.0, -speed, 0.0, 0.05, 0.05)
    verdict = replace(drive, prediction=Prediction(name="one", bodies=(cross,))).verdict()
    assert names(verdict) == ["collision with post"]
    assert verdict.violations[0].t_s == pytest.approx(1.0 + offset, abs=0.12)


def test_a_swerve_between_the_fine_instants_is_seen():
    """Two centimetres clear at every fine instant, touching halfway between them."""
    drive = straight_on(20.0)

    def motion(t):
        one = np.ones_like(t)
        return BodyMotion(
            s_m=20.0 * t,
            d_m=1.82 - 0.03 * np.sin(np.pi * t / 0.02) ** 2,
            heading_rad=0.0 * one,
            speed_s_mps=20.0 * one,
            speed_d_mps=0.0 * one,
        )

    swerving = KnownBody(id="swerving", length_m=4.5, width_m=1.8, motion=motion)
    assert names(replace(drive, prediction=Prediction(name="one", bodies=(swerving,))).verdict()) == ["collision with swerving"]


def test_the_first_contact_and_the_deepest_overlap_are_told():
    drive = straight_on(20.0)
    stopped = cruising("wall", 24.5, 0.0, 0.0)
    found = replace(drive, prediction=Prediction(name="one", bodies=(stopped,))).verdict().violations
    assert [v.name for v in found] == ["collision with wall"]
    assert found[0].t_s == pytest.approx(1.0, abs=0.021)
    assert found[0].value == pytest.approx(-1.8, abs=1e-6)
    assert (found[0].limit, found[0].unit) == (0.0, "m")


def test_each_neighbour_is_named():
    drive = straight_on(20.0)
    bodies = (cruising("front", 10.0, 0.0, 10.0), cruising("left", 0.0, 3.7, 20.0), cruising("rear", -10.0, 0.0, 30.0))
    assert names(replace(drive, prediction=Prediction(name="three", bodies=bodies)).verdict()) == [
        "collision with front",
        "collision with rear",
    ]


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(2, 40))
@both_roads
def test_of_many_each_is_convicted_as_it_is_alone(road, seed, count):
    others = [replace(meeting(seed + i, road, contact=1.6)[1], id=str(i)) for i in range(count)]
    drive, nearest = meeting(seed, road, contact=1.1)
    bodies = [*others, replace(nearest, id="nearest")]

    def convicted(bodies):
        verdict = replace(drive, prediction=Prediction(name="some", bodies=tuple(bodies))).verdict()
        return [v for v in verdict.violations if v.kind is ViolationKind.COLLISION]

    alone = [violation for body in bodies for violation in convicted([body])]
    together = convicted(bodies)
    assert [v.body for v in together] == [v.body for v in sorted(alone, key=lambda v: (v.t_s, v.value))]
    for violation in together:
        same = next(v for v in alone if v.body == violation.body)
        assert violation.t_s == same.t_s
        assert violation.value == pytest.approx(same.value, abs=1e-9)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6))
@both_roads
def test_mirrored_scenes_have_mirrored_verdicts(road, seed):
    drive, body = meeting(seed, road, contact=1.1)
    narrow = replace(road, shoulder_left_m=0.5, shoulder_right_m=2.0, lanes_left=1)
    drive = replace(drive, road=narrow, prediction=Prediction(name="one", bodies=(body,)))
    x = drive.trajectory
    mirrored_road = replace(
        narrow,
        lanes_left=0,
        lanes_right=1,
        shoulder_left_m=2.0,
        shoulder_right_m=0.5,
        curvature=tuple((s, -k) for s, k in narrow.curvature),
    )
    h = drive.start

    def motion(t):
        path = body.at(t)
        return replace(path, d_m=-path.d_m, heading_rad=-path.heading_rad, speed_d_mps=-path.speed_d_mps)

    other = replace(
        drive,
        road=mirrored_road,
        start=replace(h, d_m=-h.d_m, heading_rad=-h.heading_rad, steering_rad=-h.steering_rad),
        trajectory=replace(
            x, d_m=-x.d_m, heading_rad=-x.heading_rad, steering_rad=-x.steering_rad, steering_rate_radps=-x.steering_rate_radps
        ),
        prediction=Prediction(name="one", bodies=(KnownBody(id="other", length_m=body.length_m, width_m=body.width_m, motion=motion),)),
    )
    swap = {"left road edge": "right road edge", "right road edge": "left road edge"}
    ours, theirs = drive.verdict().violations, other.verdict().violations
    assert sorted(swap.get(v.name, v.name) for v in theirs) == sorted(v.name for v in ours)
    for one in ours:
        two = next(v for v in theirs if swap.get(v.name, v.name) == one.name)
        assert two.t_s == pytest.approx(one.t_s)
        assert abs(two.value) == pytest.approx(abs(one.value), abs=1e-6)


@pytest.mark.parametrize("road", [WIDE, WIDE_CURVED], ids=["straight", "curved"])
def test_a_neighbour_that_is_nowhere_is_not_clear(road):
    def motion(t):
        lost = np.where(t > 1.0, np.nan, 200.0)
        one = np.ones_like(t)
        return BodyMotion(s_m=lost, d_m=one, heading_rad=0.0 * one, speed_s_mps=one, speed_d_mps=one)

    body = KnownBody(id="ghost", length_m=4.5, width_m=1.8, motion=motion)
    verdict = replace(legal(3, road), prediction=Prediction(name="one", bodies=(body,))).verdict()
    assert names(verdict) == ["prediction of ghost not finite"]
    assert verdict.violations[0].t_s == pytest.approx(1.0, abs=0.021)
    assert np.isfinite(verdict.violations[0].value)


def test_the_place_above_a_ramp_is_another_place():
    """A road that turns full circle passes over itself: a neighbour one turn ahead does not stand in the host."""
    ramp = replace(WIDE, shoulder_left_m=5.0, shoulder_right_m=5.0, curvature=((0.0, 1.0 / 50.0),))
    drive = legal(5, ramp, duration_s=1.0)
    one_turn = 2.0 * np.pi * 50.0
    above = cruising("above", one_turn, 0.0, float(drive.start.speed_mps))
    beside = cruising("beside", 2.0, 0.0, float(drive.start.speed_mps))
    verdict = replace(drive, prediction=Prediction(name="two", bodies=(above, beside))).verdict()
    assert "collision with above" not in names(verdict)
    assert "collision with beside" in names(verdict)


def test_a_neighbour_kilometres_away_needs_no_road_there():
    drive = legal(5, WIDE_CURVED)
    far = cruising("far", 1e7, 0.0, 10.0)
    assert replace(drive, prediction=Prediction(name="one", bodies=(far,))).verdict().passed
