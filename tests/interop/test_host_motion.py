"""The host behind a recording: its distance is the integral of its speed."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.interop.host_motion import HostMotion, LiveHost

speeds = st.lists(st.floats(0.0, 40.0), min_size=2, max_size=12)


@given(speeds, st.floats(-0.9, 12.0), st.floats(-0.9, 12.0))
def test_distance_is_the_integral_of_speed(found: list[float], start: float, end: float) -> None:
    motion = HostMotion(t_s=np.arange(len(found), dtype=float), speed_mps=np.array(found))
    times = np.linspace(start, end, 4001)
    values = np.interp(times, motion.t_s, motion.speed_mps)
    fine = float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(times)))
    state = motion.state(end, start, Road(), Vehicle())
    assert state.s_m == pytest.approx(fine, abs=0.01)
    assert (state.speed_mps, state.d_m, state.heading_rad) == (values[-1], 0.0, 0.0)


@given(st.floats(0.0, 5.0), st.floats(-4.0, 2.0))
def test_a_constant_acceleration_is_found_from_the_past(time: float, slope: float) -> None:
    t = np.arange(-1.0, 6.0, 0.1)
    motion = HostMotion(t_s=t, speed_mps=25.0 + slope * t)
    assert motion.state(time, 0.0, Road(), Vehicle()).acceleration_mps2 == pytest.approx(slope, abs=1e-9)
    later = HostMotion(t_s=t, speed_mps=np.where(t > time, 99.0, 25.0 + slope * t))
    before = t[np.searchsorted(t, time, side="right") - 1]
    assert later.state(before, 0.0, Road(), Vehicle()).acceleration_mps2 == motion.state(before, 0.0, Road(), Vehicle()).acceleration_mps2


def test_the_wheels_follow_the_road_and_the_limits_hold() -> None:
    motion = HostMotion(t_s=np.array([0.0, 0.1]), speed_mps=np.array([0.0, 10.0]))
    road = Road(curvature=((0.0, 0.01),))
    state = motion.state(0.1, 0.0, road, Vehicle())
    assert state.steering_rad == math.atan(2.7 * 0.01)
    assert state.acceleration_mps2 == Vehicle().acceleration_max_mps2


def test_time_s_and_other_columns_are_understood(tmp_path: Path) -> None:
    path = tmp_path / "host.csv"
    path.write_text("time_s,speed_mps,steering_wheel_deg\n0.0,8.0,x\n1.0,9.0,\n")
    np.testing.assert_array_equal(HostMotion.read(path).speed_mps, [8.0, 9.0])


@given(st.lists(st.floats(-0.3, 0.0), min_size=2, max_size=9))
def test_the_noise_of_a_car_that_stands_is_no_speed(tmp_path_factory: pytest.TempPathFactory, said: list[float]) -> None:
    path = tmp_path_factory.mktemp("csv") / "host.csv"
    path.write_text("t_s,speed_mps\n" + "".join(f"{0.1 * k},{v}\n" for k, v in enumerate(said)))
    assert set(HostMotion.read(path).speed_mps) == {0.0}
    live = LiveHost(Road(), Vehicle())
    for k, v in enumerate(said):
        live.note(0.1 * k, v)
    assert (live.state(0.1 * len(said)).speed_mps, live.state(0.1 * len(said)).s_m) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,v\n0,1\n1,1\n", r"column = 't_s or time_s': no such column"),
        ("t_s,speed_mps\n0,1\n", "at least two rows"),
        ("t_s,speed_mps\n0,1\n1,fast\n", "line 3: speed_mps is no number"),
        ("t_s,speed_mps\n0,1\n1\n", "line 3: not 2 cells"),
        ("t_s,speed_mps\n0,1\n1,nan\n", "line 3: t_s, speed_mps: must be finite"),
        ("t_s,speed_mps\n0,1\n0,1\n", "line 3: t_s = 0.0: must increase"),
        ("t_s,speed_mps\n0,1\n1,-0.31\n", r"line 3: speed_mps = -0\.31: reverses, and reversing is not driven"),
        ("t_s,speed_mps\n0,1\n1,130\n", "line 3: speed_mps = 130.0: exceeds 100 m/s .*not km/h"),
    ],
)
def test_bad_files_are_refused_with_line_and_rule(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "host.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        HostMotion.read(path)


def test_a_log_outside_the_speeds_is_refused() -> None:
    motion = HostMotion(t_s=np.arange(0.0, 11.0, 2.0), speed_mps=np.ones(6), source="host.csv")
    motion.require(np.arange(-1.0, 11.05, 0.1))
    for span in ((-1.1, 5.0), (5.0, 11.1)):
        with pytest.raises(InputError, match=r"host\.csv: t_s: covers 0 s to 10 s, the log needs"):
            motion.require(np.array(span))


@given(st.lists(st.floats(2.5, 60.0), min_size=1, max_size=4), st.floats(0.0, 1.0))
def test_a_hole_is_where_no_speed_is_said_for_longer_than_usual(holes: list[float], share: float) -> None:
    """A speed every 0.1 s, and holes between ten of them each."""
    said = np.cumsum(np.concatenate([[0.0], *([0.1] * 10 + [hole] for hole in holes)]))
    motion = HostMotion(t_s=said, speed_mps=np.ones(said.size), source="host.csv")
    time = share * said[-1]
    away = float(np.min(np.abs(said - time)))
    assert motion.known(np.array([time])) == (away <= 1.0 + 1e-9)
    if away > 1.0 + 1e-9:
        with pytest.raises(InputError, match=r"host\.csv: t_s: says nothing between .* s and .* s, where the log has scans"):
            motion.require(np.array([time]))


@given(st.floats(0.1, 60.0), st.floats(-1.0, 1.0))
def test_who_writes_few_speeds_means_what_lies_between(step: float, share: float) -> None:
    motion = HostMotion(t_s=np.array([0.0, step]), speed_mps=np.array([15.0, 15.0]))
    motion.require(np.array([0.5 * step + share * (0.5 * step + 1.0)]))
    with pytest.raises(InputError, match=r"the log needs"):
        motion.require(np.array([step + 1.1]))


@pytest.mark.parametrize(
    ("t_s", "speed_mps"),
    [([0.0, 0.0], [1.0, 1.0]), ([0.0], [1.0]), ([0.0, 1.0], [1.0]), ([0.0, 1.0], [1.0, math.nan]), ([0.0, 1.0], [1.0, -0.1])],
)
def test_times_increase_and_every_time_has_a_speed(t_s: list[float], speed_mps: list[float]) -> None:
    with pytest.raises(ParameterError):
        HostMotion(t_s=np.array(t_s), speed_mps=np.array(speed_mps))
