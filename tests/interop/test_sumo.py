"""SUMO's vehicles in our frame, ours in SUMO's; who caused a contact; and what is said where SUMO cannot go on."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from mcdas_opt.baselines.lane import SteadyLaw, judged
from mcdas_opt.cli.app import app
from mcdas_opt.cli.sumo import seeds_of
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.evaluation.sumo_campaign import lines, markdown, summarise
from mcdas_opt.interop.sumo.columns import main_column
from mcdas_opt.interop.sumo.connection import Connection, SumoError, started
from mcdas_opt.interop.sumo.driver import SumoDriver
from mcdas_opt.interop.sumo.episode import EpisodeSettings, drive, sumo_config
from mcdas_opt.interop.sumo.record import Cause, caused_by
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.interop.sumo.route import Edge, OncomingLane, keeps_left, read_route
from mcdas_opt.interop.sumo.route import Lane as RouteLane
from mcdas_opt.plotting.traffic_moments import draw_moments
from mcdas_opt.simulation.ordinary import OWED_S, Placed, Snapshot, instant
from tests.interop.sumo_configuration import NETS, configuration

libsumo = pytest.importorskip("libsumo")

MOTORWAY = ("start", "merging", "bend", "narrow", "wide")
BENDS = ("first", "left", "right", "sharp", "back", "last")


def mirrored(folder: Path, routes: str, net: str = "bends") -> Path:
    """The same configuration on the network's mirror image, whose traffic keeps left: every lane keeps its index."""
    text = (NETS / f"{net}.net.xml").read_text("utf-8").replace("<net ", '<net lefthand="true" ')
    text = re.sub(r"(?<=,)(-?)([0-9.]+)(?=[ \"])", lambda y: y[2] if y[1] else f"-{y[2]}", text)
    text = re.sub(r'(?<= y=")(-?)', lambda y: "" if y[1] else "-", text)
    (folder / "left.net.xml").write_text(text, "utf-8")
    own = configuration(folder, routes, net)
    left = own.with_name("left.sumocfg")
    left.write_text(own.read_text("utf-8").replace(f"{NETS / net}", "left"), "utf-8")
    return left


ROUTE = f'<vType id="car" length="4.5" width="1.8" accel="2.6" sigma="0"/><route id="r" edges="{" ".join(BENDS)}"/>'
EGO = '<vehicle id="ego" type="car" route="r" depart="0.5" departPos="50" departSpeed="20"/>'
STANDING = '<vehicle id="wall" type="car" route="r" depart="0" departPos="160"><stop lane="first_0" endPos="160" duration="500"/></vehicle>'


@contextmanager
def on_the_road(config: Path, seed: int = 1, ego: str = "ego") -> Iterator[Connection]:
    with started(config, seed) as sumo:
        while ego not in sumo.vehicle.getIDList():
            sumo.simulationStep()
        yield sumo


class Blind:
    """Keeps its speed and its lane."""

    has_ladder = False

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle = vehicle

    def plan(self, situation: Situation, previous: Plan | None) -> Plan:
        return judged("blind", situation, self.vehicle, Settings(), law=SteadyLaw(), reason="blind")


@pytest.mark.parametrize(("net", "route", "base"), [("motorway", MOTORWAY, 0), ("motorway", MOTORWAY, 1), ("bends", BENDS, 1)])
def test_every_lane_lies_where_the_frame_says(net: str, route: tuple[str, ...], base: int) -> None:
    with started(NETS / f"{net}.sumocfg", 1) as sumo:
        edges = read_route(sumo, route, 0, "passenger")
        frame = RoadFrame(sumo.lane, edges, base, 0.9)
    for edge in edges:
        for lane in edge.lanes:
            points = np.concatenate([np.linspace(a, b, 4) for a, b in zip(lane.shape, lane.shape[1:], strict=False)])
            s, d, psi = frame.to_road(points[:, 0], points[:, 1], np.zeros(len(points)))
            assert np.abs(d - frame.centre_m(lane.column, float(s[2]))).max() < 0.2, lane.id
            assert frame.column_at(float(s[2]), float(d[2])) == lane.column
            x, y, yaw = frame.to_plane(float(s[1]), float(d[1]), float(psi[1]))
            assert (x, y) == pytest.approx(tuple(points[1]), abs=1e-6)
            assert math.sin(yaw) == pytest.approx(0.0, abs=1e-9)
    lengths = [section.end_m - section.begin_m for section in frame.sections]
    assert lengths == pytest.approx([float(np.hypot(*np.diff(edge.nearest(base).shape, axis=0).T).sum()) for edge in edges], rel=5e-3)


