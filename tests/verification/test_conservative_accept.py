"""The judge's conservative fast accept: never of what the array operations find fault with, and nearly always of what a car can drive."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.prediction import CruisingBody, KnownBody, Prediction, responding
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.native.form import SWITCH
from mcdas_opt.native.library import library
from mcdas_opt.verification import judge as judging
from mcdas_opt.verification.conservative_accept import doubtful_bodies, rows_of, rules_of
from tests.verification.rollouts import BENDS, WIDE, WIDE_CURVED, Drive, changing, cruising, legal

TURN = Road(shoulder_left_m=3.0, shoulder_right_m=3.0, curvature=((0.0, 0.0), (15.0, 0.0), (21.0, 0.06), (29.0, 0.06), (35.0, 0.0)))
seeds = st.integers(0, 10**9)
rates = st.floats(0.5, 9.0)
both_roads = pytest.mark.parametrize("road", [WIDE, WIDE_CURVED], ids=["straight", "curved"])
COLUMNS = ("s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad", "steering_rate_radps", "jerk_mps3")


def accepted(drive: Drive) -> bool:
    """Where there is no compiler the fast accept is the array operations' own."""
    compiled = library()
    if compiled is None:
        return examined(drive)
    table = drive.trajectory.table
    rules = rules_of(drive.vehicle, drive.road, judging.ALONG_REACHES)
    bodies = rows_of(drive.prediction.bodies)
    frame = judging._frame(table[1], drive.vehicle, drive.road, drive.prediction)
    return doubtful_bodies(compiled, table, drive.start, rules, bodies, frame) == []


def examined(drive: Drive) -> bool:
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv(SWITCH, "0")
        return drive.verdict().passed


def follower_of(x: Trajectory, behind_m: float, speed_mps: float) -> CruisingBody:
    """Somebody so far behind where the drive begins, in its line."""
    s_m, d_m = float(x.s_m[0]) - behind_m, float(x.d_m[0])
    moves = {"s_m": s_m, "d_m": d_m, "speed_s_mps": speed_mps, "speed_d_mps": 0.0}
    return CruisingBody(id="behind", length_m=4.5, width_m=1.8, covariance=np.zeros((4, 4)), **moves)


@settings(max_examples=60, deadline=None)
@given(seed=seeds)
@both_roads
def test_what_a_car_can_drive_is_accepted(road, seed):
    assert accepted(legal(seed, road))


@settings(max_examples=150, deadline=None)
@given(seed=seeds, column=st.sampled_from(COLUMNS), size=st.floats(-4.0, 0.5))
@both_roads
def test_a_fault_of_any_size_is_never_accepted(road, seed, column, size):
    """One sample is pushed by 10^size tolerances or so: where the array operations object, it is not accepted."""
    drive, rng = legal(seed, road), np.random.default_rng(seed)
    values = np.array(getattr(drive.trajectory, column))
    values[rng.integers(values.size)] += rng.choice([-1.0, 1.0]) * 10.0**size
    drive = drive.with_columns(**{column: values})
    assert not accepted(drive) or examined(drive)


@settings(max_examples=150, deadline=None)
@given(seed=seeds)
@both_roads
def test_nobody_is_touched_by_what_is_accepted(road, seed):
    """A body that crosses the drive's own way somewhere, or just misses it: it is accepted only where nobody is touched."""
    drive, rng = legal(seed, road), np.random.default_rng(seed)
    t = drive.trajectory
    k = int(rng.integers(len(t)))
    speed, sideways = rng.uniform(-5.0, 30.0), rng.uniform(-3.0, 3.0)
    swell = rng.choice([0.0, rng.uniform(0.0, 12.0)])
    change, until = rng.choice([0.0, rng.uniform(-8.0, 4.0)]), rng.uniform(0.0, 5.0)
    lasting = min(t.t_s[k], until)
    fade = (1.0 + swell) * (1.0 - np.exp(-t.t_s[k])) / (1.0 + swell * np.exp(-t.t_s[k]))
    body = CruisingBody(
        id="1",
        length_m=rng.uniform(0.5, 12.0),
        width_m=rng.uniform(0.4, 2.5),
        s_m=float(t.s_m[k] - speed * t.t_s[k] - change * lasting * (t.t_s[k] - 0.5 * lasting) + rng.uniform(-9.0, 9.0)),
        d_m=float(t.d_m[k] - sideways * fade + rng.uniform(-4.0, 4.0)),
        speed_s_mps=speed,
        speed_d_mps=sideways,
        lateral_swell=swell,
        acceleration_mps2=change,
        changing_s=until,
        covariance=np.zeros((4, 4)),
    )
    drive = replace(drive, prediction=Prediction(name="one", bodies=(body,)))
    assert not accepted(drive) or examined(drive)


@settings(max_examples=40, deadline=None)
@given(seed=seeds, share=st.floats(0.2, 1.5))
@both_roads
def test_nor_is_the_road_left(road, seed, share):
    """The road's edge and its end are drawn about where the drive comes to."""
    drive = legal(seed, road)
    reach = float(np.abs(drive.trajectory.d_m).max()) * share
    narrow = replace(road, shoulder_left_m=reach, shoulder_right_m=reach, road_end_s_m=float(drive.trajectory.s_m[-1]) + 4.0 * share)
    drive = replace(drive, road=narrow)
    assert not accepted(drive) or examined(drive)


