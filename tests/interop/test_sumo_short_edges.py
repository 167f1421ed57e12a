"""Edges of a few metres, as maps have them between the parts of a junction: nobody changes lanes on them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from mcdas_opt.interop.sumo.columns import column_past_others
from mcdas_opt.interop.sumo.connection import started
from mcdas_opt.interop.sumo.driver import SumoDriver
from mcdas_opt.interop.sumo.episode import EpisodeSettings, wait_for
from mcdas_opt.interop.sumo.polylines import led_over, length_m
from mcdas_opt.interop.sumo.route import Edge, Lane
from tests.interop.sumo_configuration import edge, ego, framed, network

pytest.importorskip("libsumo")

Ways = tuple[tuple[str, str, int, int], ...]


def linked(folder: Path, nodes: dict[str, tuple[float, float]], lanes: dict[str, int], ways: Ways, route: str) -> Path:
    """A network with these links alone, and an ego in lane 0 of its route."""
    links = "".join(f'<connection from="{a}" to="{b}" fromLane="{i}" toLane="{j}"/>' for a, b, i, j in ways)
    (folder / "own.con.xml").write_text(f"<connections>{links}</connections>", "utf-8")
    edges = [edge(*name.split("-"), number) for name, number in lanes.items()]
    return network(folder, nodes, edges, ego(*route.split()), "-x", "own.con.xml")


def driven(config: Path) -> tuple[SumoDriver, float]:
    """The drive of the ego, and its least speed."""
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        driver, least_mps = SumoDriver(sumo, "ego"), math.inf
        while driver.step() and driver.snapshots[-1].time_s < 90.0:
            least_mps = min(least_mps, driver.snapshots[-1].host.speed_mps)
        return driver, least_mps


@pytest.mark.parametrize(("left_first", "entered", "leading"), [(True, 1, 0), (False, 0, 1)])
def test_two_turns_with_a_lane_between_them_are_driven_in_one(left_first: bool, entered: int, leading: int, tmp_path: Path) -> None:
    # the lane that the first turn leads to turns off the route 15 m later; the one beside it leads on
    side = 1.0 if left_first else -1.0
    nodes = {"a": (-150.0, 0.0), "b": (0.0, 0.0), "c": (0.0, 32.0 * side), "d": (150.0, 32.0 * side), "off": (-60.0, 32.0 * side)}
    lanes = {"a-b": 1, "b-c": 2, "c-d": 1, "c-off": 1}
    ways = (("a-b", "b-c", 0, entered), ("b-c", "c-d", leading, 0), ("b-c", "c-off", 1 - leading, 0))
    config = linked(tmp_path, nodes, lanes, ways, "a-b b-c c-d")
    frame, route = framed(config)
    assert length_m(route[1].lanes[0].shape) < 30.0
    assert route[0].lanes[0].leads_over == leading - entered
    assert [(lane.id, lane.goes_on) for lane in route[1].lanes if lane.column == 0] == [(f"b-c_{leading}", True)]
    ends = np.array([route[0].lanes[0].shape[-1], route[2].lanes[0].shape[0]])
    _, d, _ = frame.to_road(ends[:, 0], ends[:, 1], np.zeros(2))
    assert float(np.abs(d).max()) < 1.5
    driver, least_mps = driven(config)
    assert driver.ended == "arrived"
    assert least_mps > 2.5
    assert driver.summary.fallbacks == 0


def test_lanes_that_end_on_a_short_edge_end_before_it(tmp_path: Path) -> None:
    # lane 0 is an exit; of the others one leads on, three lanes over, behind an edge of some metres
    nodes = {"a": (0.0, 0.0), "b": (250.0, 0.0), "c": (262.0, 0.0), "d": (500.0, 0.0), "out": (350.0, -60.0), "off": (350.0, -40.0)}
    lanes = {"a-b": 4, "b-c": 3, "c-d": 1, "b-out": 1, "c-off": 2}
    ways: Ways = (("a-b", "b-out", 0, 0), *(("a-b", "b-c", i, i - 1) for i in (1, 2, 3)))
    ways += (("b-c", "c-off", 0, 0), ("b-c", "c-off", 1, 1), ("b-c", "c-d", 2, 0))
    config = linked(tmp_path, nodes, lanes, ways, "a-b b-c c-d")
    _, route = framed(config)
    assert length_m(route[1].lanes[0].shape) < 30.0
    assert [lane.goes_on for lane in route[0].lanes] == [False, False, False, True]
    driver, least_mps = driven(config)
    assert driver.ended == "arrived"
    assert least_mps > 5.0


def test_of_the_lanes_that_one_leads_to_one_that_goes_on_is_taken(tmp_path: Path) -> None:
    nodes = {"a": (0.0, 0.0), "b": (100.0, 0.0), "c": (200.0, 0.0), "d": (400.0, 0.0), "off": (260.0, -60.0)}
    lanes = {"a-b": 1, "b-c": 3, "c-d": 2, "c-off": 1}
    ways: Ways = (*(("a-b", "b-c", 0, k) for k in range(3)), ("b-c", "c-off", 0, 0), ("b-c", "c-d", 1, 0), ("b-c", "c-d", 2, 1))
    _, route = framed(linked(tmp_path, nodes, lanes, ways, "a-b b-c c-d"))
    assert [(lane.id, lane.column, lane.goes_on) for lane in route[1].lanes] == [
        ("b-c_0", -1, False),
        ("b-c_1", 0, True),
        ("b-c_2", 1, True),
    ]


def edge_of(*lanes: int, on: tuple[int, ...], begin_m: float) -> Edge:
    """100 m with lanes of these columns, of which those lead on."""
    shape = np.array([[begin_m, 0.0], [begin_m + 100.0, 0.0]])
    usual = {"shape": shape, "width_m": 3.2, "limit_mps": 13.9, "via": ""}
    return Edge(id="one", lanes=tuple(Lane(id="", column=k, goes_on=k in on, **usual) for k in lanes))  # type: ignore[arg-type]


def test_the_base_moves_past_others_once_the_lane_that_leads_on_is_there() -> None:
    early = edge_of(0, 1, on=(0, 1), begin_m=0.0)
    late = [edge_of(0, 1, 2, 3, on=(1, 2, 3), begin_m=100.0), edge_of(1, 2, 3, on=(3,), begin_m=200.0), edge_of(3, on=(3,), begin_m=300.0)]
    assert column_past_others(late, 0) == 3
    assert column_past_others([early, *late], 0) == 0
    assert column_past_others(late[:1], 0) == 0


def test_polylines_are_led_over_from_the_first_to_the_last() -> None:
    first, last = np.array([[0.0, 0.0], [20.0, 0.0]]), np.array([[20.0, 3.0], [30.0, 3.0]])
    led = np.concatenate(led_over([first, last], 3.0))
    np.testing.assert_allclose(led[[0, -1]], [[0.0, 0.0], [30.0, 3.0]], atol=1e-9)
    assert np.all(np.diff(led[:, 1]) >= -1e-9)
    assert float(np.abs(np.diff(led[:, 1])).max()) < 0.2