def test_columns_go_on_where_links_lead_and_end_where_none_does() -> None:
    with started(NETS / "motorway.sumocfg", 1) as sumo:
        through = read_route(sumo, MOTORWAY, 0, "passenger")
        ramp = read_route(sumo, ("ramp", *MOTORWAY[1:]), 0, "passenger")
        frame = RoadFrame(sumo.lane, ramp, 0, 0.9)
    assert [list(edge.columns) for edge in through] == [[0, 1, 2], [-1, 0, 1, 2], [0, 1, 2], [0, 1], [0, 1, 2]]
    assert [list(edge.columns) for edge in ramp] == [[0], [0, 1, 2, 3], [1, 2, 3], [1, 2], [1, 2, 3]]
    assert (main_column(through), main_column(ramp)) == (0, 1)
    merging, narrow, wide = frame.sections[1], frame.sections[3], frame.sections[4]
    at_m = merging.begin_m + 1.0
    road = frame.road_at(at_m)
    assert (road.lanes_left, road.lanes_right) == (3, 0)
    ends = [road.lane_ends_m(lane, at_m, 1.8) for lane in range(4)]
    assert ends == pytest.approx([merging.end_m, math.inf, math.inf, frame.sections[2].end_m])
    road = frame.road_at(wide.begin_m - 500.0)
    assert [road.has_lane(lane, s) for lane in (0, 3) for s in (narrow.begin_m + 5.0, wide.begin_m + 5.0)] == [False, False, False, True]
    assert float(road.right_edge_at(narrow.begin_m)) == pytest.approx(0.5 * road.lane_width_m)
    limits = [frame.road_at(s).limit_mps(1, s) for s in (narrow.begin_m - 400.0, narrow.begin_m - 30.0)]
    assert limits == pytest.approx([33.33, math.sqrt(27.78**2 + 2.0 * 1.5 * 30.0)], rel=1e-3)


def stretch(name: str, columns: range, *, at_m: float, widths_m: dict[int, float] | None = None, goes_on: range | None = None) -> Edge:
    """100 m straight along x; each lane beside the one to its right."""
    lanes, right_m, widths = [], 0.0, dict.fromkeys(range(10), 3.2) | (widths_m or {})
    for column in range(columns.stop):
        middle_m, right_m = right_m + 0.5 * widths[column], right_m + widths[column]
        if column in columns:
            shape, leads = np.array([[at_m, middle_m], [at_m + 100.0, middle_m]]), goes_on is None or column in goes_on
            facts = {"width_m": widths[column], "limit_mps": 30.0, "goes_on": leads, "via": ""}
            lanes.append(RouteLane(id=f"{name}_{column}", column=column, shape=shape, **facts))
    return Edge(id=name, lanes=tuple(lanes))


def test_lanes_of_other_widths_and_a_base_that_ends_are_where_the_network_has_them() -> None:
    """A lane of 4 m beside two of 3.2 m; then the right one ends, then the next."""
    edges = (
        stretch("a", range(3), at_m=0.0, widths_m={1: 4.0}, goes_on=range(1, 3)),
        stretch("b", range(1, 3), at_m=100.0, widths_m={1: 4.0}, goes_on=range(2, 3)),
        stretch("c", range(2, 3), at_m=200.0, widths_m={1: 4.0}),
    )
    assert main_column(edges) == 2
    frame = RoadFrame(None, edges, 2, 0.9)  # type: ignore[arg-type]  # no junctions to ask about
    for edge in edges:
        for lane in edge.lanes:
            s, d, _ = frame.to_road(lane.shape[1:, 0] - 40.0, lane.shape[1:, 1], np.zeros(1))
            assert frame.centre_m(lane.column, float(s[0])) == pytest.approx(float(d[0]), abs=1e-3)
            assert frame.column_at(float(s[0]), float(d[0])) == lane.column
    ends = [frame.road_at(50.0).lane_ends_m(column - 2, 50.0, 1.8) for column in range(3)]
    assert ends == pytest.approx([100.0, 200.0, math.inf], abs=0.5)


