"""A lanelet's middle and width, whatever vertices its sides are drawn with; roads from maps that are drawn carelessly."""

from __future__ import annotations

import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.errors import ParameterError
from mcdas_opt.interop.commonroad.lane_middle import lane_middle
from mcdas_opt.interop.commonroad.scenario import read_scenario
from mcdas_opt.interop.commonroad.solution import goal_reached_s, solution

pytest.importorskip("commonroad")
WIDTH = 3.5
SCENARIO = (
    '<?xml version="1.0"?><commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Own-1_1_T-1" timeStepSize="0.1" author="a" '
    'affiliation="b" source="c" date="2026-11-22"><location><geoNameId>-999</geoNameId><gpsLatitude>999</gpsLatitude>'
    "<gpsLongitude>999</gpsLongitude></location><scenarioTags><urban/></scenarioTags>{lanelets}"
    '<planningProblem id="9"><initialState><position><point><x>{x}</x><y>{y}</y></point></position><orientation><exact>0</exact>'
    "</orientation><time><exact>0</exact></time><velocity><exact>8</exact></velocity><yawRate><exact>0</exact></yawRate><slipAngle>"
    "<exact>0</exact></slipAngle></initialState><goalState><position>{goal}</position><time><intervalStart>1</intervalStart>"
    "<intervalEnd>300</intervalEnd></time></goalState></planningProblem></commonRoad>"
)


def drawn(left: Array, right: Array) -> Any:
    return SimpleNamespace(left_vertices=left, right_vertices=right, center_vertices=0.5 * (left + right))


def bound(side: str, points: Array) -> str:
    return f"<{side}Bound>{''.join(f'<point><x>{x!r}</x><y>{y!r}</y></point>' for x, y in points.tolist())}</{side}Bound>"


def lanelet(identifier: int, left: Array, right: Array, besides: str = "") -> str:
    return f'<lanelet id="{identifier}">{bound("left", left)}{bound("right", right)}{besides}<laneletType>urban</laneletType></lanelet>'


def straight(begin: float, end: float, y: float) -> Array:
    x = np.linspace(begin, end, 9)
    return np.column_stack([x, np.full(x.size, y)])


