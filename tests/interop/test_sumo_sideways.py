"""Where a map moves all lanes sideways at once, within a few metres: SUMO's vehicles jump, and the planner sees lanes that lead on."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.rules import Array
from mcdas_opt.interop.sumo.connection import started
from mcdas_opt.interop.sumo.driver import SumoDriver
from mcdas_opt.interop.sumo.episode import EpisodeSettings, wait_for
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.interop.sumo.route import Edge
from mcdas_opt.interop.sumo.sideways import SidewaysSteps
from tests.interop.sumo_configuration import edge, ego, framed, network

pytest.importorskip("libsumo")

CENTRED = 'speed="27.8" spreadType="center"'
NODES = {"a": (0.0, 0.0), "b": (400.0, 0.0), "c": (800.0, 0.0), "d": (1200.0, 0.0)}
NAMES = ("a-b", "b-c", "c-d")


def widening(folder: Path, others: str = "", lanes: int = 3) -> Path:
    """Two lanes, then more, then two, each time around the same middle: all step sideways, by half a lane for each that begins."""
    edges = [edge(*name.split("-"), number, more=CENTRED) for name, number in zip(NAMES, (2, lanes, 2), strict=True)]
    links = [f'<connection from="{a}" to="{b}" fromLane="{i}" toLane="{i}"/>' for a, b in pairwise(NAMES) for i in (0, 1)]
    (folder / "own.con.xml").write_text(f"<connections>{''.join(links)}</connections>", "utf-8")
    return network(folder, NODES, edges, ego(*NAMES) + others, "-x", "own.con.xml")


def off_m(frame: RoadFrame, route: tuple[Edge, ...]) -> float:
    """How far, at most, the middles of lanes lie from where the road has them, from one end of each edge to the other."""
    most = 0.0
    for section, one in zip(frame.sections, route, strict=True):
        for lane in one.lanes:
            along = np.linspace(0.0, 1.0, 200)[:, None]
            points = lane.shape[0] + along * (lane.shape[-1] - lane.shape[0])
            s, d, _ = frame.to_road(points[:, 0], points[:, 1], np.zeros(200), near_s_m=0.5 * (section.begin_m + section.end_m))
            most = max(most, *(abs(float(at) - frame.centre_m(lane.column, float(s_m))) for s_m, at in zip(s, d, strict=True)))
    return most


def straight(begin: tuple[float, float], long_m: float) -> Array:
    return np.array([begin, (begin[0] + long_m, begin[1])])


@given(
    left_m=st.floats(0.25, 4.4),
    mirrored=st.booleans(),
    slope=st.floats(0.16, 3.0),
    limit_mps=st.floats(5.0, 40.0),
    lengths_m=st.tuples(st.floats(20.0, 600.0), st.floats(20.0, 600.0)),
)
def test_the_line_passes_a_step_as_a_car_could(
    left_m: float, mirrored: bool, slope: float, limit_mps: float, lengths_m: tuple[float, float]
) -> None:
    along_m, left_m = left_m / slope, -left_m if mirrored else left_m
    pieces = [straight((0.0, 0.0), lengths_m[0]), straight((lengths_m[0] + along_m, left_m), lengths_m[1])]
    steps = SidewaysSteps(pieces, [limit_mps, limit_mps])
    assert steps.at(0)
    line = np.concatenate([steps.passed(0), steps.passed(1)])
    assert np.all(np.diff(line[:, 0]) > 0.0)
    apart_m = 6.0  # the line has a point every 2 m
    across = np.interp(np.arange(0.0, line[-1, 0], apart_m), line[:, 0], line[:, 1])
    assert float(np.abs(np.diff(across, 2)).max(initial=0.0)) / apart_m**2 * limit_mps**2 < 1.25
    half_m = limit_mps * math.sqrt(0.5 * math.pi * abs(left_m))
    if min(lengths_m) > half_m:
        np.testing.assert_allclose(line[[0, -1], 1], [0.0, left_m], atol=1e-9)


@given(left_m=st.floats(-4.0, 4.0), slope=st.floats(0.0, 0.14), turn=st.floats(-0.15, 0.15))
def test_what_a_car_can_follow_is_left_as_it_is(left_m: float, slope: float, turn: float) -> None:
    along_m = abs(left_m) / max(slope, 1e-2)
    way = np.array([math.cos(turn), math.sin(turn)])
    first, begin = straight((0.0, 0.0), 100.0), np.array([100.0, 0.0]) + along_m * way + left_m * np.array([-way[1], way[0]])
    pieces = [first, np.array([begin, begin + 100.0 * np.array([math.cos(2.0 * turn), math.sin(2.0 * turn)])])]
    steps = SidewaysSteps(pieces, [20.0, 20.0])
    assert not steps.at(0)
    assert steps.passed(0) is pieces[0]
    assert not list(steps.moved([[], []]))


def test_lanes_are_where_the_road_has_them_from_end_to_end(tmp_path: Path) -> None:
    frame, route = framed(widening(tmp_path))
    assert off_m(frame, route) < 0.15
    kappa = max(abs(frame.curvature_at(float(s))) for s in np.arange(0.0, frame.end_m, 1.0))
    assert 1e-4 < kappa < 1.2 / 27.8**2


def test_places_come_back_through_a_step(tmp_path: Path) -> None:
    frame, _ = framed(widening(tmp_path))
    for s in (300.0, 397.0, 399.5, 401.0, 420.0, 900.0):
        x, y, yaw = frame.to_plane(s, 0.7, 0.05)
        back = frame.to_road(np.array([x]), np.array([y]), np.array([yaw]), near_s_m=s)
        np.testing.assert_allclose([float(one[0]) for one in back], [s, 0.7, 0.05], atol=1e-6)


@pytest.mark.parametrize("lanes", [3, 4])
def test_the_vehicle_drives_straight_on_beside_others_through_a_step(lanes: int, tmp_path: Path) -> None:
    lorry = '<vType id="lorry" length="16.5" width="2.5" maxSpeed="22" lcKeepRight="0"/>'
    beside = (
        '<vehicle id="beside" type="lorry" depart="0" departLane="1" departPos="20" departSpeed="20"><route edges="a-b b-c c-d"/></vehicle>'
    )
    ahead = '<vehicle id="ahead" depart="0" departLane="0" departPos="60" departSpeed="20"><route edges="a-b b-c c-d"/></vehicle>'
    config = widening(tmp_path, lorry + beside + ahead, lanes)
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver, seen, hardest_mps2 = SumoDriver(sumo, "ego"), set(), 0.0
        while driver.step():
            now = driver.snapshots[-1]
            hardest_mps2 = min(hardest_mps2, now.host.acceleration_mps2)
            assert abs(now.host.d_m - driver.frame.centre_m(now.host.lane, now.host.s_m)) < 2.0
            for track in driver.situation().tracks:
                seen.add(track.id)
                assert abs(track.speed_d_mps) < 3.0
                assert track.heading_rad is None or abs(track.heading_rad) < 0.1
    assert seen == {"beside", "ahead"}
    assert driver.ended == "arrived"
    assert not driver.contacts
    assert hardest_mps2 > -2.5


def test_the_line_goes_on_in_its_lane_where_an_exit_begins_beside_it(tmp_path: Path) -> None:
    # the right lane leads to itself, and to one that begins to its right: the first link that SUMO gives is the one to the right
    edges = [edge("a", "b", 2, more='speed="27.8"'), edge("b", "c", 3, more='speed="27.8"')]
    links = "".join(f'<connection from="a-b" to="b-c" fromLane="{i}" toLane="{j}"/>' for i, j in ((0, 0), (0, 1), (1, 2)))
    (tmp_path / "own.con.xml").write_text(f"<connections>{links}</connections>", "utf-8")
    frame, route = framed(network(tmp_path, NODES, edges, ego("a-b", "b-c"), "-x", "own.con.xml"))
    assert [list(one.columns) for one in route] == [[0, 1], [-1, 0, 1]]
    assert off_m(frame, route) < 0.15