def test_where_traffic_keeps_left_the_lane_of_oncoming_traffic_is_on_the_right(tmp_path: Path) -> None:
    """Of a town without an edge of two lanes: that lane tells to which side traffic keeps."""
    route = ("west-a", "a-b", "b-c3")
    with started(mirrored(tmp_path, "", "town"), 1) as sumo:
        assert keeps_left(sumo, route)
        assert [edge.oncoming for edge in read_route(sumo, route, 0, "passenger")] == 3 * [OncomingLane(-1, 3.2)]
    with started(NETS / "town.sumocfg", 1) as sumo:
        assert not keeps_left(sumo, route)


def test_a_lane_of_oncoming_traffic_ends_where_the_road_bends_tightly_around_it() -> None:
    """An edge of two lanes that ends in a turn to the left, of 9.6 m around its right lane: the road would fold over itself."""
    arc = np.linspace(-0.5 * np.pi, 0.0, 16)
    lanes = []
    for column in range(2):
        radius_m = 9.6 - 3.2 * column
        turn = np.column_stack([100.0 + radius_m * np.cos(arc), 9.6 + radius_m * np.sin(arc)])
        shape = np.concatenate([[[0.0, 9.6 - radius_m]], turn])
        lanes.append(RouteLane(id=f"a_{column}", column=column, shape=shape, width_m=3.2, limit_mps=13.9, goes_on=True, via=""))
    edge = Edge(id="a", lanes=tuple(lanes), oncoming=OncomingLane(2, 3.2))
    frame = RoadFrame(None, [edge], 0, 0.9)  # type: ignore[arg-type]  # no junctions to ask about
    road = frame.road_at(50.0)
    assert [lane.lane for lane in road.lanes if lane.oncoming] == [2]
    assert road.lane_width_at(2, 50.0) == pytest.approx(3.2)
    assert road.lane_width_at(2, frame.end_m - 6.0) == pytest.approx(0.0)


def test_the_vehicle_is_where_the_plan_has_it_and_the_limit_is_kept(tmp_path: Path) -> None:
    with on_the_road(configuration(tmp_path, ROUTE + EGO.replace('"50"', '"480"'))) as sumo:
        driver = SumoDriver(sumo, "ego", "idm-mobil", look_m=(80, 80))
        assert (driver.vehicle.length_m, driver.vehicle.width_m, driver.vehicle.acceleration_max_mps2) == pytest.approx((4.5, 1.8, 2.6))
        for _ in range(100):
            assert driver.step()
            host = driver.snapshots[-1].host
            x, y, yaw = driver.frame.to_plane(host.s_m, host.d_m, host.heading_rad)
            front = (x + 2.25 * math.cos(yaw), y + 2.25 * math.sin(yaw))
            assert sumo.vehicle.getPosition3D("ego")[:2] == pytest.approx(front, abs=1e-6)
    summary = driver.summary
    assert summary.driver == "idm-mobil"
    assert (summary.ended, summary.contacts, summary.plans) == ("driving", (), 100)
    assert summary.ordinary.distance_m == pytest.approx(host.s_m - driver.snapshots[0].host.s_m, rel=1e-3)
    assert max(abs(one.host.d_m) for one in driver.snapshots) < 0.2
    assert driver.frame.section_at(host.s_m).edge.id == "left"
    assert host.speed_mps < 25.3


