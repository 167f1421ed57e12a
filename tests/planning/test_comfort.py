"""Ordinary driving stays within ISO 15622, stop and go included; who has stopped stands; swings of speed shrink from car to car."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.string_stability import CYCLE_S, amplitudes, drive, swing_in_band
from mcdas_opt.domain.comfort import ComfortSettings
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.planner import Planner
from tests.planning.test_headway import CYCLE_S as TURN_S
from tests.planning.test_headway import Follow

COMFORT = ComfortSettings()
SLACK = 0.01  # what a soft row gives way by


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner(settings=Settings(warning=WarningSettings(escapes=False)))


def beyond(hosts: list[HostState]) -> float:
    """The greatest share of the limits at the speed of each turn that acceleration, braking or jerk take."""
    most = 0.0
    for before, after in pairwise(hosts):
        limits, a = COMFORT.limits(before.speed_mps), after.acceleration_mps2
        jerk = abs(a - before.acceleration_mps2) / TURN_S
        most = max(most, a / limits.acceleration_mps2, -a / limits.braking_mps2, jerk / limits.jerk_mps3)
    return most


@given(speed=st.floats(0.0, 60.0))
def test_limits_are_those_of_the_standard(speed: float) -> None:
    limits = COMFORT.limits(speed)
    share = np.clip((speed - 5.0) / 15.0, 0.0, 1.0)
    assert limits == pytest.approx((4.0 - 2.0 * share, 5.0 - 1.5 * share, 5.0 - 2.5 * share))


@pytest.mark.parametrize(("speed_mps", "wanted_mps"), [(0.0, 20.0), (20.0, 33.0), (28.0, 20.0)])
def test_another_speed_is_reached_in_comfort(planner: Planner, speed_mps: float, wanted_mps: float) -> None:
    drive = Follow(planner, speed_mps, None, wanted_mps).drive(12.0)
    assert beyond(drive.hosts) <= 1.0 + SLACK
    assert drive.hosts[-1].speed_mps == pytest.approx(wanted_mps, abs=1.0)


@pytest.mark.parametrize(("speed_mps", "gap_m", "braking_mps2"), [(12.0, 20.0, 2.0), (25.0, 33.0, 2.0), (8.0, 12.0, 1.5)])
def test_stop_and_go_stays_in_comfort_and_nobody_creeps(planner: Planner, speed_mps: float, gap_m: float, braking_mps2: float) -> None:
    queue = Follow(planner, speed_mps, gap_m, 1.2 * speed_mps).drive(3.0)
    queue.drive(speed_mps / braking_mps2 + 8.0, braking_mps2=braking_mps2)
    standing = len(queue.hosts)
    queue.drive(2.0)
    assert max(host.speed_mps for host in queue.hosts[standing:]) <= 0.02
    assert 2.0 <= queue.gaps_m[-1] <= 4.0
    assert queue.leader is not None
    queue.drive(6.0, braking_mps2=-1.5)
    assert queue.hosts[-1].speed_mps > 3.0
    assert beyond(queue.hosts) <= 1.0 + SLACK
    assert {plan.status for plan in queue.plans} == {Status.PLANNED}


@pytest.mark.parametrize(("speed_mps", "braking_mps2"), [(30.0, 8.5), (20.0, 8.0), (20.0, 5.0), (12.0, 7.0)])
def test_hard_braking_that_nobody_needs_is_let_go_of(planner: Planner, speed_mps: float, braking_mps2: float) -> None:
    """Down to comfortable braking as 1 - exp(-t / 0.6 s), from there with comfortable jerk."""
    follow = Follow(planner, speed_mps, None, speed_mps)
    follow.host = HostState(speed_mps=speed_mps, acceleration_mps2=-braking_mps2)
    hosts = follow.drive(4.0).hosts
    _, comfortable, jerk = COMFORT.limits(speed_mps)
    lost_mps = 0.6 * (braking_mps2 - comfortable) + 0.5 * comfortable**2 / jerk
    assert speed_mps - min(one.speed_mps for one in hosts) <= lost_mps
    assert hosts[-1].acceleration_mps2 > 0.0


def swings(frequency_hz: float, speed_mps: float) -> Array:
    t = np.arange(0.0, 2.0 / frequency_hz, CYCLE_S)
    platoon = drive(speed_mps + min(1.0, 1.0 / (2.0 * np.pi * frequency_hz)) * np.sin(2.0 * np.pi * frequency_hz * t), cars=3)
    assert platoon.fallbacks == 0
    return amplitudes(platoon, frequency_hz)


@pytest.mark.parametrize(("frequency_hz", "speed_mps"), [(0.07, 25.0), (0.2, 12.0), (0.5, 25.0)])
def test_swings_of_speed_shrink_from_car_to_car(frequency_hz: float, speed_mps: float) -> None:
    found = swings(frequency_hz, speed_mps)
    assert np.all(found[1:] <= found[:-1])


@given(frequency=st.floats(0.05, 0.4), swing=st.floats(0.1, 5.0))
def test_the_swing_in_the_band_is_that_of_a_sine_and_nothing_of_what_is_slower(frequency: float, swing: float) -> None:
    t = CYCLE_S * np.arange(2000)
    rows = np.stack([swing * np.sin(2.0 * np.pi * frequency * t), swing * np.sin(2.0 * np.pi * 0.004 * t)])
    within, slower = swing_in_band(12.0 + rows)
    assert within == pytest.approx(swing / np.sqrt(2.0), rel=0.02)
    assert slower < 0.01 * swing


@pytest.mark.parametrize("name", ComfortSettings.__slots__)
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_what_is_no_comfort_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(ParameterError, match=name):
        ComfortSettings(**{name: value})
