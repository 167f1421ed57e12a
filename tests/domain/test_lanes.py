"""Lanes along the road: borders and edges as laws, and what is refused."""

from __future__ import annotations

import tracemalloc
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.document import from_document, to_document
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.lane_borders import STEERED, Edges, _steered
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import InputError, ParameterError
from tests.planning.situations import mirrored_road

S = np.arange(-50.0, 500.0, 0.5)


def random_road(seed: int) -> Road:
    """Up to two lanes to each side, of which some begin, end, narrow or are closed; one stays."""
    rng = np.random.default_rng(seed)
    left, right = (int(n) for n in rng.integers(0, 3, 2))
    lanes, stays = [], int(rng.integers(-right, left + 1))
    for k in range(-right, left + 1):
        if k == stays or rng.random() < 0.3:
            continue
        begin, length = rng.uniform(20.0, 200.0), rng.uniform(15.0, 80.0)
        widths = ((begin, 3.7), (begin + length, float(rng.choice([0.0, 2.8, 4.5]))))
        if rng.random() < 0.3:
            widths = tuple((s, width) for (s, _), (_, width) in zip(widths, reversed(widths), strict=True))
        is_edge = k in (-right, left) and k != 0
        closed = ((begin, begin + 30.0),) if is_edge and rng.random() < 0.3 else ()
        lanes.append(Lane(lane=k, width_m=widths, closed_m=closed, merges=merging(rng, k, left, right)))
    shoulders = [float(w) for w in rng.choice([0.0, 2.5], 2)]
    return Road(lanes_left=left, lanes_right=right, shoulder_left_m=shoulders[0], shoulder_right_m=shoulders[1], lanes=tuple(lanes))


def merging(rng: np.random.Generator, lane: int, left: int, right: int) -> Side:
    sides = [side for side, there in ((Side.LEFT, left), (Side.RIGHT, right)) if there]
    return Side.NONE if lane or not sides else sides[int(rng.integers(len(sides)))]


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**9))
def test_lanes_lie_side_by_side_and_their_borders_are_the_edges(seed: int) -> None:
    road = random_road(seed)
    for s in np.random.default_rng(seed).uniform(-50.0, 400.0, 10).tolist():
        numbers = range(-road.lanes_right, road.lanes_left + 1)
        widths = [road.lane_width_at(k, s) for k in numbers]
        centres = [road.lane_centre_m(k, s) for k in numbers]
        for k in range(len(widths) - 1):  # neither overlap nor hole
            assert centres[k + 1] - centres[k] == pytest.approx(0.5 * (widths[k] + widths[k + 1]), abs=1e-9)
        for number, width, centre in zip(numbers, widths, centres, strict=True):
            if width > 0.1:
                assert road.lane_of(centre, s) == number
        closed = any(begin - 1.0 <= s <= end + 1.0 for lane in road.lanes for begin, end in lane.closed_m)
        if not closed:
            assert float(road.left_edge_at(s)) == pytest.approx(centres[-1] + 0.5 * widths[-1] + road.shoulder_left_m, abs=1e-9)
            assert float(road.right_edge_at(s)) == pytest.approx(centres[0] - 0.5 * widths[0] - road.shoulder_right_m, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**9))
def test_what_plans_are_made_with_lies_inside_and_can_be_followed(seed: int) -> None:
    edges, steered = random_road(seed).edges, random_road(seed).steered_edges
    if edges is None or steered is None:
        return
    assert np.all(steered.left(S) <= edges.left(S) + 1e-9)
    assert np.all(steered.right(S) >= edges.right(S) - 1e-9)
    for side in (steered.left(S), steered.right(S)):
        assert np.abs(np.diff(side)).max() <= STEERED * 0.5 + 1e-9


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**9), shift=st.floats(-1000.0, 1000.0))
def test_a_road_seen_from_elsewhere_and_in_the_mirror_is_the_same(seed: int, shift: float) -> None:
    road = random_road(seed)
    moved, image = road.seen_from(shift), mirrored_road(road)
    for s in (10.0, 75.0, 140.0, 260.0):
        assert float(moved.left_edge_at(s - shift)) == pytest.approx(float(road.left_edge_at(s)), abs=1e-6)
        assert float(image.left_edge_at(s)) == -float(road.right_edge_at(s))
        for lane in range(-road.lanes_right, road.lanes_left + 1):
            assert moved.has_lane(lane, s - shift) == road.has_lane(lane, s) == image.has_lane(-lane, s)
            assert image.lane_ends_m(-lane, s, 1.8) == road.lane_ends_m(lane, s, 1.8)