def test_whoever_watches_changes_nothing() -> None:
    places = []
    for watched in (False, True):
        with on_the_road(NETS / "bends.sumocfg", seed=3) as sumo:
            driver = SumoDriver(sumo, "ego", "sumo") if watched else None
            for _ in range(40):
                if driver is None:
                    sumo.simulationStep()
                else:
                    driver.step()
            places.append((sumo.vehicle.getPosition3D("ego"), len(sumo.vehicle.getIDList())))
    assert places[0] == places[1]


def test_who_drives_on_blindly_causes_the_contact_and_the_picture_shows_it(tmp_path: Path) -> None:
    with on_the_road(configuration(tmp_path, ROUTE + STANDING + EGO)) as sumo:
        driver = SumoDriver(sumo, "ego", "sumo")
        driver = SumoDriver(sumo, "ego", Blind(driver.vehicle))
        while driver.step() and not driver.contacts:
            pass
        assert len(driver.contacts) == 1
        for _ in range(3):
            driver.step()
    contact = driver.contacts[0]
    assert (len(driver.contacts), contact.other, contact.cause) == (1, "wall", Cause.HOST)
    assert contact.speed_mps == pytest.approx(20.0, abs=1.0)
    near = driver.summary.ordinary
    assert near.least_time_to_collision_s is not None
    assert near.least_time_to_collision_s < 0.2
    assert [miss.other for miss in near.near_misses] == ["wall"]
    figure = draw_moments(driver.snapshots, contact.time_s, "wall", contact.why)
    assert len(figure.axes) == 6
    assert all(axes.has_data() for axes in figure.axes)


def test_the_planner_stops_where_the_blind_one_hits(tmp_path: Path) -> None:
    beside = STANDING.replace("wall", "second").replace("first_0", "first_1").replace("departPos", 'departLane="1" departPos')
    config = configuration(tmp_path, ROUTE + STANDING + beside + EGO.replace('"50"', '"105"').replace('"20"', '"12"'), end_s=8.0)
    episode = drive(EpisodeSettings(config=config, ego="ego"), 1, "mpc")
    assert episode.summary is not None
    assert (episode.error, episode.summary.contacts, episode.summary.unverified_plans) == ("", (), 0)
    assert episode.snapshots[-1].host.speed_mps < 2.0
    assert episode.snapshots[-1].time_s == pytest.approx(8.0, abs=0.11)


@pytest.mark.parametrize("lane", [0, 1])
def test_where_traffic_keeps_left_everything_is_mirrored(tmp_path: Path, lane: int) -> None:
    """Somebody slow ahead in the host's lane, another farther on beside it: overtaken from lane 0, followed in lane 1."""
    others = "".join(
        f'<vehicle id="{name}" type="car" route="r" depart="0" departPos="{s}" departLane="{k}" departSpeed="{v}" maxSpeed="{v}"/>'
        for name, s, k, v in (("slow", 110, lane, 8), ("far", 300, 1 - lane, 15))
    )
    routes = ROUTE.replace('sigma="0"', 'sigma="0" lcStrategic="-1" lcSpeedGain="0" lcKeepRight="0"') + others
    routes += EGO.replace("departPos", f'departLane="{lane}" departPos')
    drives = []
    for config in (configuration(tmp_path, routes), mirrored(tmp_path, routes)):
        with on_the_road(config) as sumo:
            driver = SumoDriver(sumo, "ego", "mpc")
            while len(driver.snapshots) < 60:
                assert driver.step()
            drives.append((driver, sumo.vehicle.getPosition3D("ego")))
    (right, (x, y, _)), (left, place) = drives
    assert place[:2] == pytest.approx((x, -y), abs=0.1)
    for one, two in zip(right.snapshots, left.snapshots, strict=True):
        assert (one.road.lanes_left, one.road.lanes_right) == (two.road.lanes_right, two.road.lanes_left)
        assert (one.road.left_edge_m, one.road.right_edge_m) == pytest.approx((-two.road.right_edge_m, -two.road.left_edge_m))
        bodies, images = (one.host, *one.others), (two.host, *two.others)
        assert [body.lane for body in bodies] == [-image.lane for image in images]
        assert [body.d_m for body in bodies] == pytest.approx([-image.d_m for image in images], abs=0.05)
    changed = abs(right.snapshots[-1].host.d_m - right.snapshots[0].host.d_m)
    assert changed == pytest.approx(3.2 if lane == 0 else 0.0, abs=0.1)


