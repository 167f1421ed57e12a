"""Networks as maps give them: bridges, lanes for others, edges of a metre, lanes that come and go, and turns that no car makes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import InputError
from mcdas_opt.interop.sumo.connection import started
from mcdas_opt.interop.sumo.driver import SumoDriver
from mcdas_opt.interop.sumo.episode import EpisodeSettings, wait_for
from mcdas_opt.interop.sumo.polylines import even
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.interop.sumo.route import Edge, lanes_inside
from tests.interop.sumo_configuration import edge, ego, framed, network

pytest.importorskip("libsumo")


def off_m(frame: RoadFrame, edges: tuple[Edge, ...]) -> float:
    """How far, at most, the middles of the lanes of the base's column lie beside its line, but for 15 m from the ends of an edge."""
    found = [0.0]
    for section, one in zip(frame.sections, edges, strict=True):
        shape = one.nearest(frame.base).shape
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(shape, axis=0).T))])
        at = np.arange(15.0, along[-1] - 15.0, 5.0)
        if one.lane(frame.base) is not None and at.size:
            x, y = (np.interp(at, along, shape[:, k]) for k in (0, 1))
            _, d, _ = frame.to_road(x, y, np.zeros(at.size), near_s_m=0.5 * (section.begin_m + section.end_m))
            found.append(float(np.abs(d).max()))
    return max(found)


CROSSED = {"west": (0.0, 0.0), "east": (300.0, 0.0), "south": (150.0, -80.0), "north": (160.0, 80.0), "out": (500.0, 0.0)}


@pytest.mark.parametrize("stops", [True, False])
def test_who_is_on_a_bridge_is_not_in_the_way(stops: bool, tmp_path: Path) -> None:
    stop = '<stop lane="south-north_0" endPos="84" duration="100"/>' if stops else ""
    others = f'<flow id="over" begin="0" end="60" period="3" departSpeed="max"><route edges="south-north"/>{stop}</flow>'
    edges = [edge("west", "east"), edge("east", "out"), edge("south", "north")]
    config = network(tmp_path, CROSSED, edges, ego("west-east", "east-out") + others)
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver = SumoDriver(sumo, "ego")
        seen, least_mps = False, math.inf
        while driver.step():
            assert not driver.snapshots[-1].others
            seen = seen or sumo.vehicle.getIDCount() > 1
            least_mps = min(least_mps, driver.snapshots[-1].host.speed_mps)
    assert seen
    assert driver.ended == "arrived"
    assert not driver.contacts
    assert least_mps > 9.5


def test_who_comes_down_a_ramp_that_crosses_the_route_is_seen(tmp_path: Path) -> None:
    # a loop: over the street, round, and onto it
    nodes = {"west": (0.0, 0.0), "join": (300.0, 0.0), "east": (500.0, 0.0), "south": (100.0, -150.0)}
    loop = '<edge id="loop" from="south" to="join" numLanes="1" speed="13.9" shape="100,-150 110,80 180,110 230,60 260,5 300,0"/>'
    others = '<flow id="down" begin="0" end="60" period="4" departSpeed="max"><route edges="loop join-east"/></flow>'
    config = network(tmp_path, nodes, [edge("west", "join"), edge("join", "east"), loop], ego("west-join", "join-east") + others)
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver, on_loop = SumoDriver(sumo, "ego"), set()
        for _ in range(200):
            if not driver.step():
                break
            on_loop |= {other.id for other in driver.snapshots[-1].others if sumo.vehicle.getRoadID(other.id) == "loop"}
    assert on_loop


def test_who_stays_on_the_road_that_an_exit_crosses_is_not_in_the_way(tmp_path: Path) -> None:
    # the exit leaves to the right, and crosses over the road that it has left; that road's next edge begins at the exit's junction
    nodes = {"west": (-200.0, 0.0), "out": (0.0, 0.0), "east": (500.0, 0.0), "north": (200.0, 300.0)}
    exit_road = '<edge id="exit" from="out" to="north" numLanes="1" speed="13.9" shape="0,0 40,-8 100,-20 150,-15 180,20 195,80 200,300"/>'
    others = (
        """<flow id="stays" begin="0" end="60" period="2" departSpeed="max" departLane="free"><route edges="west-out out-east"/></flow>"""
    )
    edges = [edge("west", "out", 2), edge("out", "east", 2), exit_road]
    config = network(tmp_path, nodes, edges, ego("west-out", "exit") + others)
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver, before, crossing = SumoDriver(sumo, "ego"), set(), set()
        while driver.step():
            for other in driver.snapshots[-1].others:
                far_m = sumo.vehicle.getLanePosition(other.id) if sumo.vehicle.getRoadID(other.id) == "out-east" else 0.0
                (crossing if far_m > 50.0 else before).add(other.id)
    assert len(before) >= 2
    assert not crossing
    assert driver.ended == "arrived"