def between_changing_edges(seed: int, bend: tuple[tuple[float, float], ...]) -> Drive | None:
    """A drive in the plane, on a road whose edges change about where it goes; None where it comes near a bend's centre."""
    drive = legal(seed, replace(WIDE, shoulder_left_m=10.0, shoulder_right_m=10.0, curvature=bend))
    sharpest = max(abs(kappa) for _, kappa in bend)
    if sharpest * (float(np.abs(drive.trajectory.d_m).max()) + 3.0) > 0.8:
        return None
    return replace(drive, road=changing(seed, bend))


@settings(max_examples=150, deadline=None)
@given(seed=seeds)
@pytest.mark.parametrize("bend", [*BENDS, TURN.curvature], ids=["straight", "curved", "turn"])
def test_nor_is_it_between_edges_that_change(bend: tuple[tuple[float, float], ...], seed: int) -> None:
    drive = between_changing_edges(seed, bend)
    assume(drive is not None)
    assert drive is not None
    assert not accepted(drive) or examined(drive)


@pytest.mark.parametrize("bend", [*BENDS, TURN.curvature], ids=["straight", "curved", "turn"])
def test_what_passes_between_edges_that_change_is_nearly_always_accepted(bend: tuple[tuple[float, float], ...]) -> None:
    drives = [drive for seed in range(150) if (drive := between_changing_edges(seed, bend)) is not None]
    passing = [drive for drive in drives if examined(drive)]
    assert 20 < len(passing) < len(drives)
    assert sum(map(accepted, passing)) >= 0.95 * len(passing)


@both_roads
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e9])
def test_no_number_is_never_accepted(road, value):
    drive = legal(7, road)
    for column in COLUMNS:
        values = np.array(getattr(drive.trajectory, column))
        values[3] = value
        assert not drive.with_columns(**{column: values}).verdict().passed
    lost = CruisingBody(
        id="1", length_m=4.5, width_m=1.8, s_m=value, d_m=0.0, speed_s_mps=0.0, speed_d_mps=0.0, covariance=np.zeros((4, 4))
    )
    if not np.isfinite(value):
        assert not accepted(replace(drive, prediction=Prediction(name="lost", bodies=(lost,))))


@settings(max_examples=40, deadline=None)
@given(seed=seeds, column=st.sampled_from(COLUMNS))
@both_roads
def test_the_verdict_does_not_depend_on_the_form(road, seed, column):
    drive = legal(seed, road)
    values = np.array(getattr(drive.trajectory, column))
    values[len(values) // 2] += 0.03
    drive = drive.with_columns(**{column: values})
    quick = drive.verdict()
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv(SWITCH, "0")
        assert drive.verdict() == quick


@settings(max_examples=40, deadline=None)
@given(seed=seeds, ahead_m=st.floats(-15.0, 40.0), aside_m=st.floats(-6.0, 6.0), speed=st.floats(-5.0, 20.0), across=st.floats(-8.0, 8.0))
@pytest.mark.parametrize("road", [WIDE, WIDE_CURVED, TURN], ids=["straight", "curved", "turn"])
def test_who_is_looked_at_alone_is_touched_as_by_everybody(road, seed, ahead_m, aside_m, speed, across):
    """Where one of the bodies moves as the C text does not know, or is near, the verdict has the same collisions."""
    drive = legal(seed, road)
    assume(0.06 * float(np.abs(drive.trajectory.d_m).max()) < 0.9)
    known = CruisingBody(
        id="known",
        length_m=4.5,
        width_m=1.8,
        s_m=aside_m,
        d_m=0.2 * ahead_m,
        speed_s_mps=speed,
        speed_d_mps=0.0,
        covariance=np.zeros((4, 4)),
    )
    drive = replace(drive, prediction=Prediction(name="test", bodies=(cruising("free", ahead_m, aside_m, speed, across), known)))
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv(SWITCH, "0")
        whole = drive.verdict()
    assert drive.verdict() == whole


@settings(max_examples=150, deadline=None)
@given(
    seed=seeds, behind_m=st.floats(-20.0, 40.0), faster=st.floats(-10.0, 15.0), response=st.floats(0.0, 2.0), braking=st.floats(0.5, 9.0)
)
@pytest.mark.parametrize("road", [WIDE, WIDE_CURVED], ids=["straight", "curved"])
def test_who_responds_is_judged_as_whoever_moves_so(road, seed, behind_m, faster, response, braking):
    """What is accepted of a follower who brakes after a while is so of one with his motion, of whom the C text is told nothing."""
    drive = legal(seed, road)
    x = drive.trajectory
    speed = max(float(x.speed_mps[0]) + faster, 0.0)
    free = follower_of(x, behind_m + 4.5, speed)
    follower = responding(free, response_s=response, braking_mps2=braking)
    scripted = KnownBody(id="behind", length_m=free.length_m, width_m=free.width_m, motion=follower.at)
    followed, known = (replace(drive, prediction=Prediction(name="followed", bodies=(body,))) for body in (follower, scripted))
    assert not accepted(followed) or known.verdict().passed
    assert followed.verdict() == known.verdict()


def test_who_keeps_his_distance_and_responds_is_accepted_at_once():
    drive = legal(3, WIDE)
    x = drive.trajectory
    free = follower_of(x, 40.0, max(float(x.speed_mps.min()) - 1.0, 0.0))
    follower = responding(free, response_s=1.0, braking_mps2=4.0)
    assert accepted(replace(drive, prediction=Prediction(name="followed", bodies=(follower,))))