WALKING = '<vType id="walker" vClass="pedestrian" length="0.4" width="0.6"/>'
WALKING += '<person id="{}" type="walker" depart="0" departPos="170"><walk edges="first left" speed="0.2"/></person>'


@pytest.mark.parametrize("method", ["blind", "mpc"])
def test_a_person_who_stands_in_the_lane_is_seen_and_a_contact_counts(tmp_path: Path, method: str) -> None:
    """Called as the vehicle behind the host is."""
    ego = EGO.replace("departPos", 'departLane="0" departPos')
    behind = ego.replace('"ego"', '"twin"').replace('"50"', '"10"')
    with on_the_road(configuration(tmp_path, ROUTE + WALKING.format("twin") + behind + ego)) as sumo:
        driver = SumoDriver(sumo, "ego", Blind(SumoDriver(sumo, "ego", "sumo").vehicle) if method == "blind" else method)
        while len(driver.snapshots) < 70 and not driver.contacts:
            sumo.person.moveToXY("twin", "first", 170.0, -4.8, keepRoute=2)
            assert driver.step()
            if len(driver.snapshots) == 2:
                tracks = {track.id: track for track in driver.situation().tracks}
    assert set(tracks) == {"twin", "person twin"}
    person, host = tracks["person twin"], driver.snapshots[1].host
    assert (person.kind, person.length_m, person.width_m) == (BodyKind.PEDESTRIAN, 0.4, 0.6)
    assert (tracks["twin"].kind, tracks["twin"].length_m) == (None, 4.5)
    assert (person.s_m, person.d_m, person.speed_s_mps) == pytest.approx((169.8, 0.0, 0.0), abs=0.02)
    assert tracks["twin"].s_m < host.s_m
    if method == "blind":
        assert [(one.other, one.cause) for one in driver.contacts] == [("person twin", Cause.HOST)]
        assert driver.contacts[0].speed_mps == pytest.approx(20.0, abs=1.0)
    else:
        assert driver.contacts == []
        assert driver.snapshots[-1].host.s_m < 168.0 or abs(driver.snapshots[-1].host.d_m) > 1.5


def test_of_more_than_a_planner_takes_the_nearest_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mcdas_opt.interop.sumo.driver.MOST_TRACKS", 2)
    places = {"last": 0, "behind": 50, "ego": 100, "ahead": 160, "first-of-all": 220}
    queue = "".join(EGO.replace('"ego"', f'"{name}"').replace('"50"', f'"{place}"') for name, place in places.items())
    with on_the_road(configuration(tmp_path, ROUTE + queue)) as sumo:
        driver = SumoDriver(sumo, "ego", "sumo")
        assert driver.step()
        assert {body.id for body in driver.snapshots[0].others} == {"last", "behind", "ahead", "first-of-all"}
        assert {track.id for track in driver.situation().tracks} == {"behind", "ahead"}


def test_who_sits_in_a_car_is_nobody_and_who_walks_beside_the_lanes_is_in_none(tmp_path: Path) -> None:
    riding = '<person id="rider" depart="triggered"><ride from="first" to="last" lines="ego"/></person>'
    with on_the_road(configuration(tmp_path, ROUTE + WALKING.format("walker") + EGO + riding)) as sumo:
        driver = SumoDriver(sumo, "ego", "sumo")
        for _ in range(20):
            sumo.person.moveToXY("walker", "first", 170.0, -9.0, keepRoute=2)
            assert driver.step()
            assert sumo.vehicle.getPersonIDList("ego") == ("rider",)
    now = driver.snapshots[-1]
    assert [(body.id, body.lane) for body in now.others] == [("person walker", -1)]
    assert instant(now.time_s, now.host, now.others).leader is None


