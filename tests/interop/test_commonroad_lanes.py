"""Lanelets as lanes along our road, and goals as destinations: scenarios written here."""

from __future__ import annotations

import itertools
import math
import warnings
from pathlib import Path

import numpy as np
import pytest
import shapely
import shapely.affinity

from mcdas_opt.interop.commonroad.scenario import CommonRoadScene, read_scenario
from mcdas_opt.interop.commonroad.solution import goal_reached_s
from mcdas_opt.simulation.loop import simulate

pytest.importorskip("commonroad")
pytest.importorskip("defusedxml")
WIDTH = 3.5


@pytest.fixture(autouse=True)
def quiet() -> None:
    warnings.simplefilter("ignore")


def lanelet(
    identifier: int, lane: int, begin: float, end: float, *, after: int = 0, left: int = 0, right: int = 0, onto: int | None = None
) -> str:
    """A straight lanelet eastwards in a lane (1 is to the left of 0), which ends up in lane `onto`, narrowing; `after` is its successor."""
    to = lane if onto is None else onto

    def bound(side: str, offset: float) -> str:
        turned = 1.0 if end > begin else -1.0  # westwards
        rows = [
            (x, WIDTH * (lane + (to - lane) * (x - begin) / (end - begin)) + turned * offset) for x in np.linspace(begin, end, 9).tolist()
        ]
        return f"<{side}Bound>{''.join(f'<point><x>{x}</x><y>{y}</y></point>' for x, y in rows)}</{side}Bound>"

    following = f'<successor ref="{after}"/>' if after else ""
    beside = "".join(f'<adjacent{side} ref="{ref}" drivingDir="same"/>' for side, ref in (("Left", left), ("Right", right)) if ref)
    bounds = bound("left", 0.5 * WIDTH) + bound("right", -0.5 * WIDTH)
    return f'<lanelet id="{identifier}">{bounds}{following}{beside}<laneletType>urban</laneletType></lanelet>'


def read(
    folder: Path,
    lanelets: list[str],
    *,
    goal_x: float = 0.0,
    goal_y: float = 0.0,
    steps: tuple[int, int],
    y: float = 0.0,
    named: tuple[int, ...] = (),
    goal_yaw: float = 0.0,
    besides: str = "",
) -> CommonRoadScene:
    turned = f"<length>20</length><width>3</width><orientation>{goal_yaw}</orientation>"
    area = f"<rectangle>{turned}<center><x>{goal_x}</x><y>{goal_y}</y></center></rectangle>"
    area = "".join(f'<lanelet ref="{identifier}"/>' for identifier in named) or area
    window = f"<time><intervalStart>{steps[0]}</intervalStart><intervalEnd>{steps[1]}</intervalEnd></time>"
    state = (
        f"<initialState><position><point><x>0</x><y>{y}</y></point></position><orientation><exact>0</exact></orientation><time><exact>0</exact>"
        "</time><velocity><exact>12</exact></velocity><yawRate><exact>0</exact></yawRate><slipAngle><exact>0</exact></slipAngle></initialState>"
    )
    path = folder / "own.xml"
    path.write_text(
        '<?xml version="1.0"?><commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Own-1_1_T-1" timeStepSize="0.1" author="a" '
        'affiliation="b" source="c" date="2026-11-22"><location><geoNameId>-999</geoNameId><gpsLatitude>999</gpsLatitude>'
        "<gpsLongitude>999</gpsLongitude></location><scenarioTags><urban/></scenarioTags>"
        + "".join(lanelets)
        + f'<planningProblem id="9">{state}<goalState><position>{area}</position>{besides}{window}</goalState></planningProblem>'
        + "</commonRoad>",
        "utf-8",
    )
    return read_scenario(path)


BESIDE_ENDS = [lanelet(1, 0, -60, 100, after=3, left=2), lanelet(2, 1, -60, 100, right=1), lanelet(3, 0, 100, 300)]
OWN_ENDS = [lanelet(1, 0, -60, 100, left=2), lanelet(2, 1, -60, 100, after=4, right=1), lanelet(4, 1, 100, 300)]
SPLIT_AND_BEGIN = [lanelet(1, 0, -60, 100, after=3), lanelet(3, 0, 100, 300, right=5), lanelet(5, -1, 100, 300, left=3)]


def test_a_lane_beside_that_leads_nowhere_ends(tmp_path: Path) -> None:
    road = read(tmp_path, BESIDE_ENDS, goal_x=150.0, goal_y=0.0, steps=(100, 140)).scene.true_road
    assert road.has_lane(1, 50.0)
    assert not road.has_lane(1, 110.0)
    assert road.lane_ends_m(1, 0.0, 1.8) == pytest.approx(100.0, abs=4.0)
    assert road.lane_ends_m(0, 0.0, 1.8) == np.inf
    assert float(road.left_edge_at(50.0)) == pytest.approx(1.5 * WIDTH, abs=0.1)
    assert float(road.left_edge_at(150.0)) == pytest.approx(0.5 * WIDTH, abs=0.3)


