"""Out of a tight slot from contact to contact."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mcdas_opt.parking.case_file import slot_case
from mcdas_opt.parking.park import ParkSettings, park
from mcdas_opt.parking.search.contact_search import Crawl, CrawlSettings
from mcdas_opt.parking.search.nodes import Nodes
from mcdas_opt.parking.search.reeds_shepp import along_arc
from mcdas_opt.parking.search.resolution_refinement import LEVELS, Level, beyond_the_wall
from mcdas_opt.parking.world import World

LENGTHS_M = (5.175, 5.4, 5.625)
FLIP = np.array([1.0, -1.0, -1.0])


def crawled(case):
    crawl = Crawl(case, World.of(case), Nodes(case.goal), CrawlSettings())
    return crawl, crawl.run()


@pytest.fixture(scope="module")
def crawls():
    return {length: (slot_case(length), *crawled(slot_case(length))) for length in LENGTHS_M}


@pytest.mark.parametrize("length", LENGTHS_M)
def test_ways_out_keep_the_clearance_and_touch_where_they_turn(crawls, length):
    case, crawl, out = crawls[length]
    world, settings = crawl.world, crawl.settings
    asked = case.limits.clearance_m
    assert out
    for node in out[:3]:
        pose = case.goal
        arcs = crawl.nodes.trail(node)
        assert sum(a.length * b.length < 0.0 for a, b in pairwise(arcs)) >= 3
        for arc, following in pairwise([*arcs, None]):
            shares = np.linspace(0.0, 1.0, max(2, int(abs(arc.length) / 0.004)))
            along = along_arc(np.tile(pose, (shares.size, 1)), np.full(shares.size, arc.curvature), arc.length * shares)
            assert world.clearance(along).min() >= asked - 3e-4
            pose = along[-1]
            if following is not None and following.length * arc.length < 0.0:
                assert world.clearance(pose[None])[0] == pytest.approx(asked + settings.margin_m, abs=5e-4)
        assert pose == pytest.approx(crawl.nodes.pose[node], abs=1e-9)


def test_shorter_slots_take_longer(crawls):
    costs = [crawl.nodes.g[out[0]] for _, crawl, out in crawls.values()]
    assert costs == sorted(costs, reverse=True)


def test_the_mirrored_slot_takes_as_long(crawls):
    case, crawl, out = crawls[LENGTHS_M[-1]]
    obstacles = tuple((outline * FLIP[:2])[::-1] for outline in case.obstacles)
    mirrored, way = crawled(replace(case, start=case.start * FLIP, goal=case.goal * FLIP, obstacles=obstacles, slot=None))
    assert mirrored.nodes.g[way[0]] == pytest.approx(crawl.nodes.g[out[0]], rel=0.05)


def test_a_cap_on_nodes_is_kept():
    case = slot_case(LENGTHS_M[0])
    crawl = Crawl(case, World.of(case), Nodes(case.goal), CrawlSettings(max_nodes=500))
    assert crawl.run() == []
    assert crawl.nodes.count < 3000


def test_the_crawl_alone_parks_where_the_cells_of_the_first_searches_are_too_coarse():
    case = slot_case(5.06)
    coarse, fine = ([level] for level in (LEVELS[0], next(level for level in LEVELS if level.crawls)))
    assert park(case, "search", settings=ParkSettings(levels=tuple(fine))).verdict.passed
    assert not park(case, "search", settings=ParkSettings(levels=(*coarse,))).verdict.passed


def test_beyond_the_wall_nothing_crawls():
    case = slot_case(4.9)
    assert beyond_the_wall(case)
    refused = park(case, "search", settings=ParkSettings(levels=(Level(0.03, 300, True, crawls=True),), time_budget_s=30.0))
    assert refused.status == "refused"
    assert refused.nodes == 0
