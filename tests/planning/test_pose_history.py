"""Where the host was when a scan was taken."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Mounting, RadarDetection, Scan
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.planning.measurement.pose_history import PoseHistory
from mcdas_opt.planning.planner import Planner


@given(age=st.floats(0.0, 0.9), v=st.floats(0.0, 40.0))
def test_steady_drive_is_remembered_exactly(age: float, v: float) -> None:
    history = PoseHistory()
    for k in range(6):
        history.note(0.1 * k, HostState(s_m=v * 0.1 * k, speed_mps=v))
    assert history.at(0.5 - age).s_m == pytest.approx(v * (0.5 - age), abs=1e-7)


def test_time_running_back_begins_anew() -> None:
    history = PoseHistory()
    history.note(5.0, HostState(s_m=100.0, speed_mps=10.0))
    history.note(1.0, HostState(s_m=3.0, speed_mps=10.0))
    assert history.at(0.9).s_m == pytest.approx(2.0)


def test_a_second_call_at_one_time_forgets_nothing_before_it() -> None:
    """The scans of one cycle may come in several calls."""
    history = PoseHistory()
    for time_s, s_m in ((0.0, 0.0), (0.1, 1.0), (0.2, 4.0), (0.2, 6.0)):
        history.note(time_s, HostState(s_m=s_m, speed_mps=10.0))
    assert [history.at(time_s).s_m for time_s in (0.05, 0.15, 0.2)] == pytest.approx([0.5, 3.5, 6.0])


@pytest.mark.parametrize("age", [0.0, 0.05, 0.2, 0.3])
def test_age_of_a_scan_does_not_shift_the_track(age: float) -> None:
    """A standing car, seen again and again from a host at 20 m/s, stays where it is, however old the scans are."""
    planner, v, where = Planner(method="closed-form-corrected"), 20.0, 120.0
    for k in range(12):
        now = 0.1 * k
        taken = now - age
        point = where - 2.25 - (v * taken + 2.25)
        detection = RadarDetection(range_m=point, azimuth_rad=0.0, range_rate_mps=-v)
        scan = Scan(sensor="front", sector=Sector.FRONT, t_s=taken, mounting=Mounting(x_m=2.25), radar=(detection,))
        planner.step([scan], HostState(s_m=v * now, speed_mps=v), now)
    (track,) = planner.tracker.tracks(1.1)
    assert track.s_m == pytest.approx(where, abs=0.1)
    assert abs(track.speed_s_mps) < 0.2


def test_nonsense_among_measurements_never_reaches_the_plan() -> None:
    planner = Planner()
    bad = RadarDetection(range_m=math.nan, azimuth_rad=math.inf, range_rate_mps=-1.0)
    for k in range(5):
        scan = Scan(sensor="front", sector=Sector.FRONT, t_s=math.nan if k == 2 else 0.1 * k, radar=(bad,))
        plan = planner.step([scan, scan], HostState(speed_mps=10.0), 0.1 * k)
        assert np.all(np.isfinite(plan.trajectory.states))
    assert planner.tracker.tracks(0.4) == ()
    assert sum(planner.tracker.counters.values()) > 0
