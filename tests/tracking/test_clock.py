"""A clock that is set back, or jumps ahead: nothing that was remembered is true any more, and it is said so."""

from __future__ import annotations

import math
import warnings
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Mounting, RadarDetection, Scan
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vocabulary import Sector, Status
from mcdas_opt.planning.measurement.standing_clock import CYCLES
from mcdas_opt.planning.planner import Planner
from mcdas_opt.tracking.tracker import Tracker
from tests.tracking.worlds import STRAIGHT, host_at, ideal_scan, radar_scan

BLIND = Coverage(front=False, rear=False, left=False, right=False)
YEAR_S = 365.25 * 86400.0
JUMPS = [-10.0 * YEAR_S, -3600.0, -5.0, -0.3, 1.5, 5.0, 3600.0, 10.0 * YEAR_S]


def lead(t: float) -> list[Body]:
    return [Body(name="lead", s_m=40.0 + 13.0 * t, speed_mps=13.0)]


def fed(start_s: float = 0.0, scan_of=radar_scan) -> Tracker:
    """A tracker that has followed a car for a second from `start_s` on."""
    tracker = Tracker()
    for k in range(21):
        t = 0.05 * k
        tracker.update([replace(scan_of(t, lead(t)), t_s=start_s + t)], host_at(t), STRAIGHT, start_s + t)
    assert len(tracker.tracks(start_s + 1.0)) == 1
    return tracker


@pytest.mark.parametrize("jump_s", JUMPS)
@pytest.mark.parametrize("scan_of", [radar_scan, ideal_scan])
def test_no_track_outlives_a_jump_of_the_clock(jump_s: float, scan_of) -> None:
    tracker = fed(1000.0, scan_of)
    now = 1001.0 + jump_s
    assert tracker.tracks(now) == ()
    assert tracker.coverage(now) == BLIND
    tracker.update([], host_at(1.0), STRAIGHT, now)
    assert tracker.tracks(now) == ()
    assert tracker.coverage(now) == BLIND
    assert tracker.counters["clock_back" if jump_s < 0.0 else "clock_ahead"] == 1


@pytest.mark.parametrize("jump_s", JUMPS)
def test_after_a_jump_it_tracks_as_if_it_began(jump_s: float) -> None:
    tracker = fed(1000.0)
    for k in range(3):
        now = 1001.0 + jump_s + 0.05 * k
        tracker.update([replace(radar_scan(1.0 + 0.05 * k, lead(1.0 + 0.05 * k)), t_s=now)], host_at(1.0 + 0.05 * k), STRAIGHT, now)
        assert tracker.coverage(now).front == (k == 2)  # a road that nobody can be known on is not known to be empty
        assert len(tracker.tracks(now)) == (k == 2)
    (track,) = tracker.tracks(now)
    assert track.id == "2"  # numbers are not used twice
    assert track.s_m == pytest.approx(40.0 + 13.0 * 1.1, abs=0.5)
    assert tracker.counters["out_of_order"] == tracker.counters["duplicate"] == 0


def told() -> pytest.WarningsRecorder:
    return pytest.warns(UserWarning, match="milliseconds")


@pytest.mark.parametrize(
    ("kind", "behind_s"), [("stale", 1.5), ("stale", 3600.0), ("stale", 10.0 * YEAR_S), ("future", -0.1), ("future", -YEAR_S)]
)
def test_a_scan_of_another_time_begins_nothing(kind: str, behind_s: float) -> None:
    """Not even where no sensor was heard of before: its sector stays uncovered."""
    tracker = Tracker()
    for k in range(6):
        now = 1e6 + 0.05 * k
        with told() if behind_s < -1.0 and k == 0 else nullcontext():
            tracker.update([replace(radar_scan(0.0, lead(0.0)), t_s=now - behind_s)], host_at(0.0), STRAIGHT, now)
    assert tracker.counters[kind] == 6
    assert tracker.tracks(now) == ()
    assert tracker.coverage(now) == BLIND


