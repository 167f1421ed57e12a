"""Lanes narrower or wider than usual."""

from __future__ import annotations

import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.proposals.comfortable_speed import comfortable_speed
from tests.planning.situations import car


def slowest_mps(width_m: float, beside_m: float) -> float:
    """How slowly a host at 20 m/s means to keep the right of two lanes of this width, with a slower car ahead so far to the left."""
    road = Road(lanes_left=1, lanes=tuple(Lane(lane=lane, width_m=((0.0, width_m), (1000.0, width_m))) for lane in (0, 1)))
    tracks = (car("slower", 40.0, beside_m, 8.0),)
    situation = Situation(host=HostState(speed_mps=20.0), tracks=tracks, road=road, coverage=Coverage(), desired_speed_mps=20.0)
    return float(comfortable_speed(Cycle.of(situation, Vehicle(), Settings()), 20.0, 0.0).speeds_mps.min())


@pytest.mark.parametrize("width_m", [2.4, 2.6, 3.0, 3.7, 6.0])
def test_nobody_in_the_next_lane_is_followed(width_m: float) -> None:
    assert slowest_mps(width_m, width_m) > 19.5


@pytest.mark.parametrize("width_m", [2.4, 3.0, 3.7, 6.0])
def test_who_is_in_the_own_lane_is_followed(width_m: float) -> None:
    assert slowest_mps(width_m, 0.3) < 18.0
