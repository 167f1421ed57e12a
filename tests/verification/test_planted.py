"""Every kind of violation, planted in legal drives: each is caught, by its name, with figures that JSON can hold."""

from __future__ import annotations

import json
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.verification.judge import judge, judge_all
from tests.verification.rollouts import WIDE, WIDE_CURVED, cruising, legal, names, roll_out, straight_on

seeds = st.integers(0, 10**9)
roads = st.sampled_from([WIDE, WIDE_CURVED])
COLUMNS = tuple(field.name for field in fields(Trajectory))
family = settings(max_examples=20, deadline=None)


def only(verdict: Verdict, name: str) -> float:
    """The value of the one violation there is, which bears that name."""
    assert names(verdict) == [name]
    assert not verdict.passed
    assert f"{name} " in verdict.reason
    json.dumps(to_document(verdict), allow_nan=False)
    return verdict.violations[0].value


@family
@given(seed=seeds, road=roads, column=st.sampled_from(COLUMNS), bad=st.sampled_from([np.nan, np.inf, -np.inf]), share=st.floats(0.0, 1.0))
def test_not_finite(seed, road, column, bad, share):
    drive = legal(seed, road)
    values = getattr(drive.trajectory, column).copy()
    values[int(share * (values.size - 1))] = bad
    verdict = drive.with_columns(**{column: values}).verdict()
    assert only(verdict, "not finite") == 1.0
    assert all(value is not None for violation in to_document(verdict)["violations"] for value in violation.values())


@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 50), road=roads, data=st.data())
def test_whatever_numbers_stand_in_it_there_is_a_finite_verdict(seed, road, data):
    """Any column, any index, any float at all: never an exception, a warning or a NaN; and nothing absurd is let through."""
    drive = legal(seed, road, duration_s=1.0)
    table = {name: getattr(drive.trajectory, name).copy() for name in COLUMNS}
    for _ in range(data.draw(st.integers(1, 4))):
        column = data.draw(st.sampled_from(COLUMNS))
        table[column][data.draw(st.integers(0, len(drive.trajectory) - 1))] = data.draw(st.floats(width=64))
    verdict = drive.with_columns(**table).verdict()
    json.dumps(to_document(verdict), allow_nan=False)
    assert all(np.isfinite([v.t_s, v.value, v.limit]).all() for v in verdict.violations)
    if not all((np.abs(values) <= 1e5).all() for values in table.values()):
        assert not verdict.passed


@family
@given(seed=seeds, share=st.floats(0.0, 0.99), back=st.floats(0.0, 0.5))
def test_time_that_stands_or_runs_back(seed, share, back):
    drive = legal(seed)
    t = drive.trajectory.t_s.copy()
    k = int(share * (t.size - 1))
    t[k + 1 :] -= t[k + 1] - t[k] + back
    assert only(drive.with_columns(t_s=t).verdict(), "time not monotone") <= 0.0


@family
@given(seed=seeds, late=st.floats(0.001, 5.0))
def test_time_that_does_not_begin_at_0(seed, late):
    drive = legal(seed)
    assert only(drive.with_columns(t_s=drive.trajectory.t_s + late).verdict(), "start time") == pytest.approx(late)


@family
@given(step=st.floats(0.102, 0.5), speed=st.floats(1.0, 30.0))
def test_samples_too_far_apart(step, speed):
    drive = straight_on(speed)
    t = step * np.arange(8)
    columns = {name: np.zeros(8) for name in COLUMNS} | {"t_s": t, "s_m": speed * t, "speed_mps": np.full(8, speed)}
    assert only(drive.with_columns(**columns).verdict(), "sampling") == pytest.approx(step)


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_samples(count):
    drive = straight_on()
    columns = {name: getattr(drive.trajectory, name)[:count] for name in COLUMNS}
    assert only(drive.with_columns(**columns).verdict(), "sampling") == count


@family
@given(seed=seeds, road=roads, side=st.sampled_from([-1.0, 1.0]))
@pytest.mark.parametrize(
    ("field", "name", "more", "less"),
    [
        ("s_m", "start position", 0.025, 0.015),
        ("d_m", "start position", 0.025, 0.015),
        ("heading_rad", "start heading", 0.012, 0.008),
        ("heading_rad", "start heading", 3.0, 2.0 * np.pi),
        ("speed_mps", "start speed", 0.06, 0.04),
        ("acceleration_mps2", "start acceleration", 0.12, 0.08),
        ("steering_rad", "start steering", 0.006, 0.004),
    ],
)
def test_a_start_elsewhere(field, name, more, less, seed, road, side):
    drive = legal(seed, road, duration_s=1.0)
    there = getattr(drive.start, field)
    assert only(drive.verdict(start=replace(drive.start, **{field: there + side * more})), name) == pytest.approx(more)
    assert drive.verdict(start=replace(drive.start, **{field: there + side * less})).passed