def test_who_comes_up_on_the_road_that_is_joined_is_seen_once_the_route_has_crossed_it(tmp_path: Path) -> None:
    # the way in crosses over the road, and joins it from its other side
    nodes = {"south": (150.0, -200.0), "west": (-200.0, 0.0), "join": (500.0, 0.0), "east": (800.0, 0.0)}
    way_in = '<edge id="in" from="south" to="join" numLanes="1" speed="13.9" shape="150,-200 150,60 180,110 230,100 300,40 400,8 500,0"/>'
    others = '<flow id="along" begin="0" end="60" period="2" departSpeed="max"><route edges="west-join join-east"/></flow>'
    config = network(tmp_path, nodes, [edge("west", "join"), edge("join", "east"), way_in], ego("in", "join-east") + others)
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver, below, beside = SumoDriver(sumo, "ego"), set(), set()
        while driver.step() and sumo.vehicle.getRoadID("ego") == "in":
            there = {other.id for other in driver.snapshots[-1].others if sumo.vehicle.getRoadID(other.id) == "west-join"}
            (below if sumo.vehicle.getLanePosition("ego") < 190.0 else beside).update(there)
    assert not below
    assert len(beside) >= 2


def test_who_comes_to_a_junction_of_the_route_is_seen(tmp_path: Path) -> None:
    nodes = {**CROSSED, "middle": (150.0, 0.0)}
    edges = [edge("west", "middle"), edge("middle", "east"), edge("south", "middle"), edge("middle", "north")]
    others = '<flow id="across" begin="0" end="60" period="3"><route edges="south-middle middle-north"/></flow>'
    config = network(tmp_path, nodes, edges, ego("west-middle", "middle-east") + others)
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver = SumoDriver(sumo, "ego")
        seen = {other.id for _ in range(100) if driver.step() for other in driver.snapshots[-1].others}
    assert len(seen) >= 2


def test_lanes_for_others_do_not_move_the_lanes_that_go_on(tmp_path: Path) -> None:
    # two lanes for cycling join the one: two links lead one lane to the right, and the car's leads straight on
    nodes = {"a": (0.0, 0.0), "b": (100.0, 0.0), "c": (200.0, 0.0)}
    only = [f'<lane index="{i}" allow="bicycle"/>' for i in range(3)]
    edges = [edge("a", "b", 4, "".join(only[:3])), edge("b", "c", 4, only[0] + only[1])]
    links = "".join(f'<connection from="a-b" to="b-c" fromLane="{i}" toLane="{j}"/>' for i, j in ((1, 0), (2, 1), (3, 3)))
    (tmp_path / "own.con.xml").write_text(f"<connections>{links}</connections>", "utf-8")
    config = network(tmp_path, nodes, edges, ego("a-b", "b-c", lane=3), "-x", "own.con.xml")
    frame, route = framed(config)
    assert [list(one.columns) for one in route] == [[0], [-1, 0]]
    assert off_m(frame, route) < 0.3


LENGTHS_M = st.lists(st.tuples(st.sampled_from([0.5, 4.0, 12.0, 60.0]), st.integers(1, 3), st.floats(-1.9, 1.9)), min_size=2, max_size=6)


