"""People at the side of the way are passed with the room that the lane leaves, and as slowly as that asks for; an oncoming bicycle within
the lane was passed at 50 km/h, 0.1 m from it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt import load_scene, simulate
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import BodyKind, Status
from mcdas_opt.planning.planner import Planner

SPEED_MPS = 13.9
PLANNER = Planner(settings=Settings(warning=WarningSettings(escapes=False)))
CAR = PLANNER.vehicle
ROAD = Road(shoulder_left_m=0.5, shoulder_right_m=0.5, speed_limit_mps=14.0)
SIZES = {BodyKind.BICYCLE: (1.8, 0.6), BodyKind.PEDESTRIAN: (0.5, 0.5)}


def driven(kind: BodyKind, d_m: float, speed_mps: float, road: Road = ROAD) -> tuple[list[HostState], list[float], list[Plan]]:
    """Past somebody 60 m ahead, everything going as planned: the host, the distance between the bodies while they are beside one another,
    the plans."""
    PLANNER.reset()
    host, (length_m, width_m) = HostState(speed_mps=SPEED_MPS), SIZES[kind]
    hosts, beside, plans = [], [], []
    for k in range(140):
        time_s, s_m = 0.1 * k, 60.0 + 0.1 * k * speed_mps
        body = Track(id="1", s_m=s_m, d_m=d_m, speed_s_mps=speed_mps, length_m=length_m, width_m=width_m, kind=kind)
        asked = Situation(time_s=round(time_s, 1), host=host, road=road, tracks=(body,), desired_speed_mps=SPEED_MPS, coverage=Coverage())
        plans.append(PLANNER.plan(asked))
        if abs(s_m - host.s_m) < 0.5 * (length_m + CAR.length_m):
            beside.append(abs(d_m - host.d_m) - 0.5 * (width_m + CAR.width_m))
            hosts.append(host)
        later = int(np.searchsorted(plans[-1].trajectory.t_s, 0.1 - 1e-9))
        host = HostState.from_vector(plans[-1].trajectory.states[later])
    return hosts, beside, plans


@pytest.mark.parametrize("kind", [BodyKind.BICYCLE, BodyKind.PEDESTRIAN])
@pytest.mark.parametrize("speed_mps", [-3.0, 0.0, 1.3])
@pytest.mark.parametrize("d_m", [-1.3, 1.75, -2.0, 2.4, -2.9])
def test_people_are_passed_with_room_and_slowly(kind: BodyKind, speed_mps: float, d_m: float) -> None:
    hosts, beside, plans = driven(kind, d_m, speed_mps)
    width_m = SIZES[kind][1]
    there_is = abs(d_m) - 0.5 * width_m + 0.5 * ROAD.lane_width_m - 0.1 - CAR.width_m
    assert beside, "it is passed"
    assert min(beside) > min(there_is, 1.5) - 0.05
    for host, gap_m in zip(hosts, beside, strict=True):
        assert host.speed_mps < 1.2 * (max(speed_mps, 0.0) + max(3.0, 7.0 * gap_m**2))
    assert {plan.status for plan in plans} == {Status.PLANNED}
    assert min(float(plan.trajectory.acceleration_mps2.min()) for plan in plans) > -3.5
    assert max(abs(host.d_m) for host in hosts) + 0.5 * CAR.width_m < 0.5 * ROAD.lane_width_m


def test_nobody_changes_lanes_towards_who_is_passed() -> None:
    """A bicycle stands on the line, two lanes: its own lane seemed the slower one, and it was passed at 0.4 m, changing lanes."""
    hosts, beside, _ = driven(BodyKind.BICYCLE, 0.5 * ROAD.lane_width_m - 0.2, 0.0, replace(ROAD, lanes_left=1))
    assert min(beside) > 1.0
    assert max(host.d_m for host in hosts) < 0.0


def test_a_bicycle_in_the_lane_is_followed_where_it_leaves_less_than_a_metre() -> None:
    hosts, beside, plans = driven(BodyKind.BICYCLE, -1.2, 4.0)
    assert not beside
    assert not hosts
    assert {plan.status for plan in plans} == {Status.PLANNED}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_scene_is_driven_by_radar(seed: int) -> None:
    drive = simulate(load_scene("people-beside"), seed=seed)
    assert (drive.outcome, drive.fallbacks) == ("safe", 0)
    assert drive.min_clearance_m > 0.7
    assert drive.trajectory.acceleration_mps2.min() > -3.5
    assert any("passes" in cycle.plan.reason and "m beside it" in cycle.plan.reason for cycle in drive.cycles)