@family
@given(seed=seeds, road=roads, share=st.floats(0.05, 0.9), side=st.sampled_from([-1.0, 1.0]))
@pytest.mark.parametrize(
    ("column", "jump"),
    [("s_m", 0.03), ("d_m", 0.03), ("heading_rad", 0.004), ("speed_mps", 0.05), ("acceleration_mps2", 0.1), ("steering_rad", 0.004)],
)
def test_a_jump_in_the_middle(column, jump, seed, road, share, side):
    drive = legal(seed, road)
    values = getattr(drive.trajectory, column).copy()
    k = 1 + int(share * (values.size - 2))
    values[k:] += side * jump
    verdict = drive.with_columns(**{column: values}).verdict()
    assert "dynamics residual" in names(verdict)
    found = next(v for v in verdict.violations if v.name == "dynamics residual")
    assert found.t_s == pytest.approx(drive.trajectory.t_s[k])


@family
@given(seed=seeds, road=roads, share=st.floats(0.05, 0.9), jump=st.floats(0.05, 2.0))
def test_a_jump_that_takes_itself_back(seed, road, share, jump):
    drive = legal(seed, road)
    d = drive.trajectory.d_m.copy()
    d[1 + int(share * (d.size - 3))] += jump
    assert "dynamics residual" in names(drive.with_columns(d_m=d).verdict())


@family
@given(seed=seeds, side=st.sampled_from([-1.0, 1.0]), column=st.sampled_from(["s_m", "d_m"]))
def test_a_drift_too_slow_for_any_interval_is_seen_at_the_end(seed, side, column):
    drive = legal(seed)
    steps = np.arange(len(drive.trajectory))
    drift = side * 0.004 * steps
    values = getattr(drive.trajectory, column) + drift
    assert only(drive.with_columns(**{column: values}).verdict(), "re-integrated end") == pytest.approx(abs(drift[-1]), abs=1e-3)


@family
@given(seed=seeds)
def test_inputs_that_are_not_what_was_driven(seed):
    drive = legal(seed)
    rate = 0.8 * drive.trajectory.steering_rate_radps[::-1]
    jerk = 0.8 * drive.trajectory.jerk_mps3[::-1]
    for columns in ({"steering_rate_radps": rate}, {"jerk_mps3": jerk}):
        assert "dynamics residual" in names(drive.with_columns(**columns).verdict())


# Each limit of the vehicle is drawn in until the drive's own extreme lies just within, and just beyond, the tolerance of 1 %.
LIMITS = [
    ("speed", "speed_max_mps", "speed_mps", 1.0),
    ("acceleration", "acceleration_max_mps2", "acceleration_mps2", 1.0),
    ("acceleration", "acceleration_min_mps2", "acceleration_mps2", -1.0),
    ("jerk", "jerk_max_mps3", "jerk_mps3", 1.0),
    ("jerk", "jerk_min_mps3", "jerk_mps3", -1.0),
    ("steering angle", "steering_max_rad", "steering_rad", 0.0),
    ("steering rate", "steering_rate_max_radps", "steering_rate_radps", 0.0),
]


@family
@given(seed=seeds, road=roads)
@pytest.mark.parametrize(("name", "limit", "column", "side"), LIMITS)
def test_every_limit_of_the_vehicle_to_one_per_cent(name, limit, column, side, seed, road):
    drive = legal(seed, road)
    values = getattr(drive.trajectory, column)
    extreme = float(np.abs(values).max() if side == 0.0 else side * (side * values).max())
    assume(abs(extreme) > 0.02 and (side == 0.0 or side * extreme > 0.0))
    if limit == "speed_max_mps":  # the parabola between the samples counts too
        t, v, a, jerk = drive.trajectory.t_s, drive.trajectory.speed_mps, drive.trajectory.acceleration_mps2, drive.trajectory.jerk_mps3
        fine = [v[k] + a[k] * q + 0.5 * jerk[k] * q**2 for k in range(len(t) - 1) for q in np.linspace(0.0, t[k + 1] - t[k], 6)]
        extreme = max(fine)
    beyond = drive.verdict(vehicle=replace(drive.vehicle, **{limit: extreme / 1.012}))
    found = only(beyond, name)
    assert found == pytest.approx(extreme, rel=1e-6) or (side == 0.0 and found == pytest.approx(-extreme, rel=1e-6))
    assert drive.verdict(vehicle=replace(drive.vehicle, **{limit: extreme / 1.008})).passed