@settings(max_examples=25, deadline=None)
@given(pieces=LENGTHS_M)
def test_every_chain_of_edges_is_a_road_or_refused_by_name(
    pieces: list[tuple[float, int, float]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    # edges of half a metre, lanes that come and go on either side, turns of more than a right angle; long edges at both ends
    x, y, yaw, nodes, edges = 0.0, 0.0, 0.0, {"n0": (0.0, 0.0)}, []
    for k, (length_m, lanes, turn) in enumerate([(120.0, 2, 0.0), *pieces, (120.0, 1, 0.0)]):
        yaw += turn if length_m > 50.0 else 0.2 * turn
        x, y = x + (length_m + 12.0) * math.cos(yaw), y + (length_m + 12.0) * math.sin(yaw)
        nodes[f"n{k + 1}"] = (x, y)
        edges.append(edge(f"n{k}", f"n{k + 1}", lanes))
    names = [f"n{k}-n{k + 1}" for k in range(len(edges))]
    config = network(tmp_path_factory.mktemp("chain"), nodes, edges, ego(*names))
    refused = ""
    try:
        frame, route = framed(config)
    except InputError as error:
        refused = str(error)
    if refused:  # where edges of half a metre lie askew
        assert "turns back here as no car does" in refused
        return
    for s_m in np.arange(0.0, frame.end_m, 50.0):
        road = frame.road_at(float(s_m))
        assert any(road.lane_width_at(lane, float(s_m)) > 2.0 for lane in range(-road.lanes_right, road.lanes_left + 1))
    begins = [section.begin_m for section in frame.sections]
    assert begins == sorted(begins)
    assert off_m(frame, route) < 10.0


def test_a_lane_that_ends_to_both_sides_is_passed_on_the_side_that_comes_first(tmp_path: Path) -> None:
    # the column that goes along most of the way begins two lanes to the right of the first edge's, and ends to its right
    along_m = (0.0, 150.0, 300.0, 450.0, 600.0, 850.0, 1000.0, 1150.0)
    nodes = {name: (x, 0.0) for name, x in zip("abcdefgh", along_m, strict=True)}
    names = ["a-b", "b-c", "c-d", "d-e", "e-f", "f-g", "g-h"]
    edges = [edge(*name.split("-"), lanes) for name, lanes in zip(names, (2, 3, 4, 3, 1, 2, 1), strict=True)]
    joined = [((0, 1), (1, 2)), ((0, 1), (1, 2), (2, 3)), ((0, 0), (1, 1), (2, 2)), ((0, 0),), ((0, 1),), ((0, 0),)]
    ways = [(a, b, i, j) for a, b, pairs in zip(names, names[1:], joined, strict=False) for i, j in pairs]
    links = "".join(f'<connection from="{a}" to="{b}" fromLane="{i}" toLane="{j}"/>' for a, b, i, j in ways)
    (tmp_path / "own.con.xml").write_text(f"<connections>{links}</connections>", "utf-8")
    frame, route = framed(network(tmp_path, nodes, edges, ego(*names), "-x", "own.con.xml"))
    assert [list(one.columns) for one in route] == [[0, 1], [-1, 0, 1], [-2, -1, 0, 1], [-2, -1, 0], [-2], [-3, -2], [-3]]
    assert frame.base == -2
    sides = [next(lane.merges for lane in frame.road_at(s_m).lanes if lane.lane == 0) for s_m in (150.0, 450.0, 950.0)]
    assert sides == [Side.LEFT, Side.RIGHT, Side.RIGHT]


def test_the_line_goes_through_the_middle_of_a_junction_with_a_place_to_wait(tmp_path: Path) -> None:
    # who turns left waits inside: the way through is two lanes, the second of which was left out
    nodes = {"m": (0.0, 0.0), "w": (-150.0, 0.0), "e": (150.0, 0.0), "n": (0.0, 150.0), "s": (0.0, -150.0)}
    edges = [edge(a, "m", 3) for a in "wens"] + [edge("m", a, 3) for a in "wens"]
    config = network(tmp_path, nodes, edges, ego("w-m", "m-n", lane=2), "--tls.set", "m", "--default.junctions.radius", "20")
    frame, _ = framed(config)
    with started(config, 1) as sumo:
        link = next(link for link in sumo.lane.getLinks("w-m_2") if str(link[0]).startswith("m-n"))
        inside = [np.array(sumo.lane.getShape(lane))[:, :2] for lane in lanes_inside(sumo.lane, str(link[4]))]
    assert len(inside) == 2
    shape = np.concatenate(inside)
    _, d, _ = frame.to_road(shape[:, 0], shape[:, 1], np.zeros(len(shape)))
    assert float(np.abs(d).max()) < 1.0


def test_a_route_that_turns_back_as_no_car_does_is_refused_by_name(tmp_path: Path) -> None:
    nodes = {"a": (0.0, 0.0), "b": (30.0, 0.0), "z": (-200.0, 0.0)}
    there_and_back = ("a-b", "b-a", "a-b", "b-a", "a-z")
    config = network(tmp_path, nodes, [edge("a", "b"), edge("b", "a"), edge("a", "z")], ego(*there_and_back))
    with pytest.raises(InputError, match=r"SUMO network: a-b: .* turns back here as no car does"):
        framed(config)


def test_a_sharp_turn_with_few_points_is_kept_whole(tmp_path: Path) -> None:
    # of the pieces along a route, only the beginning that lies before the end of the one before is left out
    nodes = {"a": (0.0, 0.0), "b": (120.0, 0.0), "c": (90.0, 60.0), "d": (90.0, 260.0)}
    config = network(tmp_path, nodes, [edge("a", "b"), edge("b", "c"), edge("c", "d")], ego("a-b", "b-c", "c-d"))
    frame, route = framed(config)
    assert off_m(frame, route) < 2.0
    before, after = np.array([[0.0, 0.0], [10.0, 0.0]]), np.array([[9.0, 0.0], [12.0, 0.0], [2.0, 20.0], [-20.0, 20.0]])
    points = even([before, after])
    np.testing.assert_allclose(points[-1], [-20.0, 20.0])
    assert float(np.hypot(*np.diff(points, axis=0).T).max()) < 1.1
    assert np.all(np.diff(points[:12, 0]) > 0.0)


def test_lanes_of_oncoming_traffic_on_edges_that_meet_make_a_road(tmp_path: Path) -> None:
    nodes = {"a": (0.0, 0.0), "b": (60.0, 0.0), "c": (120.0, 0.0)}
    edges = [edge("a", "b"), edge("b", "c"), edge("c", "b"), edge("b", "a")]
    config = network(tmp_path, nodes, edges, ego("a-b", "b-c"), "--no-internal-links")
    frame, route = framed(config)
    assert all(one.oncoming for one in route)
    assert abs(frame.sections[0].end_m - frame.sections[1].begin_m) < 0.5
    road = frame.road_at(30.0)
    assert road.lane_width_at(1, 30.0) == pytest.approx(3.2)
    assert road.lane_width_at(1, 90.0) == pytest.approx(3.2)


def test_a_window_that_begins_in_a_turn_is_a_road(tmp_path: Path) -> None:
    # beyond the window its first curvature went on, around lanes of the edge before the turn that are wider than any edge in it
    found = 0
    for length_m in (88.0, 92.0, 96.0, 100.0, 104.0):
        nodes = {"west": (0.0, 0.0), "turn": (length_m, 0.0), "north": (length_m, 400.0)}
        edges = [edge("west", "turn", 3), edge("turn", "west", 3), edge("turn", "north"), edge("north", "turn")]
        lefts = '<connections><connection from="west-turn" to="turn-north" fromLane="2" toLane="0"/></connections>'
        (tmp_path / "own.con.xml").write_text(lefts, "utf-8")
        frame, _ = framed(network(tmp_path, nodes, edges, ego("west-turn", "turn-north", lane=2), "-x", "own.con.xml"))
        roads = [frame.road_at(s_m) for s_m in np.arange(5.0, frame.end_m, 5.0).tolist()]
        found += any(abs(frame.curvature_at(s_m)) > 0.05 and s_m > 0.0 for s_m in np.arange(0.0, frame.end_m, 100.0).tolist())
        for road in roads:
            assert road.curvature[0][1] == road.curvature[-1][1] == 0.0
    assert found >= 2


def test_a_long_edge_that_turns_is_a_road(tmp_path: Path) -> None:
    # a loop of 760 m in one edge: more than the 300 m around a place within which its foot on the line is looked for
    turns = [(120.0 * math.sin(u), 120.0 * (1.0 - math.cos(u))) for u in np.linspace(0.1, 1.5 * math.pi, 60)]
    shape = " ".join(f"{x:.2f},{y:.2f}" for x, y in [(-100.0, 0.0), (0.0, 0.0), *turns, (-120.0, 0.0)])
    nodes = {"a": (-100.0, 0.0), "b": (-120.0, 0.0), "c": (-120.0, -200.0)}
    loop = f'<edge id="a-b" from="a" to="b" numLanes="1" speed="13.9" shape="{shape}"/>'
    frame, route = framed(network(tmp_path, nodes, [loop, edge("b", "c")], ego("a-b", "b-c")))
    assert frame.end_m > 850.0
    assert off_m(frame, route) < 0.5


def test_an_exit_two_lanes_over_is_taken_and_the_way_on_two_lanes_back(tmp_path: Path) -> None:
    nodes = {"a": (0.0, 0.0), "b": (600.0, 0.0), "c": (700.0, -8.0), "d": (1000.0, -8.0), "e": (1200.0, -8.0), "far": (1500.0, 60.0)}
    lanes = {"a-b": 3, "b-c": 1, "c-d": 3, "d-e": 1, "b-far": 2}
    edges = [edge(*name.split("-"), number, more='speed="13.9" spreadType="center"') for name, number in lanes.items()]
    ways = (("a-b", "b-c", 0, 0), ("a-b", "b-far", 1, 0), ("a-b", "b-far", 2, 1), ("b-c", "c-d", 0, 0), ("c-d", "d-e", 2, 0))
    links = "".join(f'<connection from="{a}" to="{b}" fromLane="{i}" toLane="{j}"/>' for a, b, i, j in ways)
    (tmp_path / "own.con.xml").write_text(f"<connections>{links}</connections>", "utf-8")
    route = ("a-b", "b-c", "c-d", "d-e")
    config = network(tmp_path, nodes, edges, ego(*route, lane=2), "-x", "own.con.xml")
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver, least_mps, roads = SumoDriver(sumo, "ego"), math.inf, set()
        for _ in range(1000):
            if not driver.step():
                break
            least_mps = min(least_mps, driver.snapshots[-1].host.speed_mps)
            roads |= {sumo.vehicle.getLaneID("ego")}
    assert {"a-b_0", "b-c_0", "c-d_0", "c-d_2", "d-e_0"} <= roads
    assert driver.ended == "arrived"
    assert least_mps > 6.0
