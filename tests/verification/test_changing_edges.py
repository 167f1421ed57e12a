"""Edges that change along the road: the judge against shapely."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.edges import knots_inside
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners
from mcdas_opt.simulation.contact import surroundings
from tests.verification.rollouts import BENDS, changing, legal, names, straight_on


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**9))
@pytest.mark.parametrize("bend", BENDS, ids=["straight", "curved"])
def test_what_passes_is_on_the_surface_and_what_fails_is_not(seed: int, bend: tuple[tuple[float, float], ...]) -> None:
    road = changing(seed, bend)
    free = Road(shoulder_left_m=60.0, shoulder_right_m=60.0, curvature=bend)
    drive = legal(seed, free)
    frame = FrenetFrame(road=road, s_min_m=-100.0, s_max_m=300.0)
    assert road.edges is not None
    s = np.union1d(np.arange(-60.0, 250.0, 0.25), road.edges.table[0])
    zero = np.zeros(s.size)
    left, right = (np.column_stack(frame.to_plane(s, np.asarray(d), zero)[:2]) for d in (road.left_edge_at(s), road.right_edge_at(s)))
    surface = shapely.Polygon([*left, *right[::-1]])
    x = drive.trajectory
    bodies = [shapely.Polygon(four) for four in corners(*frame.to_plane(x.s_m, x.d_m, x.heading_rad), 4.5, 1.8)]
    verdict = drive.verdict(road=road)
    if verdict.passed:
        assert all(surface.buffer(0.03).covers(body) for body in bodies)
    else:
        assert set(names(verdict)) <= {"left road edge", "right road edge"}
        driven = drive.verdict(road=free)
        assert driven.passed
    if not all(surface.buffer(0.1).covers(body) for body in bodies):
        assert not verdict.passed
    if all(surface.buffer(-0.15).covers(body) for body in bodies):
        assert verdict.passed
    states = x.table[1:7].T
    beyond = surroundings(states, (), (), drive.vehicle, road).beyond_edge_m
    outside = np.array([not surface.buffer(0.03).covers(body) for body in bodies])
    assert np.all(beyond[outside] > 0.0)


def test_an_edge_that_pokes_into_the_flank_is_seen_though_no_corner_is_beyond() -> None:
    """A closed stretch shorter than the car, beside its middle."""
    drive = legal(3, Road(shoulder_left_m=60.0, shoulder_right_m=60.0), duration_s=0.2)
    s, d = float(drive.trajectory.s_m[0]), float(drive.trajectory.d_m[0])
    left = d + 0.6  # less than half the width
    poke = Lane(lane=1, closed_m=((s - 0.1, s + 0.1),))
    road = Road(lane_width_m=2.0 * left, lanes_left=1, lanes_right=20, lanes=(poke,))
    verdict = drive.verdict(road=road)
    assert "left road edge" in names(verdict)
    assert drive.verdict(road=replace(road, lanes=(Lane(lane=1, closed_m=((s + 90.0, s + 91.0),)),))).passed


def test_who_is_folded_back_onto_a_bend_is_off_the_road_whatever_else_is_wrong() -> None:
    """Twice the bend's radius inside it the frame finds the lane again: the samples' own d tells, though the start was told before."""
    standing = straight_on(0.0)
    drive = standing.with_columns(d_m=standing.trajectory.d_m + 40.0)
    closed = Lane(lane=1, closed_m=((20.0, 30.0),))
    road = Road(lanes_left=1, shoulder_left_m=10.0, shoulder_right_m=10.0, curvature=((0.0, 0.05),), lanes=(closed,))
    assert names(drive.verdict(road=road)) == ["start position", "left road edge"] == names(drive.verdict(road=replace(road, lanes=())))


def test_an_edge_far_ahead_is_in_no_body_in_a_bend() -> None:
    """Where the road bends tightly, an edge elsewhere may lie as far aside as the bend's centre does here."""
    bend = ((0.0, 0.0), (4.0, 0.0), (8.0, 0.154), (14.0, 0.154), (20.0, 0.0))
    lanes = (Lane(lane=1, width_m=((40.0, 0.0), (60.0, 4.9), (62.0, 4.95), (64.0, 4.93))),)
    road = Road(lane_width_m=3.5, lanes_left=1, lanes_right=0, lanes=lanes, curvature=bend)
    s = np.arange(8.0, 47.0, 0.2)
    left, right = knots_inside(s, np.full(s.size, 0.2), np.full(s.size, -0.1), Vehicle(), road)
    assert max(left.max(), right.max()) <= 0.0