def test_scans_in_milliseconds_are_told_once_and_planning_goes_on() -> None:
    planner, now = Planner(method="closed-form-corrected"), 1.8e9
    told = "scan of 'f', front: t_s = 1799999999980.0 is 1.7982e.12 s ahead of now = 1800000000.0, so that .*milliseconds?"
    for k in range(3):
        late = [replace(scan, t_s=1e3 * scan.t_s) for scan in scans(now + 0.1 * k, 55.0)]
        with pytest.warns(UserWarning, match=told) if k == 0 else nullcontext():
            plan = planner.step(late, HostState(speed_mps=20.0), now + 0.1 * k)
        assert plan.time_s == now + 0.1 * k
    assert planner.tracker.counters["future"] == 6
    planner.reset()
    with pytest.warns(UserWarning, match=told):
        planner.step([replace(scan, t_s=1e3 * scan.t_s) for scan in scans(now, 55.0)], HostState(speed_mps=20.0), now)


def test_whoever_gives_now_in_milliseconds_is_told_that_nobody_can_be_tracked() -> None:
    planner = Planner(method="closed-form-corrected")
    for k in range(4):
        now = 1e3 * (1000.0 + 0.1 * k)
        with pytest.warns(UserWarning, match="updates are 100 s apart.*Milliseconds?") if k == 2 else nullcontext():
            plan = planner.step(scans(now, 55.0), HostState(s_m=2.0 * k, speed_mps=20.0), now)
        assert planner.situation is not None
        assert planner.situation.coverage.front == (k == 0)
    assert not plan.situation.coverage.front
    assert planner.tracker.counters["clock_ahead"] == 3


def test_a_pause_is_nothing_to_be_told_of(recwarn) -> None:
    tracker = fed(1000.0)
    for now in (1003.0, 1003.05, 1008.0, 1008.05):
        tracker.update([replace(radar_scan(1.0, lead(1.0)), t_s=now)], host_at(1.0), STRAIGHT, now)
    assert tracker.counters["clock_ahead"] == 2
    assert not recwarn.list


def test_a_clock_that_jitters_is_no_clock_set_back() -> None:
    tracker = fed(1000.0)
    tracker.update([], host_at(1.0), STRAIGHT, 1000.98)
    assert len(tracker.tracks(1000.98)) == 1
    assert tracker.counters["clock_back"] == 0


STEPS = st.one_of(st.floats(-0.05, 0.6), st.floats(0.6, 2.0), st.floats(-10.0 * YEAR_S, 10.0 * YEAR_S))


@pytest.mark.filterwarnings("ignore:scan of:UserWarning")  # the host's place stands
@given(steps=st.lists(STEPS, min_size=1, max_size=40), lags=st.lists(st.floats(-0.1, 1.2), min_size=40, max_size=40), body=st.booleans())
def test_over_years_of_time_beliefs_stay_symmetric_definite_and_bounded(steps: list[float], lags: list[float], body: bool) -> None:
    """Whatever the clock does, and however old the scans are."""
    tracker, now = Tracker(), 1.7e9
    scan = ideal_scan(0.0, lead(0.0)) if body else radar_scan(0.0, lead(0.0))
    for step_s, lag_s in zip(steps, lags, strict=False):
        now += step_s
        for wait_s in (0.0, 0.05, 0.1):  # so that there are tracks to be spoilt
            now += wait_s
            tracker.update([replace(scan, t_s=now - lag_s)], HostState(speed_mps=13.0), STRAIGHT, now)
            for track in tracker.tracks(now):
                P = track.covariance
                assert np.array_equal(P, P.T)
                assert np.linalg.eigvalsh(P).min() >= -1e-9 * P.max()
                assert P.max() < 1e4  # m^2


def scans(now: float, gap: float | None) -> list[Scan]:
    """Front and rear radar, 20 ms old; a car 15 m/s slower `gap` ahead of the front one."""
    points = () if gap is None else (RadarDetection(range_m=gap, azimuth_rad=0.0, range_rate_mps=-15.0),)
    front = Scan(sensor="f", sector=Sector.FRONT, t_s=now - 0.02, mounting=Mounting(x_m=2.3), radar=points)
    return [front, Scan(sensor="b", sector=Sector.REAR, t_s=now - 0.02, mounting=Mounting(x_m=-2.3, yaw_rad=math.pi))]