def test_a_lane_that_says_nothing_new_is_left_out() -> None:
    plain = Road(lanes_left=1, lanes_right=1)
    said = replace(
        plain, lanes=(Lane(lane=0, merges=Side.LEFT), Lane(lane=1, width_m=((0.0, 3.7), (90.0, 3.7)), speed_limit_mps=((0.0, 36.0),)))
    )
    assert said == plain
    assert said.edges is None


def test_where_a_lane_ends_and_its_limits() -> None:
    lane = Lane(lane=1, width_m=((100.0, 3.7), (200.0, 0.0)), speed_limit_mps=((0.0, 30.0), (50.0, 20.0)), closed_m=((300.0, 310.0),))
    road = Road(lanes_left=1, lanes=(lane,))
    assert road.lane_ends_m(1, 0.0, 1.85) == pytest.approx(150.0)
    assert road.lane_ends_m(1, 160.0, 1.85) == -np.inf
    assert road.lane_ends_m(0, 0.0, 1.85) == np.inf
    assert road.has_lane(1, 0.0)
    assert not road.has_lane(1, 0.0, 180.0)
    assert road.limits_from(1, 10.0) == [(10.0, 30.0), (50.0, 20.0)]
    assert road.limits_from(0, 10.0) == [(10.0, 36.0)]
    closed = Road(lanes_left=1, lanes=(Lane(lane=1, closed_m=((300.0, 310.0),)),))
    assert closed.lane_ends_m(1, 0.0, 1.85) == 300.0
    assert float(closed.left_edge_at(305.0)) == pytest.approx(1.85)
    assert float(closed.left_edge_at(320.0)) == pytest.approx(5.55)
    assert not Road(lanes_left=1, lanes=(Lane(lane=1, oncoming=True),)).has_lane(1, 0.0)