def test_a_speed_that_peaks_between_samples():
    """Acceleration through 0 in the middle of an interval: the samples stay below the limit, the car does not."""
    drive = straight_on(20.0)
    vehicle = replace(drive.vehicle, acceleration_max_mps2=3.0, speed_max_mps=20.0)
    x0 = (0.0, 0.0, 0.0, 20.18, 0.9, 0.0)
    t = np.array([0.0, 0.1, 0.2])
    trajectory = roll_out(x0, [(-18.0, 0.0), (0.0, 0.0)], t, WIDE, vehicle)
    assert trajectory.speed_mps.max() <= 20.2
    verdict = replace(drive, trajectory=trajectory, start=None, vehicle=vehicle).verdict()
    assert only(verdict, "speed") == pytest.approx(20.18 + 0.9**2 / 36.0, abs=1e-3)


@family
@given(speed=st.floats(0.0, 30.0), jerk=st.floats(-30.0, -5.0))
def test_nobody_reverses(speed, jerk):
    t = np.round(0.1 * np.arange(31), 9)
    drive = straight_on()
    inputs = np.zeros((30, 2))
    inputs[:2, 0] = jerk
    trajectory = roll_out((0.0, 0.0, 0.0, speed, 0.0, 0.0), inputs, t, WIDE, drive.vehicle)
    verdict = replace(drive, trajectory=trajectory, start=None).verdict()
    if trajectory.speed_mps.min() < -0.01:
        found = next(v for v in verdict.violations if v.name == "speed")
        assert found.value == pytest.approx(trajectory.speed_mps.min(), abs=1e-9)
        assert found.limit == 0.0
    else:
        assert "speed" not in names(verdict)


@family
@given(seed=seeds, road=roads)
def test_friction_to_two_per_cent(seed, road):
    drive = legal(seed, road)
    x = drive.trajectory
    total = np.hypot(x.acceleration_mps2, x.speed_mps**2 * np.tan(x.steering_rad) / drive.vehicle.wheelbase_m).max()
    beyond = drive.verdict(road=replace(road, friction=float(total / GRAVITY_MPS2 / 1.025)))
    assert only(beyond, "friction circle") >= total - 1e-9
    assert beyond.violations[0].unit == "m/s^2"
    # the extreme may lie a little above the samples', between two of them
    assert drive.verdict(road=replace(road, friction=float(total / GRAVITY_MPS2 / 1.005))).passed


def test_friction_is_a_circle_and_no_box():
    drive = legal(11)
    x = drive.trajectory
    along = np.abs(x.acceleration_mps2)
    across = np.abs(x.speed_mps**2 * np.tan(x.steering_rad) / drive.vehicle.wheelbase_m)
    total = np.hypot(along, across)
    k = int(total.argmax())
    box = max(along.max(), across.max())
    assert total[k] > 1.05 * box, "choose a drive that brakes in a bend"
    assert names(drive.verdict(road=replace(WIDE, friction=float(box * 1.01 / GRAVITY_MPS2)))) == ["friction circle"]


@settings(max_examples=10, deadline=None)
@given(seed=seeds, road=roads)
def test_many_are_judged_as_each_is_alone(seed, road):
    """Sound ones, ones with every kind of fault, unreadable ones and ones of other times, in one call."""
    drive = legal(seed, road)
    sound, table = drive.trajectory, {name: getattr(drive.trajectory, name) for name in COLUMNS}
    wrong = [drive.with_columns(**{name: table[name] * 1.5 + 0.3}).trajectory for name in COLUMNS if name != "t_s"]
    broken = drive.with_columns(d_m=np.full(len(sound), np.nan)).trajectory
    many = [sound, *wrong, broken, straight_on(road=road).trajectory, sound]
    beside = Prediction(name="cars", bodies=(cruising("a", 8.0, 1.0, 15.0), cruising("b", -9.0, -1.0, 20.0)))
    together = judge_all(many, drive.start, drive.vehicle, road, beside)
    for verdict, one in zip(together, many, strict=True):
        alone = judge(one, drive.start, drive.vehicle, road, beside)
        assert names(verdict) == names(alone)
        assert [v.value for v in verdict.violations] == pytest.approx([v.value for v in alone.violations], rel=1e-9, abs=1e-12)
