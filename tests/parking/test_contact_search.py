"""Out of a tight slot from contact to contact."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mcdas_opt.parking.case_file import slot_case
from mcdas_opt.parking.park import park
from mcdas_opt.parking.path import along_arc
from mcdas_opt.parking.search.arc_search import Resolution
from mcdas_opt.parking.search.contact_search import MARGIN_M, ContactSearch
from mcdas_opt.parking.search.nodes import Nodes
from mcdas_opt.parking.search.resolution_refinement import RESOLUTIONS, shorter_than_diagonal
from mcdas_opt.parking.settings import ParkSettings
from mcdas_opt.parking.world import World

LENGTHS_M = (5.175, 5.4, 5.625)
FLIP = np.array([1.0, -1.0, -1.0])


def searched(case):
    done = ContactSearch(case, World.of(case), Nodes(case.goal))
    return done, done.run()


@pytest.fixture(scope="module")
def searches():
    return {length: (slot_case(length), *searched(slot_case(length))) for length in LENGTHS_M}


@pytest.mark.parametrize("length", LENGTHS_M)
def test_exits_keep_the_clearance_and_touch_where_they_turn(searches, length):
    case, done, exits = searches[length]
    world = done.world
    asked = case.limits.clearance_m
    assert exits
    for node in exits[:3]:
        pose = case.goal
        arcs = done.nodes.trail(node)
        assert sum(a.length * b.length < 0.0 for a, b in pairwise(arcs)) >= 3
        for arc, following in pairwise([*arcs, None]):
            shares = np.linspace(0.0, 1.0, max(2, int(abs(arc.length) / 0.004)))
            along = along_arc(np.tile(pose, (shares.size, 1)), np.full(shares.size, arc.curvature), arc.length * shares)
            assert world.clearance(along).min() >= asked - 3e-4
            pose = along[-1]
            if following is not None and following.length * arc.length < 0.0:
                assert world.clearance(pose[None])[0] == pytest.approx(asked + MARGIN_M, abs=5e-4)
        assert pose == pytest.approx(done.nodes.pose[node], abs=1e-9)


def test_shorter_slots_take_longer(searches):
    costs = [done.nodes.g[exits[0]] for _, done, exits in searches.values()]
    assert costs == sorted(costs, reverse=True)


def test_the_mirrored_slot_takes_as_long(searches):
    case, done, exits = searches[LENGTHS_M[-1]]
    obstacles = tuple((outline * FLIP[:2])[::-1] for outline in case.obstacles)
    mirrored, others = searched(replace(case, start=case.start * FLIP, goal=case.goal * FLIP, obstacles=obstacles, slot=None))
    assert mirrored.nodes.g[others[0]] == pytest.approx(done.nodes.g[exits[0]], rel=0.05)


def test_a_cap_on_nodes_is_kept():
    case = slot_case(LENGTHS_M[0])
    done = ContactSearch(case, World.of(case), Nodes(case.goal), max_nodes=500)
    assert done.run() == []
    assert done.nodes.count < 3000


def test_the_contact_search_alone_parks_where_the_cells_of_the_first_searches_are_too_coarse():
    case = slot_case(5.06)
    coarse, fine = ([one] for one in (RESOLUTIONS[0], next(one for one in RESOLUTIONS if one.contact_search)))
    assert park(case, "search", settings=ParkSettings(resolutions=tuple(fine))).verdict.passed
    assert not park(case, "search", settings=ParkSettings(resolutions=(*coarse,))).verdict.passed


def test_in_a_slot_shorter_than_the_diagonal_nothing_is_searched_so_finely():
    case = slot_case(4.9)
    assert shorter_than_diagonal(case)
    fine = Resolution(cell_m=0.03, max_nodes=300, contacts_only=True, contact_search=True)
    refused = park(case, "search", settings=ParkSettings(resolutions=(fine,), time_budget_s=30.0))
    assert refused.status == "refused"
    assert refused.nodes == 0