@pytest.mark.parametrize(
    ("lanes", "said"),
    [
        ((Lane(lane=1, closed_m=((0.0, 1.0),)), Lane(lane=1)), r"lanes\[1\].lane = 1: is described twice: its pieces overlap"),
        ((Lane(lane=2, oncoming=True),), r"lanes\[0\].lane = 2: is none of the road's: -1 to 1"),
        ((Lane(lane=0, closed_m=((5.0, 9.0),)),), r"merges = 'none': must say to which side"),
        ((Lane(lane=0, width_m=((50.0, 3.7), (50.5, 0.0)), merges=Side.LEFT),), "lane 0: width_m.*leaves a hole beside the lane beyond it"),
    ],
)
def test_lanes_that_overlap_or_leave_a_hole_are_refused(lanes: tuple[Lane, ...], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        Road(lanes_left=1, lanes_right=1, lanes=lanes)


def test_a_road_with_nothing_left_to_drive_on_is_refused() -> None:
    with pytest.raises(ParameterError, match="is where nothing is left to drive on"):
        Road(lanes=(Lane(lane=0, width_m=((50.0, 3.7), (100.0, 0.0))),))


@pytest.mark.parametrize(
    ("lane", "said"),
    [
        ({"lane": True}, "lane = True: must be a whole number"),
        ({"lane": 0, "width_m": [[0.0]]}, r"width_m.*must be a list of \[s_m, width_m\] pairs"),
        ({"lane": 0, "width_m": [[0.0, -1.0]]}, r"width_m = -1.0 m: must lie in \[0, 20\]"),
        ({"lane": 0, "width_m": [[0.0, 3.0], [0.0, 2.0]]}, "s_m must increase"),
        ({"lane": 0, "width_m": [[float("nan"), 3.0]]}, "must be finite"),
        ({"lane": 1, "speed_limit_mps": [[0.0, 0.0]]}, "speed_limit_mps"),
        ({"lane": 1, "closed_m": [[9.0, 5.0]]}, "must begin before it ends"),
        ({"lane": 1, "merges": "left"}, "is said of lane 0 alone"),
        ({"lane": 0, "oncoming": True}, "must not be said of lane 0"),
    ],
)
def test_a_lane_that_is_none_is_refused(lane: dict[str, object], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        Lane(**lane)


def test_a_road_with_lanes_is_a_document_and_back() -> None:
    road = random_road(7)
    assert road.lanes
    assert from_document(Road, to_document(road), "road.json") == road
    with pytest.raises(InputError, match=r"road.json: lanes\[0\].lain"):
        from_document(Road, {"lanes": [{"lain": 1}]}, "road.json")


def test_steered_edges_are_the_lowest_cones_over_all_knots() -> None:
    """As brute force finds them, wherever along the road."""
    r = np.random.default_rng(0)
    for k in range(50):
        s = np.unique(np.round(r.uniform(-300.0, 900.0, int(r.integers(2, 30))), 3)) + (0.0, 1e6, -1e5)[k % 3]
        edges = Edges(np.array([s, r.uniform(1.0, 9.0, s.size), -r.uniform(1.0, 9.0, s.size)]))
        places, left, right = _steered(edges).table
        if places.size == s.size:
            continue
        reach = STEERED * np.abs(places[:, None] - s)
        np.testing.assert_allclose(left, np.minimum((edges.left(s) + reach).min(axis=1), edges.left(places)), atol=1e-12)
        np.testing.assert_allclose(right, np.maximum((edges.right(s) - reach).max(axis=1), edges.right(places)), atol=1e-12)


@given(seed=st.integers(0, 10**6), s_m=st.floats(-100.0, 300.0), width_m=st.floats(0.5, 3.6))
def test_a_lane_goes_on_to_the_first_place_where_it_is_too_narrow_or_closed(seed: int, s_m: float, width_m: float) -> None:
    r = np.random.default_rng(seed)
    places = np.cumsum(r.uniform(5.0, 60.0, 6)) - 60.0
    closed = [(float(begin), float(begin + r.uniform(1.0, 20.0))) for begin in np.cumsum(r.uniform(30.0, 200.0, int(r.integers(0, 3))))]
    lane = Lane(lane=1, width_m=tuple(zip(places.tolist(), r.choice([0.0, 2.0, 3.0, 3.7], 6).tolist(), strict=True)), closed_m=closed)
    end = lane.ends_m(s_m, width_m, 3.7)
    ahead = np.linspace(s_m, s_m + 800.0, 40001)
    bad = lane.width_at(ahead, 3.7) < width_m
    for begin, until in closed:
        bad |= (ahead >= begin) & (ahead < until)
    first = ahead[int(np.argmax(bad))] if bad.any() else np.inf
    assert max(end, s_m) == pytest.approx(first, abs=0.03)
    assert (end == -np.inf) == bool(bad[0])


def test_a_lane_that_is_closed_at_s_goes_on_nowhere_wherever_it_narrows_later() -> None:
    for widths in ((), ((500.0, 3.7), (600.0, 0.0)), ((0.0, 3.7), (50.0, 3.0), (120.0, 0.0))):
        lane = Lane(lane=1, width_m=widths, closed_m=((40.0, 80.0),))
        assert [lane.ends_m(s, 1.8, 3.7) for s in (39.0, 40.0, 60.0)] == [40.0, -np.inf, -np.inf]


@given(seed=st.integers(0, 10**6), s_m=st.floats(-100.0, 2000.0), excess=st.floats(0.0, 0.3))
def test_every_speed_limit_ahead_is_braked_for_in_time(seed: int, s_m: float, excess: float) -> None:
    r = np.random.default_rng(seed)
    limits = list(zip(np.cumsum(r.uniform(5.0, 200.0, 9)).tolist(), r.uniform(5.0, 40.0, 9).tolist(), strict=True))
    now = [limit for s, limit in limits if s <= s_m]
    ahead = [((1.0 + excess) * limit) ** 2 + 3.0 * (s - s_m) for s, limit in limits if s > s_m]
    road = Road(lanes=(Lane(lane=0, speed_limit_mps=limits),))
    assert road.limits_from(0, s_m)[1:] == [one for one in limits if one[0] > s_m]
    assert road.limit_mps(0, s_m, excess) ** 2 == pytest.approx(min([((1.0 + excess) * (now or [limits[0][1]])[-1]) ** 2, *ahead]))


def test_thousands_of_closures_take_little_memory() -> None:
    """It grew with the square of them: a scene's file of 100 kB took 3 GB."""
    closed = tuple((100.0 + 2.0 * k, 101.0 + 2.0 * k) for k in range(1500))
    tracemalloc.start()
    road = Road(lanes_left=1, lanes=(Lane(lane=0, closed_m=closed),))
    assert road.steered_edges is not None
    assert tracemalloc.get_traced_memory()[1] < 20e6
    tracemalloc.stop()


@given(place=st.floats(-1e-299, 1e-299), other=st.floats(-1e-299, 1e-299))
def test_places_as_good_as_0_warn_of_nothing(place: float, other: float) -> None:
    """A hostile file's lanes, with knots and closed stretches that differ from 0 by next to nothing."""
    narrow = Lane(lane=-3, width_m=((-6e-5, 1e-4), (place, 1e-8), (217.3, 1e-9)), closed_m=((-6.0, other),))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        road = Road(lanes_left=1, lanes_right=3, lanes=(narrow, Lane(lane=0, closed_m=((-6.0, -place),), merges=Side.RIGHT)))
    assert road.edges is not None
    assert np.isfinite(road.edges.table).all()