def moment(time_s: float, host: tuple[float, float, int], other: tuple[float, float, int]) -> Snapshot:
    bodies = [
        Placed(id=name, s_m=s, d_m=d, speed_mps=20.0, length_m=4.5, width_m=1.8, lane=lane)
        for name, (s, d, lane) in (("host", host), ("x", other))
    ]
    return Snapshot(time_s=time_s, road=Road(lanes_left=1), host=bodies[0], others=(bodies[1],))


@pytest.mark.parametrize(
    ("host", "other", "cause"),
    [
        ([(0, 0, 0)] * 3, [(4.4, 0, 0)] * 3, Cause.HOST),
        ([(0, 0, 0)] * 3, [(-4.4, 0, 0)] * 3, Cause.OTHER),
        ([(0, 0, 0)] * 3, [(4.4, 3, 1), (4.4, 1.5, 0), (4.4, 1.0, 0)], Cause.OTHER),
        ([(0, 3, 1), (0, 1.5, 0), (0, 1.0, 0)], [(-4.4, 0, 0)] * 3, Cause.HOST),
        ([(0, 0, 0), (0, 0.6, 0), (0, 1.2, 0)], [(1, 3, 1)] * 3, Cause.HOST),
        ([(0, 0, 0)] * 3, [(1, 3, 1), (1, 2.4, 1), (1, 1.8, 1)], Cause.OTHER),
    ],
)
def test_who_came_in_or_drove_into_whom(host: list[tuple[float, float, int]], other: list[tuple[float, float, int]], cause: Cause) -> None:
    snapshots = [moment(0.3 * k, one, two) for k, (one, two) in enumerate(zip(host, other, strict=True))]
    assert caused_by(snapshots, "x")[0] is cause


def test_no_ego_and_a_step_that_makes_no_cycle_are_one_sentence(tmp_path: Path) -> None:
    config = configuration(tmp_path, ROUTE + EGO, end_s=20.0)
    with pytest.raises(
        InputError, match=r"own\.sumocfg: ego = 'nobody': never departs in this configuration, which was watched until 20 s"
    ):
        drive(EpisodeSettings(config=config, ego="nobody"), 1, "sumo")
    with on_the_road(config) as sumo:
        with pytest.raises(InputError, match="SUMO: ego = 'nobody': is not on the road"):
            SumoDriver(sumo, "nobody")
        with pytest.raises(ParameterError, match="look_m"):
            SumoDriver(sumo, "ego", look_m=(80.0, 0.0))
        with pytest.raises(ParameterError, match="desired_mps"):
            SumoDriver(sumo, "ego", desired_mps=math.nan)
    slow = config.with_name("slow.sumocfg")
    slow.write_text(config.read_text("utf-8").replace('<step-length value="0.1"/>', '<step-length value="0.25"/>'), "utf-8")
    libsumo.start(["sumo", "-c", str(slow), "--no-step-log"])
    while "ego" not in libsumo.vehicle.getIDList():
        libsumo.simulationStep()
    with pytest.raises(ParameterError, match=r"step-length = 0\.25 s: .* start SUMO with --step-length 0\.1"):
        SumoDriver(libsumo, "ego")
    libsumo.close()
    with pytest.raises(InputError, match="no shipped SUMO configuration of that name"):
        sumo_config("motorwya")
    (tmp_path / "bad.sumocfg").write_text('<configuration><input><net-file value="nope.net.xml"/></input></configuration>', "utf-8")
    with pytest.raises(InputError, match=r"bad\.sumocfg: SUMO does not take it: .*nope\.net\.xml"), started(tmp_path / "bad.sumocfg", 1):
        pass


def test_sumo_that_ends_while_driving_leaves_what_was_driven(tmp_path: Path) -> None:
    with on_the_road(configuration(tmp_path, ROUTE + EGO)) as sumo:
        driver = SumoDriver(sumo, "ego", "sumo")
        for _ in range(5):
            driver.step()
        sumo.close()
        with pytest.raises(SumoError, match="SUMO ended or refused while ego was driven"):
            driver.step()
    assert len(driver.snapshots) == 5
    assert driver.summary.ordinary.duration_s == pytest.approx(0.4)