def test_where_the_own_lane_leads_nowhere_the_road_goes_on_with_the_one_beside_it(tmp_path: Path) -> None:
    scene = read(tmp_path, OWN_ENDS, goal_x=180.0, goal_y=WIDTH, steps=(120, 160))
    road = scene.scene.true_road
    assert scene.lanelets == (1, 4)
    assert scene.map_end_s_m == pytest.approx(300.0, abs=2.0)
    assert road.lane_ends_m(0, 0.0, 1.8) == pytest.approx(100.0, abs=4.0)
    assert road.has_lane(1, 200.0)
    assert road.lane_centre_m(1, 200.0) == pytest.approx(WIDTH, abs=0.1)
    assert float(road.right_edge_at(200.0)) == pytest.approx(0.5 * WIDTH, abs=0.3)
    there = scene.scene.destination_to_reach
    assert there is not None
    assert there.s_m == pytest.approx((170.0, 190.0), abs=0.5)
    assert (there.lane, there.time_s) == (1, (12.0, 16.0))


@pytest.mark.parametrize(("ends_m", "is_followed"), [(100.0, True), (60.0, False)])
def test_where_the_own_lane_turns_off_the_road_follows_the_one_beside_it_that_leads_to_the_goal_if_there_is_time(
    tmp_path: Path, ends_m: float, is_followed: bool
) -> None:
    lanelets = [
        lanelet(1, 0, -60, ends_m, after=3, left=2),
        lanelet(2, 1, -60, ends_m, after=4, right=1),
        lanelet(3, 0, ends_m, 300, onto=-9),
        lanelet(4, 1, ends_m, 300),
    ]
    found = read(tmp_path, lanelets, named=(4,), steps=(120, 130))
    host, road = found.scene.host, found.scene.true_road
    if not is_followed:
        assert found.lanelets == (1, 3)
        assert "off the ego's road" in found.goal_is_off
        return
    assert found.lanelets == (2, 4)
    assert (road.lane_of(host.d_m, 0.0), found.goal_is_off) == (-1, "")
    assert road.lane_ends_m(-1, 0.0, 1.6) == pytest.approx(ends_m, abs=5.0)
    assert found.scene.destination_to_reach is not None
    assert found.scene.destination_to_reach.lane == 0
    drive = simulate(found.scene, "mpc")
    assert (drive.outcome.value, drive.fallbacks) == ("safe", 0)
    assert goal_reached_s(found, drive.trajectory) is not None


def test_a_lane_begins(tmp_path: Path) -> None:
    road = read(tmp_path, SPLIT_AND_BEGIN, goal_x=200.0, goal_y=0.0, steps=(100, 200)).scene.true_road
    assert not road.has_lane(-1, 50.0)
    assert road.has_lane(-1, 120.0, 250.0)


@pytest.mark.parametrize(
    ("mouth", "goal_lane", "begins_m"),
    [((20.0, 100.0), -1, 20.0), ((20.0, 60.0), -1, 100.0), ((20.0, 100.0), 0, 100.0), (None, -1, 100.0), ((100.0, 20.0), -1, 100.0)],
)
def test_a_lane_on_the_way_to_the_goal_begins_where_there_is_ground_for_it(
    tmp_path: Path, mouth: tuple[float, float] | None, goal_lane: int, begins_m: float
) -> None:
    """Another one's lanelet, not said to be beside the ego's, lies there: all the way up to the lane, or not, or towards the ego."""
    ground = [] if mouth is None else [lanelet(7, -1, *mouth)]
    road = read(tmp_path, [*SPLIT_AND_BEGIN, *ground], goal_x=200.0, goal_y=WIDTH * goal_lane, steps=(100, 200)).scene.true_road
    assert road.has_lane(-1, begins_m + 4.0, 250.0)
    assert not road.has_lane(-1, begins_m - 4.0)
    assert float(road.right_edge_at(200.0)) == pytest.approx(-1.5 * WIDTH, abs=0.1)
    assert float(road.right_edge_at(10.0)) == pytest.approx(-0.5 * WIDTH, abs=0.3)


def test_the_host_is_on_the_road_though_its_body_is_over_its_lanelets_edge(tmp_path: Path) -> None:
    road = read(tmp_path, [lanelet(1, 0, -60, 300)], goal_x=90.0, goal_y=0.0, steps=(50, 90), y=-1.2).scene.true_road
    assert float(road.right_edge_at(0.0)) < -1.2 - 0.8
    assert float(road.right_edge_at(60.0)) == pytest.approx(-0.5 * WIDTH, abs=0.3)


