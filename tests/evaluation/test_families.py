"""Families: the same seed gives the same scenes, within their ranges; nobody overlaps, nobody brakes beyond the grip."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.families import Family, load_family, suites_folder
from mcdas_opt.simulation.neighbours import Traffic

COUNT = 40


@pytest.fixture(scope="module", params=["sandwich", "striking-rear", "benign"])
def family(request: pytest.FixtureRequest) -> Family:
    return load_family(request.param)


def test_a_scene_depends_on_its_seed_and_index_alone(family: Family) -> None:
    many = family.scenes(COUNT, seed=4)
    assert many[7] == family.scene(7, seed=4)
    assert many[7] != family.scene(7, seed=5)
    assert len({scene.model_dump_json() for scene in many}) == COUNT
    assert len({scene.seed for scene in many}) == COUNT


def test_scenes_keep_to_their_ranges(family: Family) -> None:
    for scene in family.scenes(COUNT, seed=1):
        host, length = scene.host.speed_mps, scene.vehicle.length_m
        grip = scene.road.friction * GRAVITY_MPS2
        assert 8.0 <= host <= 33.0
        assert scene.road.friction in (0.9, 0.5, 0.25)
        named = {part.name: part for part in scene.neighbour}
        for part in scene.neighbour:
            for piece in part.motion:
                assert -grip - 1e-9 <= (piece.acceleration_mps2 or 0.0) <= 0.0
        if family.name in ("sandwich", "striking-rear"):
            rear = named["rear"]
            assert rear.s_m is not None
            assert rear.speed_mps is not None
            assert 3.0 - 1e-9 <= -rear.s_m - length <= 40.0
            assert 0.0 <= rear.speed_mps - host <= (12.0 if family.name == "sandwich" else 15.0)
        assert ("front" in named) == (family.name != "striking-rear")
        sides = [part for name, part in named.items() if name.startswith(("left", "right"))]
        for part in sides:
            assert part.speed_mps is not None
            assert 0.7 * host - 1e-9 <= part.speed_mps <= 1.2 * host + 1e-9
            assert abs(part.d_m or 0.0) == scene.road.lane_width_m


def test_cars_of_a_next_lane_never_run_through_one_another(family: Family) -> None:
    times = np.linspace(0.0, family.duration_s, 30)
    for scene in family.scenes(COUNT, seed=2):
        for side in ("left", "right"):
            lane = [part for part in scene.neighbour if part.name.startswith(side)]
            places = [np.array([(part.s_m or 0.0) + (part.speed_mps or 0.0) * t for t in times]) for part in lane]
            for behind, ahead in pairwise(places):
                assert np.all(ahead - behind >= 4.5)


def test_benign_neighbours_follow() -> None:
    scenes = load_family("benign").scenes(5, seed=1)
    assert all(Traffic(scene).reacts for scene in scenes)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (("slower_mps = { low = 0.0, high = 15.0 }", "slower_mps = { low = 3.0, high = 1.0 }"), "front.slower_mps"),
        (("[rear]", "[raer]"), "raer"),
        (("gap_m = { low = 5.0, high = 60.0 }", ""), "front"),
    ],
)
def test_a_bad_family_is_told_with_file_and_key(tmp_path: Path, change: tuple[str, str], key: str) -> None:
    text = (suites_folder() / "sandwich.toml").read_text(encoding="utf-8")
    assert change[0] in text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(*change), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_family(path)
    assert "mine.toml" in str(caught.value)
    assert key in caught.value.key


def test_an_unknown_family_names_the_nearest() -> None:
    with pytest.raises(InputError, match="sandwich"):
        load_family("sandwitch")