def test_the_gap_that_sumo_put_the_vehicle_into_is_not_its_own_doing(tmp_path: Path) -> None:
    with on_the_road(configuration(tmp_path, ROUTE + EGO)) as sumo:
        driver = SumoDriver(sumo, "ego", "sumo")
        for _ in range(120):
            driver.step()
    for k, one in enumerate(driver.snapshots):
        ahead = replace(one.host, id="lead", s_m=one.host.s_m + one.host.length_m + 0.4 * max(one.host.speed_mps, 5.0))
        driver.snapshots[k] = replace(one, others=(ahead,))
    found = driver.summary.ordinary
    assert found.short_headway_any_s > 11.5
    assert found.short_headway_s[-1] == pytest.approx(found.short_headway_any_s - OWED_S, abs=0.25)


def test_the_command_keeps_what_was_driven_goes_on_and_prints_a_table(tmp_path: Path) -> None:
    late = "".join(f'<vehicle id="f{t}" type="car" route="r" depart="{t}"/>' for t in (2, 3))
    late += '<vehicle id="x" type="{}" route="r" depart="4"/>'
    config = configuration(tmp_path, ROUTE + EGO + late.format("nosuch"), end_s=5.0)
    arguments = ["sumo", str(config), "--seeds", "1", "--planner", "aeb", "--out", str(tmp_path / "out")]
    broken = CliRunner().invoke(app, arguments)
    assert "The vehicle type 'nosuch' for vehicle 'x' is not known" in str(broken.exception)
    assert "what was driven of this one are kept" in str(broken.exception)
    kept = json.loads((tmp_path / "out" / "broken-1-aeb.json").read_text("utf-8"))
    assert kept["ordinary"]["distance_m"] > 5.0
    configuration(tmp_path, ROUTE + EGO + late.format("car"), end_s=5.0)
    whole = CliRunner().invoke(app, [*arguments, "--json"])
    rows = json.loads(whole.stdout)["rows"]
    assert [(row["seed"], row["driver"], row["ended"]) for row in rows] == [(1, "aeb", "driving"), (1, "sumo", "driving")]
    assert "| collisions caused by the host | 0 of 1" in (tmp_path / "out" / "table.md").read_text("utf-8")
    with (tmp_path / "out" / "rows.csv").open(encoding="utf-8", newline="") as file:
        written = list(csv.DictReader(file))
    assert [(row["seed"], row["driver"], row["ended"]) for row in written] == [("1", "aeb", "driving"), ("1", "sumo", "driving")]
    assert [float(row["distance_m"]) for row in written] == [row["ordinary"]["distance_m"] for row in rows]
    assert all(json.loads(row["short_headway_s"]) == [0.0, 0.0, 0.0] for row in written)
    assert "add --resume" in str(CliRunner().invoke(app, arguments).exception)
    assert "mean speed" in CliRunner().invoke(app, [*arguments, "--resume"], env={"COLUMNS": "160"}).stdout
    assert "is of another run" in str(CliRunner().invoke(app, [*arguments[:3], "4", *arguments[4:]]).exception)


def row(seed: int, driver: str, distance_m: float, short_s: float, cause: str | None = None) -> dict[str, object]:
    ordinary = {
        "duration_s": 100.0, "distance_m": distance_m, "following_s": 50.0, "short_headway_s": [0.0, 0.0, short_s],
        "short_headway_any_s": 2.0 * short_s, "least_headway_s": 0.7, "least_time_to_collision_s": None, "near_misses": [],
        "lane_changes": 2, "followers_braked": 1, "outside_iso_s": 1.0,
    }  # fmt: skip
    contacts = [] if cause is None else [{"cause": cause}]
    counts = {"plans": 0, "fallbacks": 0, "unavoidable": 0, "unverified_plans": 0}
    return {"seed": seed, "driver": driver, "ended": "arrived", "ordinary": ordinary, "contacts": contacts, **counts}


