"""CommonRoad's obstacles against what its own reader has occupied."""

from __future__ import annotations

import math
import re
import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from mcdas_opt.errors import InputError
from mcdas_opt.geometry.rectangle import corners
from mcdas_opt.interop.commonroad import library
from mcdas_opt.interop.commonroad.scenario import CommonRoadScene, read_scenario
from mcdas_opt.simulation.neighbours import Traffic
from tests.interop.test_commonroad import place, scenario

pytest.importorskip("commonroad")
pytest.importorskip("defusedxml")

POINTS = ((-1.0, -1.0), (4.0, -1.5), (3.0, 0.5), (-1.0, 1.0))
SHAPES = {
    "rectangle": "<rectangle><length>4.0</length><width>1.5</width>{}</rectangle>",
    "circle": "<circle><radius>1.2</radius>{}</circle>",
    "polygon": f"<polygon>{''.join(f'<point><x>{x}</x><y>{y}</y></point>' for x, y in POINTS)}</polygon>",
}
CENTRE, QUARTER, TURN = "<center><x>2.0</x><y>1.0</y></center>", math.pi / 2.0, "<orientation>{}</orientation>"
SLANTED = SHAPES["rectangle"].format(TURN.format(0.4))
GROUP = SHAPES["circle"].format("") + SHAPES["rectangle"].format(CENTRE)


@pytest.fixture(autouse=True)
def quiet() -> None:
    warnings.simplefilter("ignore")


def read(folder: Path, old: str, new: str) -> tuple[CommonRoadScene, dict[int, object]]:
    """A scenario of ours with something in its obstacles replaced; and the reader's own obstacles."""
    path = folder / "own.xml"
    text = re.sub(old, new, scenario(), flags=re.S)
    assert text != scenario()
    path.write_text(text, "utf-8")
    theirs, _ = library.read_file(path)
    return read_scenario(path), {one.obstacle_id: one for one in theirs.obstacles}


@pytest.mark.parametrize(
    ("shape", "exact"),
    [
        (SHAPES["rectangle"].format(CENTRE), True),
        (SHAPES["rectangle"].format(TURN.format(QUARTER) + CENTRE), True),
        (SLANTED, False),
        (SHAPES["circle"].format(CENTRE), False),
        (SHAPES["polygon"], False),
        (GROUP, False),
    ],
)
def test_a_body_is_the_box_about_what_the_reader_has_occupied(tmp_path: Path, shape: str, exact: bool) -> None:
    shapely = pytest.importorskip("shapely")
    found, theirs = read(tmp_path, "<shape>.*?</shape>", f"<shape>{shape}</shape>")
    assert found.left_out == {}
    for part, identifier in zip(found.scene.neighbour, found.obstacles.values(), strict=True):
        for t, s, d, psi, _ in part.samples if len(part.samples) > 2 else part.samples[:1]:
            x, y, yaw = found.placement.to_plane(*found.frame.to_plane(*(np.array([q]) for q in (s, d, psi))))
            body = shapely.Polygon(corners(x, y, yaw, part.length_m, part.width_m)[0])
            occupied = theirs[identifier].occupancy_at_time(round(10 * t)).shape
            parts = getattr(occupied, "shapes", [occupied])  # the reader's own outline of a circle has half its radius
            covered = shapely.unary_union(
                [shapely.Point(one.center).buffer(one.radius) if hasattr(one, "radius") else one.shapely_object for one in parts]
            )
            assert body.buffer(1e-3).covers(covered)
            ends = np.array(body.exterior.coords)
            sides = [shapely.LineString(pair).distance(covered) for pair in pairwise(ends)]
            assert max(sides) < 0.01  # no larger than it has to be
            if exact or (identifier == 8 and shape == SLANTED):
                assert body.symmetric_difference(covered).area < 1e-6


def test_a_dynamic_obstacle_without_a_trajectory_goes_on_as_it_began_and_a_standing_one_stands(tmp_path: Path) -> None:
    for speed in (8.0, 0.0):
        began = f"<velocity><exact>{speed}</exact></velocity></initialState></dynamicObstacle>"
        found, _ = read(tmp_path, r"<velocity><exact>8.0</exact></velocity></initialState>\s*<trajectory>.*?</dynamicObstacle>", began)
        assert (found.obstacles, found.left_out) == ({"obstacle-7": 7, "obstacle-8": 8}, {})
        motion = Traffic(found.scene).motions(np.array([0.0, 1.0, 3.5]))[0]
        assert motion.s_m == pytest.approx(30.0 + speed * np.array([0.0, 1.0, 3.5]), abs=1e-6)
        assert motion.d_m == pytest.approx(0.0, abs=1e-6)


def test_an_uncertain_place_is_all_of_it(tmp_path: Path) -> None:
    x, y = place(62.0, 5.0)
    circle = f"<position><circle><radius>0.5</radius><center><x>{x}</x><y>{y}</y></center></circle></position>"
    turned = "<orientation><intervalStart>0.7</intervalStart><intervalEnd>0.9</intervalEnd></orientation>"
    found, theirs = read(tmp_path, r'(<staticObstacle id="8">.*?<initialState>)<position>.*?</orientation>', rf"\1{circle}{turned}")
    part, occupied = found.scene.neighbour[1], theirs[8].initial_state
    assert occupied.is_uncertain_position
    assert part.samples[0, 1:4] == pytest.approx([62.0, 5.0, 0.3], abs=1e-6)
    assert part.length_m > 5.3
    assert part.width_m > 2.6


def test_an_obstacle_that_jumps_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"own\.xml: obstacle-7: line \d+ = .*: jumps by"):
        read(tmp_path, r"(<trajectory><state><position><point><x>)[^<]*", r"\g<1>80.0")
