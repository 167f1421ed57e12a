"""Places far out, and so near to one another that numbers far out cannot tell them apart: planned for, or refused at the door."""

from __future__ import annotations

from typing import Any

import pytest

from mcdas_opt import Coverage, HostState, Planner, Road, Situation, Status
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError

NEAR_M = 1.1e-6


@pytest.mark.parametrize(
    "said",
    [
        {"road": Road(curvature=((0.0, 0.0), (2e9, 0.0)))},
        {"road": Road(curvature=((0.0, 0.0), (NEAR_M, 0.001), (3.1, 0.0)))},
        {"road": Road(road_end_s_m=2e9)},
        {"road": Road(lanes=(Lane(lane=0, width_m=((0.0, 3.0), (2e9, 3.2))),))},
        {"road": Road(lanes=(Lane(lane=0, width_m=((0.0, 3.0), (NEAR_M, 3.0 + NEAR_M), (50.0, 3.2))),))},
        {"road": Road(lanes_left=1, lanes=(Lane(lane=1, closed_m=((0.0, NEAR_M), (1.0, 2e9))),))},
        {"road": Road(lanes_left=1, lanes=(Lane(lane=1, width_m=((0.0, 3.2),), closed_m=((5e-324, 90.0),)),))},
        {"road": Road(lanes_left=1, lanes=(Lane(lane=0, width_m=((0.0, 3.7), (1.85, 0.0)), merges=Side.LEFT),))},
        {"destination": Destination(s_m=(0.0, 2e9))},
        {"destination": Destination(time_s=(0.0, 1.7e308)), "time_s": -1.7e308},
    ],
)
@pytest.mark.parametrize("s_m", [-1e9, 1e9 - 3.3, 311.27])
def test_what_the_door_takes_is_planned_for_wherever_the_host_is(said: dict[str, Any], s_m: float) -> None:
    plan = Planner().plan(Situation(host=HostState(s_m=s_m, speed_mps=20.0), coverage=Coverage(), **said))
    assert plan.status is Status.UNAVOIDABLE or plan.verdict.passed


@pytest.mark.parametrize("lane", [{"width_m": ((0.0, 3.0), (1e-300, 3.2))}, {"closed_m": ((0.0, 1e-300),)}, {"closed_m": ((0.0, 1e300),)}])
def test_places_that_are_not_told_apart_everywhere_are_refused(lane: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match=r"by at least 1e-06|within 2e"):
        Lane(lane=1, **lane)


def test_a_road_seen_from_elsewhere_has_the_same_lanes_there() -> None:
    road = Road(lanes_left=2, lanes=(Lane(lane=1, closed_m=((40.0, 80.0),)), Lane(lane=2, width_m=((0.0, 3.7), (100.0, 0.0)))))
    moved = road.seen_from(1000.0)
    for s in (-50.0, 30.0, 39.5, 60.0, 99.0, 150.0):
        assert moved.lane_centre_m(1, s - 1000.0) == pytest.approx(road.lane_centre_m(1, s), abs=1e-9)
        assert moved.left_edge_at(s - 1000.0) == pytest.approx(road.left_edge_at(s), abs=1e-9)
        assert moved.has_lane(1, s - 1000.0) == road.has_lane(1, s)
    assert moved.seen_from(-1000.0).lanes == road.lanes