def test_the_table_counts_by_driver_and_compares_seed_by_seed() -> None:
    rows = [row(k, "mpc", 2000.0 + k, 1.0 + k, "host" if k == 1 else None) for k in range(5)]
    rows += [row(k, "sumo", 1000.0 + 0.5 * k, 0.0) for k in range(5)]
    found = summarise(rows, ["mpc", "sumo"])
    assert (found["mpc"]["collisions_by_host"]["k"], found["mpc"]["collisions_by_others"]["k"]) == (1, 0)
    own = found["mpc"]["own_headway_under_0.8_s"]
    assert own["value"] == pytest.approx((1 + 2 + 3 + 4 + 5) / 250.0)
    assert own["low"] < own["value"] < own["high"]
    assert found["mpc"]["any_headway_under_0.8_s"]["value"] == pytest.approx(2.0 * own["value"])
    speed = found["mpc"]["speed_over_sumo"]
    assert speed == {"value": pytest.approx(2.0), "low": None, "high": None}  # the same in every pair
    cells = dict(lines(found))
    assert cells["followers who brake > 4 m/s^2, of lane changes"][0].startswith("5 of 10")
    assert cells["mean speed over sumo's, same seeds"] == ["200.00 % [too few]", "-"]


def test_drives_that_have_no_duration_have_no_figures_and_the_table_says_so() -> None:
    """SUMO took the vehicle away in its first step; or the other stood all along."""
    none = {"duration_s": 0.0, "distance_m": 0.0, "following_s": 0.0}
    gone = [one | {"ordinary": one["ordinary"] | none} for one in (row(k, "mpc", 0.0, 0.0) for k in range(5))]  # type: ignore[operator]
    driven = [row(k, "sumo", 1000.0 + k, 0.0) for k in range(5)]
    stood = [row(k, "sumo", 1000.0 * (k == 0), 0.0) for k in range(5)]
    for rows, drivers, said in (
        (gone + driven, ["mpc", "sumo"], "-"),
        (driven + gone, ["sumo", "mpc"], "-"),
        ([row(k, "mpc", 500.0, 0.0) for k in range(5)] + [row(k, "sumo", 0.0, 0.0) for k in range(5)], ["mpc", "sumo"], "-"),
        ([row(k, "mpc", 500.0, 0.0) for k in range(5)] + stood, ["mpc", "sumo"], "250.00"),
        ([*gone[:1], *(row(k, "mpc", 500.0, 0.0) for k in range(1, 5)), *driven], ["mpc", "sumo"], "49.88 % [too few]"),
    ):
        found = summarise(rows, drivers)
        json.dumps(found, allow_nan=False)
        cells = dict(lines(found))
        assert cells[f"mean speed over {drivers[-1]}'s, same seeds"][0].startswith(said)
        assert "mean speed" in markdown("a run", found)


@pytest.mark.parametrize("n", [1, 2, 4])
def test_a_few_episodes_make_no_interval(n: int) -> None:
    found = summarise([row(k, "mpc", 2000.0 + k, 1.0 + k) for k in range(n)], ["mpc"])
    own = found["mpc"]["own_headway_under_0.8_s"]
    assert (own["low"], own["high"]) == (None, None)
    assert dict(lines(found))["time gap under 0.8 s, own doing, of following"] == [f"{100.0 * own['value']:.2f} % [too few]"]


def test_seeds_are_ranges_and_lists() -> None:
    assert (seeds_of("0-3"), seeds_of("7"), seeds_of("1,5-6")) == ([0, 1, 2, 3], [7], [1, 5, 6])
    for text in ("", "a", "4-1", "1-", "-3", "1,1", "0-999999999", "7" * 5000, "0-99,99-100"):
        with pytest.raises(InputError, match="--seeds"):
            seeds_of(text)


def test_the_page_says_what_its_example_prints(capsys: pytest.CaptureFixture[str]) -> None:
    page = Path(__file__).resolve().parents[2] / "docs" / "sumo.md"
    code, printed = re.findall(r"```(?:python|text)\n(.*?)```", page.read_text("utf-8"), flags=re.DOTALL)[:2]
    exec(compile(code, str(page), "exec"), {})
    assert capsys.readouterr().out == printed