@pytest.mark.parametrize("jump_s", [0.0, -0.3, -1.0, -5.0, -3600.0, 5.0, 3600.0])
def test_a_slower_car_is_seen_and_braked_for_whatever_the_clock_does(jump_s: float) -> None:
    planner, s = Planner(), 0.0
    for k in range(8):
        planner.step(scans(1000.0 + 0.1 * k, None), HostState(s_m=s, speed_mps=20.0), 1000.0 + 0.1 * k)
        s += 2.0
    gap = 55.0
    for k in range(4):
        now = 1000.8 + jump_s + 0.1 * k
        plan = planner.step(scans(now, gap), HostState(s_m=s, speed_mps=20.0), now)
        s, gap = s + 2.0, gap - 1.5
    assert planner.situation is not None
    assert len(planner.situation.tracks) == 1
    assert plan.trajectory.acceleration_mps2.min() < -1.0
    assert plan.status is not Status.UNAVOIDABLE


def test_while_no_sensor_answers_after_a_jump_the_plan_knows_that_it_is_blind() -> None:
    """The sensors' own clock has not been set back: their scans are in the future, and cover nothing."""
    planner = Planner()
    for k in range(8):
        planner.step(scans(1000.0 + 0.1 * k, None), HostState(s_m=2.0 * k, speed_mps=20.0), 1000.0 + 0.1 * k)
    for k in range(3):
        with told() if k == 0 else nullcontext():
            planner.step(scans(1000.8 + 0.1 * k, 55.0), HostState(s_m=16.0 + 2.0 * k, speed_mps=20.0), 995.0 + 0.1 * k)
        assert planner.situation is not None
        assert planner.situation.coverage == BLIND
    assert planner.tracker.counters["future"] == 6
    assert planner.tracker.counters["clock_back"] == 1


@pytest.mark.parametrize("step_s", [0.0, 1e-5])
@pytest.mark.parametrize("scans_go_on", [False, True])
def test_where_the_clock_stands_nobody_is_known_and_nothing_is_watched(step_s: float, scans_go_on: bool) -> None:
    """Its scans are all of the moment that is known already, or ahead of it: a car that was 15 m/s slower was driven into."""
    planner, begun_s, said = Planner(method="closed-form-corrected"), 1000.0, list[str]()
    for k in range(24):
        now, scanned_s = begun_s + step_s * k, begun_s + (0.04 if scans_go_on else step_s) * k
        with warnings.catch_warnings(record=True) as told_of:
            warnings.simplefilter("always")
            plan = planner.step(scans(scanned_s, 55.0 - 1.5 * k), HostState(s_m=2.0 * k, speed_mps=20.0), now)
        said += [str(each.message) for each in told_of]
        assert plan.situation.coverage.front <= (k < CYCLES - 1)
    assert any("the clock stands" in each for each in said)
    assert len(said) == len(set(said)) <= 3
    assert planner.tracker.counters["clock_stands"] == 24 - CYCLES + 1
    assert plan.trajectory.speed_mps[-1] < 15.0  # blind ahead it slows down
    for k in range(3):
        now = begun_s + 2.4 + 0.1 * k
        plan = planner.step(scans(now, 55.0 - 1.5 * k), HostState(s_m=48.0 + 2.0 * k, speed_mps=20.0), now)
        assert plan.situation.coverage.front == (k == 2)
    assert len(plan.situation.tracks) == 1


def test_a_cycle_in_several_calls_is_no_standing_clock(recwarn) -> None:
    planner = Planner(method="closed-form-corrected")
    for k in range(5):
        now = 1000.0 + 0.1 * k
        for scan in scans(now, 55.0):
            planner.step([scan], HostState(s_m=2.0 * k, speed_mps=20.0), now)
    assert planner.tracker.counters["clock_stands"] == 0
    assert planner.situation is not None
    assert planner.situation.coverage.front
    assert not recwarn.list