@pytest.mark.parametrize(
    ("goal", "steps", "said"),
    [((-40.0, 0.0), (10, 90), "behind the host"), ((90.0, 40.0), (10, 90), "off the ego's road"), ((280.0, 0.0), (0, 1), "")],
)
def test_a_goal_that_cannot_be_had_is_said_to_be_so(tmp_path: Path, goal: tuple[float, float], steps: tuple[int, int], said: str) -> None:
    scene = read(tmp_path, [lanelet(1, 0, -60, 300)], goal_x=goal[0], goal_y=goal[1], steps=steps)
    assert said in scene.goal_is_off
    assert scene.scene.destination_to_reach is None
    assert scene.goal_is_off


def interval(name: str, low: float, high: float) -> str:
    return f"<{name}><intervalStart>{low}</intervalStart><intervalEnd>{high}</intervalEnd></{name}>"


def test_lanelets_of_a_goal_that_follow_one_another_are_one_place_and_its_lane_is_the_nearest(tmp_path: Path) -> None:
    lanelets = [*SPLIT_AND_BEGIN[:2], lanelet(5, -1, 100, 300, left=3)]
    there = read(tmp_path, lanelets, steps=(70, 90), named=(5, 3, 1)).scene.destination_to_reach
    assert there is not None
    assert there.lane == 0
    assert there.s_m == pytest.approx((-60.0, 300.0), abs=1.0)
    assert there.d_m is None


def test_a_goals_speed_and_orientation_are_the_destinations_and_commonroad_says_whether_it_is_reached(tmp_path: Path) -> None:
    besides = interval("orientation", -0.2, 0.1) + interval("velocity", 6.0, 9.0)
    scene = read(tmp_path, [lanelet(1, 0, -60, 300)], goal_x=90.0, goal_y=0.4, steps=(83, 93), besides=besides)
    there = scene.scene.destination_to_reach
    assert there is not None
    assert (there.speed_mps, there.time_s) == ((6.0, 9.0), (8.3, 9.3))
    assert there.d_m == pytest.approx((-1.1, 1.9), abs=0.05)
    assert there.heading_rad == pytest.approx((-0.2, 0.1), abs=0.01)
    drive = simulate(scene.scene)
    assert drive.destination == "reached"
    reached_s = goal_reached_s(scene, drive.trajectory)
    assert reached_s is not None
    assert 8.3 <= reached_s <= 9.3


@pytest.mark.parametrize("yaw", [0.0, 1e-9, 0.1, -0.4, 0.8, 1.2, math.pi / 2, 2.5])
@pytest.mark.parametrize("goal_y", [0.0, 0.7])
def test_who_is_where_the_destination_asks_is_in_the_goals_area_however_it_lies_across_the_road(
    tmp_path: Path, yaw: float, goal_y: float
) -> None:
    scene = read(tmp_path, [lanelet(1, 0, -60, 300)], goal_x=90.0, goal_y=goal_y, goal_yaw=yaw, steps=(60, 90))
    there = scene.scene.destination_to_reach
    assert there is not None
    assert there.s_m is not None
    assert there.d_m is not None
    assert there.d_m[0] < -0.2 < 0.2 < there.d_m[1]  # who keeps the lane's middle is there
    assert there.s_m[1] - there.s_m[0] > 1.0
    area = shapely.affinity.rotate(shapely.box(80.0, goal_y - 1.5, 100.0, goal_y + 1.5), yaw, use_radians=True)
    for s, d in itertools.product(there.s_m, there.d_m):
        assert area.buffer(1e-6).contains(shapely.Point(s, d))
    if abs(yaw) < 0.01:
        assert there.s_m == pytest.approx((80.0, 100.0), abs=0.05)


def test_a_goal_of_one_moment_is_reached_at_that_moment(tmp_path: Path) -> None:
    """28 steps of 0.1 s are 2.8000000000000003 s."""
    scene = read(tmp_path, [lanelet(1, 0, -60, 300)], steps=(28, 28), named=(1,))
    drive = simulate(scene.scene)
    assert (drive.destination, drive.destination_reached_s, goal_reached_s(scene, drive.trajectory)) == ("reached", 2.8, 2.8)


@pytest.mark.parametrize(("begin", "end", "theirs"), [(300, -60, True), (-60, 300, False)])
def test_ground_beside_the_lanes_is_an_oncoming_lane_where_its_lanelets_come_towards_the_host(
    tmp_path: Path, begin: float, end: float, theirs: bool
) -> None:
    """No lanelet is said to be adjacent."""
    road = read(tmp_path, [lanelet(1, 0, -60, 300), lanelet(2, 1, begin, end)], goal_x=60.0, steps=(60, 80)).scene.true_road
    (beside,) = (lane for lane in road.lanes if lane.lane == 1)
    assert beside.shoulder
    assert beside.oncoming is theirs
