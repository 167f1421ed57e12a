"""However much is said at once, what is followed is bounded: the nearest, counted what is left out."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, Mounting, RadarDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import FARTHEST_M
from mcdas_opt.domain.situation import MOST_TRACKS, Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry import window
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.judging import verify
from mcdas_opt.tracking.screening import MOST_DETECTIONS, MOST_SCANS

HOST = HostState(speed_mps=20.0)
CAR = RadarDetection(range_m=25.0, azimuth_rad=0.0, range_rate_mps=-5.0)
PLANNER = Planner("sedan", "closed-form-corrected")


def clutter(count: int, seed: int, nearest_m: float) -> tuple[RadarDetection, ...]:
    r = np.random.default_rng(seed)
    places = zip(r.uniform(nearest_m, 170.0, count), r.uniform(-0.7, 0.7, count), r.uniform(-20.0, 5.0, count), strict=True)
    return tuple(RadarDetection(range_m=far, azimuth_rad=turn, range_rate_mps=rate) for far, turn, rate in places)


def heard(scans: list[Scan], now: float = 0.0) -> dict[str, int]:
    PLANNER.step(scans, replace(HOST, s_m=HOST.speed_mps * now), now)
    return PLANNER.tracker.counters


def test_the_nearest_points_of_a_scan_that_says_too_much_are_followed() -> None:
    PLANNER.reset()
    points = (*clutter(2000, 0, 60.0), CAR)
    with pytest.warns(UserWarning, match="of 2001 detections the nearest 256 are followed, so that the sensor covers nothing"):
        counters = heard([Scan(sensor="f", sector=Sector.FRONT, t_s=0.0, mounting=Mounting(x_m=2.0), radar=points)])
    assert counters["too_many"] == len(points) - MOST_DETECTIONS
    for k in range(1, 4):
        closer = RadarDetection(range_m=CAR.range_m - 0.5 * k, azimuth_rad=0.0, range_rate_mps=-5.0)
        radar = (*clutter(2000, k, 60.0), closer)
        heard([Scan(sensor="f", sector=Sector.FRONT, t_s=0.1 * k, mounting=Mounting(x_m=2.0), radar=radar)], 0.1 * k)
    assert PLANNER.situation is not None
    assert not PLANNER.situation.coverage.front  # who is farther away is not known
    assert any(abs(track.s_m - 33.75) < 1.0 and abs(track.d_m) < 1.0 for track in PLANNER.situation.tracks)


def test_a_point_said_often_leaves_room_for_others() -> None:
    PLANNER.reset()
    counters = heard([Scan(sensor="f", sector=Sector.FRONT, t_s=0.0, radar=(CAR,) * 1000 + clutter(10, 0, 60.0))])
    assert (counters["duplicate"], counters["too_many"]) == (999, 0)


def test_the_nearest_of_too_many_bodies_are_followed() -> None:
    PLANNER.reset()
    bodies = tuple(
        BodyDetection(name=str(k), s_m=2000.0 - k, d_m=0.0, speed_s_mps=20.0, speed_d_mps=0.0, length_m=4.5, width_m=1.8)
        for k in range(0, 2000, 5)
    )
    counters = heard([Scan(sensor="f", sector=Sector.FRONT, t_s=0.0, bodies=bodies)])
    assert counters["too_many"] == len(bodies) - MOST_DETECTIONS
    assert counters["initiated"] == MOST_DETECTIONS


@pytest.mark.parametrize("stamp_s", [0.0, 1e9])
def test_the_latest_of_too_many_scans_are_taken_whatever_comes_beside_them(stamp_s: float) -> None:
    """Scans of another time are refused, and take no other's place."""
    PLANNER.reset()
    sound = [Scan(sensor=f"f{k}", sector=Sector.FRONT, t_s=0.0, radar=(CAR,)) for k in range(5)]
    others = [Scan(sensor=f"x{k}", sector=Sector.FRONT, t_s=stamp_s) for k in range(300)]
    with pytest.warns(UserWarning, match="another clock, or milliseconds") if stamp_s > 0.0 else nullcontext():
        counters = heard([*others, *sound])
    beyond = 305 - MOST_SCANS if stamp_s == 0.0 else 0
    assert counters["too_many"] == beyond
    assert counters["scans"] == min(305 - beyond, MOST_SCANS if stamp_s == 0.0 else 5)
    assert counters["associated"] + counters["initiated"] > 0


def test_a_planner_is_told_of_so_many_at_most() -> None:
    others = tuple(Track(id=str(k), s_m=10.0 * k, d_m=0.0, speed_s_mps=20.0) for k in range(MOST_TRACKS + 1))
    with pytest.raises(ParameterError, match=f"tracks = {MOST_TRACKS + 1}: must be at most {MOST_TRACKS}"):
        Situation(host=HOST, coverage=Coverage(), tracks=others)


@pytest.mark.parametrize("place_m", [FARTHEST_M, -FARTHEST_M, FARTHEST_M - 30.0])
def test_whoever_leaves_the_farthest_place_stops_no_planning(place_m: float) -> None:
    """An ideal sensor says that a body is there; it is predicted on."""
    PLANNER.reset()
    for k in range(6):
        s_m, speed_mps = place_m, 30.0 if place_m > 0.0 else -30.0
        body = BodyDetection(name="far", s_m=s_m, d_m=0.0, speed_s_mps=speed_mps, speed_d_mps=0.0, length_m=4.5, width_m=1.8)
        scans = [Scan(sensor="f", sector=Sector.FRONT, t_s=0.1 * k, bodies=(body,))] if k < 3 else []
        plan = PLANNER.step(scans, replace(HOST, s_m=2.0 * k), 0.1 * k)
    assert plan.verdict.passed


def test_who_is_beside_a_host_at_the_farthest_place_can_be_judged() -> None:
    """Doubts move a body that overlaps the host beside it."""
    near = Track(id="near", s_m=-FARTHEST_M, d_m=0.0, speed_s_mps=20.0)
    situation = Situation(host=HostState(s_m=-FARTHEST_M + 2.0, speed_mps=20.0), coverage=Coverage(), tracks=(near,))
    PLANNER.reset()
    plan = PLANNER.plan(situation)
    assert plan.verdict.passed == verify(plan.trajectory, situation).passed


def test_a_road_is_tabulated_for_those_alone_who_can_come_here() -> None:
    """1,000 turned bodies, 600 m from one another on a bent road, took 2.3 s: a table of the road around each of them."""
    road = Road(curvature=((0.0, 0.0), (100.0, 0.01), (200.0, 0.0), (1e6, 0.001)))
    tracks = tuple(Track(id=str(k), s_m=600.0 * k, d_m=3.0, speed_s_mps=90.0, heading_rad=1.0) for k in range(1, MOST_TRACKS + 1))
    before = window._frame.cache_info().misses
    plan = Planner().plan(Situation(host=HOST, tracks=tracks, road=road, coverage=Coverage()))
    assert window._frame.cache_info().misses - before < 60
    assert verify(plan.trajectory, Situation(host=HOST, tracks=tracks[:5], road=road, coverage=Coverage())).passed
