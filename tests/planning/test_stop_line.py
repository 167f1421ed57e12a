"""Waiting at a line, as at a red light: stopped for as is comfortable, left when it is gone, and no wall to somebody who is pressed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vocabulary import Side, Status
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.stateless import plan, step

FRONT_M = 2.25  # of the sedan, from its middle
FOLLOWER = Track(id="follower", s_m=-70.0, d_m=0.0, speed_s_mps=13.0)


def driven(
    speed_mps: float, line_m: float | None, seconds: float, others: tuple[Track, ...] = (), start_m: float = 0.0, lanes_left: int = 0
) -> Iterator[tuple[Plan, HostState]]:
    """Everything as it is planned, ten times a second; others keep their speed."""
    planner, host = Planner(), HostState(s_m=start_m, speed_mps=speed_mps)
    for k in range(round(10 * seconds)):
        now = Situation(
            time_s=0.1 * k,
            host=host,
            coverage=Coverage(),
            tracks=tuple(one.later(0.1 * k) for one in others),
            road=Road(lane_width_m=3.5, lanes_left=lanes_left, lanes_right=0),
            desired_speed_mps=max(speed_mps, 13.9),
            stop_line_s_m=line_m,
        )
        chosen = planner.plan(now)
        yield chosen, host
        host = HostState.from_vector(chosen.trajectory.states[int(np.searchsorted(chosen.trajectory.t_s, 0.1 - 1e-9))])


@pytest.mark.parametrize("speed_mps", [5.0, 13.9, 22.0, 30.0])
@pytest.mark.parametrize("start_m", [0.0, 30_000.0])
def test_it_stops_before_the_line_comfortably(speed_mps: float, start_m: float) -> None:
    line_m = start_m + 30.0 + speed_mps**2 / 2.0
    plans, hosts = zip(*driven(speed_mps, line_m, 30.0, start_m=start_m), strict=True)
    assert all(plan.status is Status.PLANNED for plan in plans)
    assert hosts[-1].speed_mps < 0.05
    assert 0.5 < line_m - hosts[-1].s_m - FRONT_M < 4.0
    assert min(host.acceleration_mps2 for host in hosts) > -2.5
    assert "waits at the stop line" in plans[-1].reason


def test_it_drives_on_when_the_line_is_gone() -> None:
    *_, (_, waiting) = driven(10.0, 80.0, 20.0)
    situation = Situation(host=waiting, coverage=Coverage(), road=Road(lanes_left=0, lanes_right=0), desired_speed_mps=13.9)
    assert plan(replace(situation, stop_line_s_m=80.0)).trajectory.states[-1, 3] < 0.2
    assert plan(situation).trajectory.states[-1, 3] > 3.0


def test_who_follows_is_expected_to_wait_too_and_who_does_not_is_escaped_from_across_the_line() -> None:
    drive = list(driven(0.0, 5.25, 5.5, (FOLLOWER,)))
    waits = [plan.trajectory.states[-1, 3] < 0.2 for plan, _ in drive]
    assert all(waits[:15])
    assert drive[0][0].status is Status.PLANNED
    assert drive[-1][1].s_m > 5.25  # the follower keeps its speed
    assert all(host.s_m - FRONT_M > FOLLOWER.later(0.1 * k).s_m + 2.25 for k, (_, host) in enumerate(drive))


def test_a_line_that_is_behind_the_front_bumper_says_nothing() -> None:
    situation = Situation(host=HostState(speed_mps=10.0), coverage=Coverage(), desired_speed_mps=10.0)
    past, without = plan(replace(situation, stop_line_s_m=2.0)), plan(situation)
    assert np.array_equal(past.trajectory.states, without.trajectory.states)


@pytest.mark.parametrize("line", [math.nan, math.inf, "near", 1e12])
def test_a_line_is_a_place(line: object) -> None:
    with pytest.raises(ParameterError, match="stop_line_s_m"):
        Situation(host=HostState(), coverage=Coverage(), stop_line_s_m=line)  # type: ignore[arg-type]


@pytest.mark.parametrize(("line_m", "changes"), [(75.0, False), (None, True)])
def test_nobody_is_passed_on_the_way_to_the_line(line_m: float | None, changes: bool) -> None:
    leader = Track(id="leader", s_m=40.0, d_m=0.0, speed_s_mps=7.0)
    sides = {plan.side for plan, _ in driven(12.0, line_m, 4.0, (leader,), lanes_left=1)}
    assert (Side.LEFT in sides) is changes


def test_it_goes_into_the_document_and_comes_back() -> None:
    situation = Situation(host=HostState(), coverage=Coverage(), stop_line_s_m=31.5)
    assert Situation.from_json(situation.to_json()).stop_line_s_m == 31.5


def test_step_takes_it_too() -> None:
    host, road = HostState(speed_mps=10.0), Road(lanes_left=0, lanes_right=0)
    waits, drives = (step([], host, 0.0, road=road, desired_speed_mps=10.0, stop_line_s_m=line) for line in (25.0, None))
    assert "waits at the stop line" in waits.reason
    assert "stop line" not in drives.reason
