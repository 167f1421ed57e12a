"""Towns of SUMO: the road through tight turns, who crosses it, and where the vehicle has to wait."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vocabulary import BodyKind, Status
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.interop.sumo.connection import Connection, started
from mcdas_opt.interop.sumo.driver import SumoDriver
from mcdas_opt.interop.sumo.episode import EpisodeSettings, sumo_config, wait_for
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.interop.sumo.road_line import line_along
from mcdas_opt.interop.sumo.route import OncomingLane, read_route
from tests.interop.sumo_configuration import configuration

pytest.importorskip("libsumo")

TOWN = sumo_config("town")
LIGHTS = "a"  # the junction with lights; its line is the end of the edge west-a


@contextmanager
def in_town(seed: int = 1) -> Iterator[Connection]:
    with started(TOWN, seed) as sumo:
        wait_for(sumo, EpisodeSettings(config=TOWN, ego="ego"))
        yield sumo


def turns(angles: list[float], radius_m: float) -> np.ndarray:
    """Points a metre apart: straight pieces of 60 m, and arcs between them."""
    heading, points = 0.0, [np.zeros(2)]
    for angle in [*angles, 0.0]:
        for _ in range(60):
            points.append(points[-1] + np.array([math.cos(heading), math.sin(heading)]))
        steps = max(round(abs(angle) * radius_m), 1)
        for _ in range(steps if angle else 0):
            heading += angle / steps
            points.append(points[-1] + np.array([math.cos(heading), math.sin(heading)]))
    return np.array(points)


@settings(max_examples=60, deadline=None)
@given(
    angles=st.lists(st.floats(0.2, 1.8).flatmap(lambda a: st.sampled_from([a, -a])), min_size=1, max_size=4), radius_m=st.floats(9.0, 60.0)
)
def test_the_line_stays_with_the_lane_through_every_turn(angles: list[float], radius_m: float) -> None:
    assume(np.abs(np.cumsum(angles)).max() < 2.5)  # the road does not cross itself
    points = turns(angles, radius_m)
    placement, knots = line_along(points, 0.0, 0.0)
    frame = FrenetFrame(road=Road(curvature=knots), s_min_m=-10.0, s_max_m=knots[-1][0] + 10.0)
    s = 0.0
    for x, y in points:
        at, d, _ = frame.to_road(*placement.to_frame(np.array([x]), np.array([y]), np.zeros(1)), near_s_m=s)
        s = float(at[0])
        assert abs(float(d[0])) < 0.3
    assert max(abs(kappa) for _, kappa in knots) <= 1.0 / 6.0 + 1e-9


def test_no_turn_is_tighter_than_a_car_or_the_lanes_inside_it_allow() -> None:
    points = turns([1.5, -1.5], 3.0)
    for right_m, left_m in ((0.0, 0.0), (10.0, 0.0), (0.0, 14.0)):
        _, knots = line_along(points, right_m, left_m)
        kappa = np.array([one for _, one in knots])
        assert kappa.max() <= 1.0 / max(left_m, 6.0) + 1e-9
        assert kappa.min() >= -1.0 / max(right_m, 6.0) - 1e-9
        turned = float(np.sum(0.5 * (kappa[1:] + kappa[:-1]) * np.diff([at for at, _ in knots])))
        assert abs(turned) < 0.02  # what was turned to the left is turned back


@pytest.mark.parametrize("seed", [1, 2])
def test_it_drives_through_the_town_and_over_no_red_light(seed: int) -> None:
    with in_town(seed) as sumo:
        driver, before_m = SumoDriver(sumo, "ego"), None
        while driver.step():
            front_m = driver.snapshots[-1].host.s_m + 0.5 * driver.vehicle.length_m
            for section in driver.frame.sections[:-1]:
                lane = section.edge.lanes[0]
                if before_m is not None and before_m <= section.end_m < front_m:
                    assert all(link[5] != "r" for link in sumo.lane.getLinks(lane.id) if link[4] == lane.via), (section.edge.id, front_m)
            before_m = front_m
    summary = driver.summary
    assert summary.ended == "arrived"
    assert not driver.contacts
    assert summary.unverified_plans == 0
    assert summary.fallbacks + summary.unavoidable < 0.01 * summary.plans


def test_it_waits_at_a_red_light_and_drives_on_at_green() -> None:
    with in_town() as sumo:
        driver = SumoDriver(sumo, "ego")
        links = len(sumo.trafficlight.getRedYellowGreenState(LIGHTS))  # type: ignore[attr-defined]
        line_m = driver.frame.sections[0].end_m
        for _ in range(400):
            sumo.trafficlight.setRedYellowGreenState(LIGHTS, "r" * links)  # type: ignore[attr-defined]
            assert driver.step()
        host = driver.snapshots[-1].host
        assert host.speed_mps < 0.1
        assert host.s_m + 0.5 * driver.vehicle.length_m < line_m
        for _ in range(300):
            sumo.trafficlight.setRedYellowGreenState(LIGHTS, "G" * links)  # type: ignore[attr-defined]
            assert driver.step()
        assert driver.snapshots[-1].host.s_m > line_m


@pytest.mark.parametrize(("way_m", "waits"), [(60.0, True), (15.0, False)])
def test_amber_is_driven_over_by_who_comes_too_near_to_stop(way_m: float, waits: bool) -> None:
    with in_town() as sumo:
        driver = SumoDriver(sumo, "ego")
        links = len(sumo.trafficlight.getRedYellowGreenState(LIGHTS))  # type: ignore[attr-defined]
        line_m = driver.frame.sections[0].end_m
        state, fast_since, left_m = "G", False, math.inf
        for _ in range(600):
            sumo.trafficlight.setRedYellowGreenState(LIGHTS, state * links)  # type: ignore[attr-defined]
            assert driver.step()
            host = driver.snapshots[-1].host
            left_m = line_m - host.s_m - 0.5 * driver.vehicle.length_m
            if left_m < way_m and state == "G":
                state, fast_since = "y", host.speed_mps > 9.0
            elif state == "y" and left_m < way_m - 30.0:
                state = "r"
            if left_m < -5.0:
                break
        assert fast_since
        assert (left_m > 0.0) == waits


def test_who_crosses_has_a_heading_and_who_rides_a_bicycle_is_known() -> None:
    headings, kinds = [], set()
    with in_town(4) as sumo:
        driver = SumoDriver(sumo, "ego")
        for _ in range(700):
            if not driver.step():
                break
            for track in driver.situation().tracks:
                kinds.add(track.kind)
                if track.heading_rad is not None and track.speed_d_mps > 5.0:
                    headings.append(track.heading_rad - math.atan2(track.speed_d_mps, track.speed_s_mps))
    assert BodyKind.BICYCLE in kinds
    assert len(headings) > 10
    assert np.abs(headings).max() < math.radians(
        45.0
    )  # a bend stretches speeds along the road, so that they do not show where a body points
    assert driver.plan is not None
    assert driver.plan.status is Status.PLANNED


def test_lanes_of_oncoming_traffic_lie_where_the_network_has_them() -> None:
    route = ("west-a", "a-b", "b-c3", "c3-c0", "c0-c1", "c1-c2", "c2-d", "d-a", "a-south")
    with started(TOWN, 1) as sumo:
        edges = read_route(sumo, route, 0, "passenger")
        frame = RoadFrame(sumo.lane, edges, 0, 0.9)
        theirs = np.array(sumo.lane.getShape("b-a_0"))[:, :2]
    one_way = {"c3-c0", "c0-c1", "c1-c2"}  # the roundabout's
    assert {edge.id: edge.oncoming for edge in edges} == {name: None if name in one_way else OncomingLane(1, 3.2) for name in route}
    section = frame.sections[1]
    for s in np.linspace(section.begin_m + 10.0, section.end_m - 10.0, 8).tolist():
        road = frame.road_at(s)
        assert [lane.oncoming for lane in road.lanes] == [False, True]
        assert road.lane_width_at(1, s) == pytest.approx(3.2)
        x, y, _ = frame.to_plane(s, road.lane_centre_m(1, s), 0.0)
        way, to = np.diff(theirs, axis=0), np.array([x, y]) - theirs[:-1]
        assert np.abs(way[:, 0] * to[:, 1] - way[:, 1] * to[:, 0]).min() / np.hypot(*way.T).max() < 0.3
    for s in (frame.sections[3].begin_m + 5.0, section.begin_m - 3.0):  # on the roundabout, and in the junction
        assert float(frame.road_at(s).left_edge_at(s)) < 2.2


def test_who_cycles_in_the_middle_of_the_lane_is_passed_over_the_line(tmp_path: Path) -> None:
    """Nobody comes: the car followed him at his speed to the end of the street."""
    routes = """<vType id="car" length="4.5" width="1.8" accel="2.6" sigma="0"/>
        <vType id="cyclist" vClass="bicycle" length="1.8" width="0.6" maxSpeed="3.5" latAlignment="-0.9"/>
        <route id="along" edges="west-a a-b b-right"/>
        <vehicle id="cyclist" type="cyclist" route="along" depart="0" departPos="60" departSpeed="3"/>
        <vehicle id="ego" type="car" route="along" depart="0.5" departPos="10" departSpeed="8"/>"""
    config = configuration(tmp_path, routes, "town")
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver, said = SumoDriver(sumo, "ego"), []
        for _ in range(160):
            assert driver.step()
            said.append("" if driver.plan is None else driver.plan.reason)
        cyclist_m = float(frame_s(driver, sumo, "cyclist"))
    host = driver.snapshots[-1].host
    assert host.s_m > cyclist_m + 20.0
    assert abs(host.d_m) < 0.3
    assert max(snapshot.host.d_m for snapshot in driver.snapshots) > 0.8
    assert any("passes cyclist" in reason for reason in said)
    assert not driver.contacts
    assert (driver.summary.fallbacks, driver.summary.unavoidable) == (0, 0)


def frame_s(driver: SumoDriver, sumo: Connection, name: str) -> float:
    """Where somebody is along the road."""
    x, y = sumo.vehicle.getPosition3D(name)[:2]
    s, _, _ = driver.frame.to_road(np.array([x]), np.array([y]), np.zeros(1))
    return float(s[0])