def read(folder: Path, lanelets: str, *, x: float = 0.0, y: float = 0.0, goal: str = '<lanelet ref="1"/>') -> Any:
    path = folder / "own.xml"
    path.write_text(SCENARIO.format(lanelets=lanelets, x=x, y=y, goal=goal), "utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return read_scenario(path)


@given(
    st.floats(20.0, 200.0),
    st.floats(2.5, 6.0),
    st.floats(-np.pi, np.pi),
    st.floats(-0.02, 0.02),
    st.lists(st.floats(0.02, 0.98), min_size=3, max_size=12, unique=True),
    st.lists(st.floats(0.02, 0.98), min_size=3, max_size=12, unique=True),
)
def test_vertices_that_do_not_face_one_another_change_neither_middle_nor_width(
    length: float, width: float, yaw: float, kappa: float, on_left: list[float], on_right: list[float]
) -> None:
    most = min(len(on_left), len(on_right))
    kept: list[Array] = []
    for offset, shares in ((0.5 * width, on_left), (-0.5 * width, on_right)):
        fine = length * np.unique([0.0, *shares[:most], *np.linspace(0.0, 1.0, 60), 1.0])  # an arc is drawn finely, however the rest is
        theta = kappa * fine
        along = np.where(abs(kappa) < 1e-6, fine, np.sin(theta) / (kappa or 1.0))
        across = np.where(abs(kappa) < 1e-6, 0.0, (1.0 - np.cos(theta)) / (kappa or 1.0))
        x, y = along - offset * np.sin(theta), across + offset * np.cos(theta)
        kept.append(np.column_stack([np.cos(yaw) * x - np.sin(yaw) * y, np.sin(yaw) * x + np.cos(yaw) * y]))
    n = min(map(len, kept))
    left, right = kept[0][[*range(n - 1), -1]], kept[1][[*range(n - 1), -1]]
    middle, widths = lane_middle(drawn(left, right))
    x, y = np.cos(yaw) * middle[:, 0] + np.sin(yaw) * middle[:, 1], -np.sin(yaw) * middle[:, 0] + np.cos(yaw) * middle[:, 1]
    off = y - 0.5 * kappa * x**2 if abs(kappa) < 1e-6 else (1.0 / kappa - np.sign(kappa) * np.hypot(x, y - 1.0 / kappa))
    assert np.abs(off).max() < 0.15
    assert np.abs(widths / width - 1.0).max() < 0.11
    assert np.hypot(*np.diff(middle, axis=0).T).min() > 0.0


def test_vertices_that_face_one_another_are_taken_as_they_are() -> None:
    left, right = straight(0.0, 100.0, 2.0), straight(0.0, 100.0, -1.5)
    middle, widths = lane_middle(drawn(left, right))
    assert np.array_equal(middle, 0.5 * (left + right))
    assert np.array_equal(widths, np.full(9, 3.5))


def test_a_side_that_is_drawn_closely_at_its_beginning_alone_widens_no_lane(tmp_path: Path) -> None:
    left, right = straight(-60.0, 300.0, 0.5 * WIDTH), straight(-60.0, 300.0, -0.5 * WIDTH)
    left[1:-1, 0] = np.linspace(-59.0, -50.0, 7)
    scene = read(tmp_path, lanelet(1, left, right))
    assert scene.lane_off_m < 0.05
    assert scene.scene.true_road.lane_width_m == pytest.approx(WIDTH, abs=0.01)
    assert float(scene.scene.true_road.left_edge_at(150.0)) == pytest.approx(0.5 * WIDTH, abs=0.05)


def sign(value: str) -> str:
    element = f"<trafficSignElement><trafficSignID>274</trafficSignID><additionalValue>{value}</additionalValue></trafficSignElement>"
    return f'<trafficSign id="7">{element}<position><point><x>0</x><y>0</y></point></position><virtual>false</virtual></trafficSign>'


@pytest.mark.parametrize(
    ("value", "limit_mps"),
    [("12.5", 12.5), ("50kmh", 50.0 / 3.6), ("80 km/h", 80.0 / 3.6), ("30mph", 30 * 0.44704), ("13 m/s", 13.0), ("walk", 36.0)],
)
def test_a_limit_is_in_metres_a_second_unless_the_map_says_otherwise(tmp_path: Path, value: str, limit_mps: float) -> None:
    own = lanelet(1, straight(-60.0, 300.0, 0.5 * WIDTH), straight(-60.0, 300.0, -0.5 * WIDTH), '<trafficSignRef ref="7"/>')
    road = read(tmp_path, own + sign(value)).scene.true_road
    assert road.limits_from(0, 0.0)[0][1] == pytest.approx(limit_mps)


@pytest.mark.parametrize(("x", "y"), [(-60.2, 0.0), (0.0, 1.9), (0.0, -1.9)])
def test_an_ego_that_stands_a_hand_beside_its_lanelet_is_on_it(tmp_path: Path, x: float, y: float) -> None:
    scene = read(tmp_path, lanelet(1, straight(-60.0, 300.0, 0.5 * WIDTH), straight(-60.0, 300.0, -0.5 * WIDTH)), x=x, y=y)
    assert scene.lanelets == (1,)


def test_a_lane_that_opens_abruptly_keeps_those_beyond_it(tmp_path: Path) -> None:
    """Lane 1 is 1 m wide and at once 6 m wide; lane 2 lies beyond it."""

    def beside(left: int, right: int, after: int) -> str:
        sides = "".join(f'<adjacent{side} ref="{ref}" drivingDir="same"/>' for side, ref in (("Left", left), ("Right", right)) if ref)
        return (f'<successor ref="{after}"/>' if after else "") + sides

    edges = [-0.5 * WIDTH, 0.5 * WIDTH, 0.5 * WIDTH + 1.0, 1.5 * WIDTH + 1.0]
    wide = [-0.5 * WIDTH, 0.5 * WIDTH, 0.5 * WIDTH + 6.0, 1.5 * WIDTH + 6.0]
    lanelets = ""
    for first, begin, end, at, after in ((1, -60.0, 80.0, edges, 4), (4, 80.0, 300.0, wide, 0)):
        for k in range(3):
            neighbours = beside(first + k + 1 if k < 2 else 0, first + k - 1 if k else 0, after + k if after else 0)
            lanelets += lanelet(first + k, straight(begin, end, at[k + 1]), straight(begin, end, at[k]), neighbours)
    road = read(tmp_path, lanelets, goal='<lanelet ref="4"/>').scene.true_road
    assert road.lanes_left >= 2
    assert road.has_lane(1, 150.0)
    assert road.has_lane(2, 40.0)
    assert road.has_lane(2, 150.0)


def test_a_goal_after_a_full_turn_lies_ahead_though_the_road_passes_it_twice(tmp_path: Path) -> None:
    """A ramp that turns by 360 degrees and crosses above its own beginning: its last lanelet lies there too."""
    radius = 20.0
    theta = np.linspace(0.0, 2.0 * np.pi, 81)

    def ring(offset: float) -> Array:
        return np.column_stack([60.0 + (radius - offset) * np.sin(theta), radius - (radius - offset) * np.cos(theta)])

    half = 0.5 * WIDTH
    lanelets = lanelet(1, straight(-60.0, 60.0, half), straight(-60.0, 60.0, -half), '<successor ref="2"/>')
    lanelets += lanelet(2, ring(half), ring(-half), '<successor ref="3"/>')
    lanelets += lanelet(3, straight(60.0, 260.0, half), straight(60.0, 260.0, -half))
    scene = read(tmp_path, lanelets, goal='<lanelet ref="3"/>')
    there = scene.scene.destination_to_reach
    assert scene.goal_is_off == ""
    assert there is not None
    begin = 60.0 + 2.0 * np.pi * radius
    assert there.s_m == pytest.approx((begin, begin + 200.0), abs=6.0)


def test_a_drive_that_ends_at_once_reaches_no_goal_and_is_no_solution(tmp_path: Path) -> None:
    own = lanelet(1, straight(-60.0, 100.0, 0.5 * WIDTH), straight(-60.0, 100.0, -0.5 * WIDTH), '<successor ref="2"/>')
    after = lanelet(2, straight(100.0, 300.0, 0.5 * WIDTH), straight(100.0, 300.0, -0.5 * WIDTH))
    scene = read(tmp_path, own + after, goal='<lanelet ref="2"/>')
    at_once = Trajectory.from_states(np.zeros(1), np.array([[0.0, 0.0, 0.0, 8.0, 0.0, 0.0]]), np.zeros((0, 2)))
    assert goal_reached_s(scene, at_once) is None
    with pytest.raises(ParameterError, match="must last a time step"):
        solution(scene, at_once)
